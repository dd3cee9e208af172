// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace haptogram::studio {

/// A thread that does work for several owners in turn. Of each owner only the newest work waits: what it asked for
/// before is dropped unless it has begun. What has begun is finished, because a view that moves asks again and again,
/// and would otherwise never get an answer.
class Worker {
public:
    Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;
    /// Drops what waits, and waits for what has begun.
    ~Worker();

    /// Returns at once. @param work  called in the thread; must not throw
    void ask(std::uint64_t owner, std::function<void()> work);
    /// Drops what waits for an owner.
    void forget(std::uint64_t owner);

private:
    void run();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::pair<std::uint64_t, std::function<void()>>> waiting_;
    bool over_ = false;
    std::thread thread_;
};

}  // namespace haptogram::studio
