// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "haptogram/format/bundle.hpp"
#include "haptogram/link/background_player.hpp"
#include "haptogram/verbs/path_makers.hpp"
#include "osc.hpp"

namespace haptogram::serve {

/// What clients ask the service for, whatever way they come. One client at a time drives the board: the first that asks
/// for something that plays, until it goes. Everybody may ask how it is, and stop it.
class Verbs {
public:
    /// A client, by a number that no other has.
    using Client = std::uint64_t;
    /// Who sends datagrams is where they come from.
    [[nodiscard]] static constexpr Client osc(std::uint32_t address, std::uint16_t port) {
        return by_datagrams | Client{address} << 16 | port;
    }

    explicit Verbs(link::BackgroundPlayer& board, PathMakers makers = {});
    Verbs(const Verbs&) = delete;
    Verbs& operator=(const Verbs&) = delete;
    ~Verbs();

    /// Answers {"do": VERB, …}; asyncapi.json has them. What fails is an answer, too.
    [[nodiscard]] nlohmann::ordered_json answer(const std::string& request, Client client);
    /// Whether a request ends what plays, so that it is never too much.
    [[nodiscard]] static bool ends(const std::string& request);
    /// Four doubles: x, y, z in metres, and the amplitude. @throws Error
    void focus(std::span<const std::uint8_t> bytes, Client client);
    /// Returns at once, except after a stop, which waits for its confirmation. @throws Error
    void act(const OscMessage& message, Client sender);
    /// What went wrong with a message that act() had taken, once; empty when nothing has.
    [[nodiscard]] std::string take_trouble();
    /// When the one that drives goes, the outputs go off.
    void leave(Client client);
    /// Who sends datagrams goes without a word: it has, when it has sent none for a second. To be called often.
    void expire();

private:
    using Json = nlohmann::ordered_json;
    static constexpr Client by_datagrams = Client{1} << 63;

    Json act(const Json& request, Client client);
    Json compile(const Json& request);
    [[nodiscard]] Json identify() const;
    void own(Client client);
    void begin(std::function<void()> work);
    void forget_begun();
    void work();
    void set_focus(Client client, const Focus& focus);
    [[nodiscard]] Json status() const;

    link::BackgroundPlayer& board_;
    PathMakers makers_;  // of a magnitude
    mutable std::mutex mutex_;
    std::optional<Client> owner_;
    link::Clock::Time last_osc_{};
    std::optional<Bundle> image_;
    // What came by datagrams and takes a while: whoever reads them must be free for a stop.
    std::mutex begun_mutex_;
    std::condition_variable news_;
    std::deque<std::function<void()>> begun_;
    std::string trouble_;
    bool over_ = false;
    std::thread worker_;
};

/// An error as an answer: its code, its words, and the settings that could mend it.
[[nodiscard]] nlohmann::ordered_json failure(const std::exception& error);

}  // namespace haptogram::serve
