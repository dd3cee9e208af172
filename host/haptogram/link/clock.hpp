// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace haptogram::link {

/// The time that a host lives in, and every way to wait in it. It is given, never looked up: a simulated board's time
/// is not the wall's, and a test steps it.
class Clock {
public:
    using Time = std::chrono::nanoseconds;  ///< from some beginning on

    Clock() = default;
    Clock(const Clock&) = delete;
    Clock& operator=(const Clock&) = delete;
    virtual ~Clock() = default;

    [[nodiscard]] virtual Time now() const = 0;
    /// Returns at once when that has passed.
    virtual void rest_until(Time until) = 0;
    /// Waits, with the mutex free meanwhile, until something is so of which `news` tells, but not beyond `until`.
    /// @return whether it is so
    virtual bool wait_until(std::unique_lock<std::mutex>& lock, std::condition_variable& news, Time until,
                            const std::function<bool()>& so);
    /// A thread that lives in this time, which join() waits for.
    [[nodiscard]] virtual std::thread begin(std::function<void()> work) { return std::thread(std::move(work)); }
    virtual void join(std::thread& thread) { thread.join(); }

    void rest(Time pause) { rest_until(now() + pause); }
    bool wait_for(std::unique_lock<std::mutex>& lock, std::condition_variable& news, Time patience,
                  const std::function<bool()>& so) {
        return wait_until(lock, news, now() + patience, so);
    }
    [[nodiscard]] double now_s() const { return seconds(now()); }
    void rest_until_s(double until_s) { rest_until(time(until_s)); }
    [[nodiscard]] double seconds_since(Time begin) const { return seconds(now() - begin); }

    [[nodiscard]] static double seconds(Time time) { return std::chrono::duration<double>(time).count(); }
    /// The first that is not before so many seconds, which have more digits.
    [[nodiscard]] static Time time(double of_seconds) {
        of_seconds = std::min(of_seconds, 4e9);  // beyond which nanoseconds have no number, and nobody waits
        auto found = std::chrono::ceil<Time>(std::chrono::duration<double>(of_seconds));
        while (seconds(found) < of_seconds) ++found;
        return found;
    }
};

/// The machine's own, from 0 at the first call on.
[[nodiscard]] Clock& machine_clock();

}  // namespace haptogram::link
