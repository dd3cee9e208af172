// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <verilated.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <random>

#ifdef HAPTOGRAM_COUNTS  // tests/coverage
namespace haptogram::sim {
void gather_coverage(VerilatedCovContext& model);
}
#endif

/// One Verilated module with a clock, powered up with random registers and reset.
template <class Model>
struct Bench {
    VerilatedContext context;
    std::unique_ptr<Model> model;
    std::mt19937_64 random{Catch::rngSeed()};

    Bench() {
        context.randReset(2);
        context.randSeed(static_cast<int>(Catch::rngSeed() % 2147483647U));
        model = std::make_unique<Model>(&context);
        model->clk = 0;
        model->rst = 1;
    }
    ~Bench() {
        // Verilator's scopes unregister from the thread's last context, which may be that of a bench that is gone.
        Verilated::threadContextp(&context);
        model->final();
#ifdef HAPTOGRAM_COUNTS
        haptogram::sim::gather_coverage(*context.coveragep());
#endif
        model.reset();
    }
    Model* operator->() { return model.get(); }

    /// To be called when all inputs have a value.
    void reset() {
        model->rst = 1;
        for (int i = 0; i < 3; ++i) clock();
        model->rst = 0;
        model->eval();
    }
    /// The inputs as they are count in this clock; afterwards the outputs are those of the next one.
    void clock() {
        model->eval();
        model->clk = 1;
        model->eval();
        model->clk = 0;
        model->eval();
    }
    /// A whole number from `low` to `high`.
    int number(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }
    bool chance(double of) { return std::uniform_real_distribution<double>(0, 1)(random) < of; }
};
