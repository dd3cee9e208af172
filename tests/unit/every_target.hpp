// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <string>

/// Calls `check` once for each instruction set of this processor that some code is compiled for.
/// @param taken  the one that the code takes, as its library tells it
inline void on_every_target(const char* (*taken)(), const std::function<void()>& check) {
    const struct AllTargets {
        ~AllTargets() {
            hwy::SetSupportedTargetsForTest(0);
            hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        }
    } afterwards;
    int tested = 0;
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        const std::int64_t target = targets & -targets;
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        if (std::string(taken()) != hwy::TargetName(target)) continue;  // not compiled for
        CAPTURE(hwy::TargetName(target));
        ++tested;
        check();
    }
    REQUIRE(tested > 0);
}
