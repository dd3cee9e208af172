// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>

#include "haptogram/format/bundle.hpp"
#include "haptogram/link/device_thread.hpp"
#include "haptogram/link/intensity.hpp"
#include "haptogram/link/live_focus.hpp"

namespace haptogram::link {

/// How something is played in the background.
struct BackgroundPlay {
    std::optional<std::uint16_t> loops{};  ///< 0: for ever
    std::uint16_t watchdog_ms = 500;
    double seconds = 0.0, step_s = LiveFocusSettings{}.step_s;
    std::string am{};
};

/// A board behind a port, for callers that do not wait: what plays does so in a thread of its own.
class BackgroundPlayer {
public:
    /// @param open  opens the port; called in the thread that drives the board, again after a loss
    /// @throws Error{device} when nobody answers within the patience
    BackgroundPlayer(std::function<std::unique_ptr<Transport>()> open, std::chrono::milliseconds patience);
    BackgroundPlayer(const BackgroundPlayer&) = delete;
    BackgroundPlayer& operator=(const BackgroundPlayer&) = delete;
    /// Turns the outputs off, waiting some two seconds at most.
    ~BackgroundPlayer();

    [[nodiscard]] DeviceState state() const { return device_.state(); }
    /// Whether something plays; of live foci also how many were sent, and the lead.
    [[nodiscard]] std::tuple<bool, std::uint64_t, double> work() const;

    void upload(const Bundle& bundle);
    void play(const BackgroundPlay& how);
    void play_live(const BackgroundPlay& how);
    void set_focus(const Focus& focus) { mailbox_.put(focus); }
    /// @return whether what was begun goes on  @throws what ended it, once
    bool wait(std::chrono::milliseconds patience);
    void stop();
    void shut_off();
    void set_intensity(double factor);

private:
    void begin(std::function<void(Commands&)> work);
    void join();
    void settle();

    FocusMailbox mailbox_;
    DeviceThread device_;
    mutable std::mutex mutex_;
    std::condition_variable ended_;
    std::mutex beginning_;  // one caller at a time begins, ends or joins
    std::thread thread_;
    std::optional<Intensity> intensity_;
    std::atomic<bool> end_ = false;
    bool busy_ = false;
    std::exception_ptr trouble_;
    LiveFocusPlaying live_;
};

}  // namespace haptogram::link
