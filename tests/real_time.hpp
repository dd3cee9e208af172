// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/core.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <string>

namespace haptogram::test {

/// Of the machine's own time, for cases with the tag [real-time], which run alone.
class StopWatch {
public:
    [[nodiscard]] double seconds() const { return std::chrono::duration<double>(Clock::now() - begun_).count(); }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point begun_ = Clock::now();
};

/// Prints what was found beside what is aimed at. How fast a machine is says little of the code: only three times as
/// much fails.
inline void compare(const std::string& what, double found, double target, const std::string& unit) {
    fmt::print("[real-time] {}: {:.3g} {}, target {:.3g} {}\n", what, found, unit, target, unit);
    CHECK(found <= 3.0 * target);
}

}  // namespace haptogram::test
