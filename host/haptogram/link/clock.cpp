// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/clock.hpp"

#include <algorithm>

namespace haptogram::link {
namespace {

class MachineClock final : public Clock {
public:
    [[nodiscard]] Time now() const override { return Steady::now() - start_; }
    void rest_until(Time until) override { std::this_thread::sleep_until(start_ + until); }
    bool wait_until(std::unique_lock<std::mutex>& lock, std::condition_variable& news, Time until,
                    const std::function<bool()>& so) override {
        return news.wait_until(lock, start_ + until, so);
    }

private:
    using Steady = std::chrono::steady_clock;
    const Steady::time_point start_ = Steady::now();
};

}  // namespace

/// Where time passes only while somebody waits, as a simulated board's does.
bool Clock::wait_until(std::unique_lock<std::mutex>& lock, std::condition_variable&, Time until,
                       const std::function<bool()>& so) {
    constexpr std::chrono::milliseconds look{1};
    while (!so()) {
        const Time begun = now();
        if (begun >= until) return false;
        lock.unlock();
        rest_until(std::min<Time>(until, begun + look));
        lock.lock();
    }
    return true;
}

Clock& machine_clock() {
    static MachineClock clock;
    return clock;
}

}  // namespace haptogram::link
