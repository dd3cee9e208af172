// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "haptogram/link/clock.hpp"

namespace haptogram::link {

/// One piece of work at a time, in a thread of its own.
class BackgroundThread {
public:
    /// @param clock  of the work
    explicit BackgroundThread(Clock& clock) : clock_(clock) {}
    BackgroundThread(const BackgroundThread&) = delete;
    BackgroundThread& operator=(const BackgroundThread&) = delete;
    ~BackgroundThread() { end(); }

    /// @throws Error{bad_argument} when something goes on already; Error{cancelled} when end() is called meanwhile;
    ///         what `prepare` does, in this thread
    /// @param prepare  gives the work
    void begin(const std::function<std::function<void()>()>& prepare);
    [[nodiscard]] bool busy() const;
    /// Whether somebody is in end(): the work looks at it.
    [[nodiscard]] bool ending() const { return enders_ > 0; }
    /// @return whether it goes on  @throws what ended it, once
    bool wait(std::chrono::milliseconds patience);
    /// Asks the work to end, and waits for that. What is about to begin does not.
    void end();
    void forget_trouble();
    /// In words, what ended the last work; empty when nothing did, once wait() has thrown it, and when there is new
    /// work.
    [[nodiscard]] std::string trouble() const;

private:
    Clock& clock_;
    mutable std::mutex mutex_;
    std::condition_variable ended_;
    std::mutex beginning_;  // one caller at a time begins or joins
    std::thread thread_;
    std::atomic<unsigned> enders_ = 0;  // callers in end(), so that none is forgotten while another begins
    bool busy_ = false;
    std::exception_ptr trouble_;
};

}  // namespace haptogram::link
