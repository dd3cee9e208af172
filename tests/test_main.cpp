// SPDX-License-Identifier: Apache-2.0
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "test_data.hpp"

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

std::string test_data() { return HAPTOGRAM_TEST_FOLDER "/data"; }

/// Random numbers are those of --rng-seed, else of HAPTOGRAM_SEED, else other ones in each run.
int main(int argc, char** argv) {
    Catch::Session session;
    const char* seed = std::getenv("HAPTOGRAM_SEED");
    session.configData().rngSeed = seed != nullptr && *seed != '\0'
                                       ? static_cast<unsigned>(std::strtoul(seed, nullptr, 10))
                                       : std::random_device{}();
    const int wrong = session.applyCommandLine(argc, argv);
    return wrong != 0 ? wrong : session.run();
}
