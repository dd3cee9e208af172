// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdlib>
#include <list>
#include <map>
#include <set>
#include <utility>

#include "haptogram/link/clock.hpp"

namespace haptogram::test {

/// A time that passes only while all threads that live in it wait: then it is at once when the first of them waits for.
/// One thread runs at a time, and always in the same order. So what a test says of time holds exactly, and takes none.
///
/// Whoever makes it runs first. Other threads come from begin(). A thread must not wait in any other way for another
/// one, and so must not rest while it holds a mutex that another one takes.
class VirtualClock final : public link::Clock {
    using Lock = std::unique_lock<std::mutex>;

public:
    [[nodiscard]] Time now() const override {
        const Lock lock(mutex_);
        return now_;
    }
    void rest_until(Time until) override {
        Lock lock(mutex_);
        if (until > now_) yield(lock, {until});
    }
    bool wait_until(Lock& held, std::condition_variable&, Time until, const std::function<bool()>& so) override {
        if (so()) return true;
        held.unlock();
        {
            Lock lock(mutex_);
            yield(lock, {until, &so, held.mutex()});
        }
        held.lock();
        return so();
    }
    [[nodiscard]] std::thread begin(std::function<void()> work) override {
        const Lock lock(mutex_);
        Waiter& first = waiters_.emplace_back(now_);
        std::thread thread([this, &first, work = std::move(work)] {
            {
                Lock turn(mutex_);
                wait_for_turn(turn, first);
            }
            work();
            Lock end(mutex_);
            alive_.erase(std::this_thread::get_id());
            pass_on(end);
        });
        alive_.insert(thread.get_id());
        return thread;
    }
    void join(std::thread& thread) override {
        {
            Lock lock(mutex_);
            const std::function<bool()> over = [&] { return !alive_.contains(thread.get_id()); };
            if (!over()) yield(lock, {Time::max(), &over});
        }
        thread.join();
    }
    /// Has something done then, by whatever thread waits.
    void at(Time when, std::function<void()> event) {
        const Lock lock(mutex_);
        events_.emplace(when, std::move(event));
    }

private:
    struct Waiter {
        Waiter(Time t, const std::function<bool()>* s = nullptr, std::mutex* m = nullptr) : until(t), so(s), of(m) {}
        Time until;
        const std::function<bool()>* so;  ///< it may run before, when that is so
        std::mutex* of;                   ///< which guards that
        bool runs = false;
        std::condition_variable turn{};
    };

    void yield(Lock& lock, Waiter&& wanted) {
        Waiter& self = waiters_.emplace_back(wanted.until, wanted.so, wanted.of);
        pass_on(lock);
        wait_for_turn(lock, self);
    }
    void wait_for_turn(Lock& lock, Waiter& self) {
        self.turn.wait(lock, [&] { return self.runs; });
        waiters_.remove_if([&](const Waiter& one) { return &one == &self; });
    }
    /// Whether it is so; nobody who runs could change it, unless he holds the mutex.
    static bool is_so(const Waiter& waiter) {
        if (waiter.so == nullptr) return false;
        if (waiter.of == nullptr) return (*waiter.so)();
        const Lock lock(*waiter.of, std::try_to_lock);
        return lock.owns_lock() && (*waiter.so)();
    }
    /// Lets the next one run.
    void pass_on(Lock& lock) {
        for (;;) {
            auto next = std::ranges::find_if(waiters_, is_so);
            if (next == waiters_.end()) {
                next = std::ranges::min_element(waiters_, {}, &Waiter::until);
                if (next == waiters_.end()) return;
                if (!events_.empty() && events_.begin()->first <= next->until) {
                    now_ = std::max(now_, events_.begin()->first);
                    const auto event = std::move(events_.extract(events_.begin()).mapped());
                    lock.unlock();
                    event();
                    lock.lock();
                    continue;
                }
                if (next->until == Time::max()) std::abort();  // each waits for another
                now_ = std::max(now_, next->until);
            }
            next->runs = true;
            next->turn.notify_one();
            return;
        }
    }

    mutable std::mutex mutex_;
    Time now_{0};
    std::list<Waiter> waiters_;
    std::multimap<Time, std::function<void()>> events_;
    std::set<std::thread::id> alive_;
};

}  // namespace haptogram::test
