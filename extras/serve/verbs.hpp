// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

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
    static constexpr Client osc = 0;  ///< all that come by datagrams, which say no more than that they come

    explicit Verbs(link::BackgroundPlayer& board, PathMakers makers = {}) : board_(board), makers_(std::move(makers)) {}

    /// Answers {"do": VERB, …}; asyncapi.json has them. What fails is an answer, too.
    [[nodiscard]] nlohmann::ordered_json answer(const std::string& request, Client client);
    /// Whether a request ends what plays, so that it is never too much.
    [[nodiscard]] static bool ends(const std::string& request);
    /// Four doubles: x, y, z in metres, and the amplitude. @throws Error
    void focus(std::span<const std::uint8_t> bytes, Client client);
    /// @throws Error
    void act(const OscMessage& message);
    /// When the one that drives goes, the outputs go off.
    void leave(Client client);
    /// Who sends datagrams goes without a word: it has, when it has sent none for a second. To be called often.
    void expire();

private:
    using Json = nlohmann::ordered_json;

    Json act(const Json& request, Client client);
    Json compile(const Json& request);
    [[nodiscard]] Json identify() const;
    void own(Client client);
    void set_focus(Client client, const Focus& focus);
    [[nodiscard]] Json status() const;

    link::BackgroundPlayer& board_;
    PathMakers makers_;  // of a magnitude
    mutable std::mutex mutex_;
    std::optional<Client> owner_;
    link::Clock::Time last_osc_{};
    std::optional<Bundle> image_;
};

/// An error as an answer: its code, its words, and the settings that could mend it.
[[nodiscard]] nlohmann::ordered_json failure(const std::exception& error);

}  // namespace haptogram::serve
