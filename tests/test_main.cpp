// SPDX-License-Identifier: Apache-2.0
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#include <cstdio>

namespace {

/// Catch prints the seed with a failed check only; a run that crashes or hangs must have told it, too.
struct SeedPrinter : Catch::TestEventListenerBase {
    using TestEventListenerBase::TestEventListenerBase;
    void testRunStarting(const Catch::TestRunInfo& /*run*/) override {
        std::fprintf(stderr, "random seed: --rng-seed %u\n", m_config->rngSeed());
    }
};
CATCH_REGISTER_LISTENER(SeedPrinter)

}  // namespace
