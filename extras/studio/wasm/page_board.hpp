// SPDX-License-Identifier: Apache-2.0
// The board of a page without a server. The protocol is that of ../../haptogram/link; JavaScript only carries the
// bytes.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/link/step_player.hpp"
#include "messages.hpp"
#include "page_sight.hpp"

namespace haptogram::studio {

/// A serial port that somebody else has, who is only told what is to be done with it.
struct PortDoor {
    std::function<void(std::uint32_t baud)> open;  ///< answered by PageBoard::opened() or PageBoard::lost()
    std::function<void(const link::Bytes&)> write;
    std::function<void()> discard;  ///< what was written and has not gone out yet
    std::function<void(std::chrono::microseconds)> hold_break;
    std::function<void()> close;
};

/// Answers the messages that are about a board. Nothing waits: step() does what is due.
class PageBoard {
public:
    /// @param tell  told every answer
    PageBoard(PortDoor door, std::function<void(const nlohmann::ordered_json&)> tell);

    /// An image that messages may call by the name of its scene. @param hex  as a file
    /// @throws Error{bad_input} when it is none
    void keep(const std::string& scene, std::string_view hex);

    void act(const ConnectMessage& message);
    void act(const DisconnectMessage& message);
    void act(const UploadMessage& message);
    void act(const PlayMessage& message);
    void act(const TriggerMessage& message);
    void act(const StreamMessage& message);
    void act(const IntensityMessage& message);
    void act(const ModulateMessage& message);
    void act(const StopMessage& message);
    void act(const BeatMessage& message) { sight_.beat(message.hidden); }

    // What the port's owner tells.
    void opened();
    void lost(const std::string& why);
    void received(const link::Bytes& bytes);

    void step();

private:
    class Line;
    using NamedImage = std::pair<std::string, std::shared_ptr<const Image>>;
    using Clock = std::chrono::steady_clock;
    struct Stop {
        std::uint32_t n = 0;
        std::uint64_t number = 0;
        Clock::time_point asked{};
    };

    void open_next_rate();
    void tell_device() const;
    void tell_work(const link::StepWork& work);
    void tell_stops();
    void let_go();
    [[nodiscard]] std::shared_ptr<const Image> image_of(const std::string& scene) const;
    [[nodiscard]] link::StepPlayer& player();

    PortDoor door_;
    std::function<void(const nlohmann::ordered_json&)> tell_;
    std::deque<NamedImage> images_;
    std::map<std::uint64_t, std::string> scenes_;  // of work under way, by its number
    std::string port_;                             // "": there is none
    std::vector<std::uint32_t> rates_;             // to be tried, the present one first
    std::size_t tried_ = 0;                        // of them, in vain
    std::string trouble_;                          // that nothing answered at any of them
    bool tries_next_ = false, leaves_ = false;
    double intensity_ = 1.0;
    PageSight sight_{link::machine_clock()};
    std::vector<Stop> stops_;
    Clock::time_point stepped_{};
    link::Bytes arrived_;
    std::unique_ptr<link::StepPlayer> player_;  // while the port is open
};

}  // namespace haptogram::studio
