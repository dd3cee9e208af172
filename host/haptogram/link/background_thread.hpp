// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace haptogram::link {

/// One piece of work at a time, in a thread of its own.
class BackgroundThread {
public:
    BackgroundThread() = default;
    BackgroundThread(const BackgroundThread&) = delete;
    BackgroundThread& operator=(const BackgroundThread&) = delete;
    ~BackgroundThread() { end(); }

    /// @throws Error{bad_argument} when something goes on already; what `prepare` does, in this thread
    /// @param prepare  gives the work
    void begin(const std::function<std::function<void()>()>& prepare);
    [[nodiscard]] bool busy() const;
    /// Whether end() was called since it began: the work looks at it.
    [[nodiscard]] bool ending() const { return end_; }
    /// @return whether it goes on  @throws what ended it, once
    bool wait(std::chrono::milliseconds patience);
    /// Asks the work to end, and waits for that.
    void end();
    void forget_trouble();

private:
    mutable std::mutex mutex_;
    std::condition_variable ended_;
    std::mutex beginning_;  // one caller at a time begins or joins
    std::thread thread_;
    std::atomic<bool> end_ = false;
    bool busy_ = false;
    std::exception_ptr trouble_;
};

}  // namespace haptogram::link
