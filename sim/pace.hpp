// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>

namespace haptogram::sim {

/// Real time for a simulated board. A simulation that is too slow gives up what it cannot make up for, so that its
/// clock runs slower than the wall's. Otherwise it would leap over ever longer times in which it hears no host, and its
/// watchdog would switch off.
class Pace {
public:
    using Clock = std::chrono::steady_clock;

    /// @param most_behind_s  what a simulation may still make up for
    explicit Pace(double most_behind_s, Clock::time_point begun = Clock::now())
        : most_behind_s_(most_behind_s), begun_(begun) {}

    /// @return real time since the beginning in s
    [[nodiscard]] double wall_s(Clock::time_point now = Clock::now()) const {
        return std::chrono::duration<double>(now - begun_).count();
    }

    /// @return by how much a board that has simulated so much is ahead of its pace in s; negative: behind
    [[nodiscard]] double ahead_s(double simulated_s, Clock::time_point now = Clock::now()) const {
        return simulated_s + given_up_s_ - wall_s(now);
    }

    /// Gives up what the board is behind by more than it may make up for.
    void give_up(double simulated_s, Clock::time_point now = Clock::now()) {
        const double behind_s = -ahead_s(simulated_s, now);
        if (behind_s > most_behind_s_) given_up_s_ += behind_s - most_behind_s_;
    }

private:
    double most_behind_s_;
    Clock::time_point begun_;
    double given_up_s_ = 0.0;
};

}  // namespace haptogram::sim
