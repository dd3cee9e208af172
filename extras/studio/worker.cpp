// SPDX-License-Identifier: Apache-2.0
#include "worker.hpp"

#include <algorithm>

namespace haptogram::studio {

Worker::Worker() : thread_([this] { run(); }) {}

Worker::~Worker() {
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Worker::ask(std::uint64_t owner, std::function<void()> work) {
    {
        const std::lock_guard lock(mutex_);
        const auto older =
            std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& w) { return w.first == owner; });
        if (older != waiting_.end())
            older->second = std::move(work);
        else
            waiting_.emplace_back(owner, std::move(work));
    }
    changed_.notify_all();
}

void Worker::forget(std::uint64_t owner) {
    const std::lock_guard lock(mutex_);
    std::erase_if(waiting_, [&](const auto& w) { return w.first == owner; });
}

void Worker::run() {
    for (;;) {
        std::function<void()> work;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return over_ || !waiting_.empty(); });
            if (over_) return;
            work = std::move(waiting_.front().second);
            waiting_.pop_front();
        }
        work();
    }
}

}  // namespace haptogram::studio
