// SPDX-License-Identifier: Apache-2.0
// The drivers' enable is taken away when the instrument's clock stops: within the time that rtl/boards/clock_watch.v
// says, by its own clock.
#include <Vclock_watch_bench.h>
#include <verilated.h>

#include <catch2/catch.hpp>
#include <memory>
#include <random>

namespace {
constexpr double oscillator_hz = 310e6 / 128;  // Lattice FPGA-DS-02012: 310 MHz, of which the divider makes this

class Watch {
public:
    Watch() {
        context_.randReset(2);
        context_.randSeed(static_cast<int>(Catch::rngSeed() % 2147483647U));
        model_ = std::make_unique<Vclock_watch_bench>(&context_);
        model_->i_oscillator = model_->i_alive = 0;
        model_->eval();
    }
    ~Watch() { model_->final(); }

    bool running() { return model_->o_running; }
    void change() { model_->i_alive = !model_->i_alive; }
    /// The synchronizer wakes up with anything; afterwards it holds the level that is there.
    void settle() { stays(false, 4); }
    /// So many periods of the oscillator. True when o_running was `as` after each of them.
    bool stays(bool as, int periods) {
        bool same = true;
        for (int i = 0; i < periods; ++i) {
            model_->i_oscillator = 1;
            model_->eval();
            model_->i_oscillator = 0;
            model_->eval();
            same = same && running() == as;
        }
        return same;
    }

private:
    VerilatedContext context_;
    std::unique_ptr<Vclock_watch_bench> model_;
};
}  // namespace

TEST_CASE("clock watch: without a clock it is not running") {
    Watch watch;
    watch.stays(false, 2054);  // the synchronizer may wake up with anything, which then looks like one change
    CHECK(watch.stays(false, 5000));
    watch.change();
    watch.stays(false, 4);
    CHECK(watch.running());
}

TEST_CASE("clock watch: goes on as long as there are changes, however late within the time they come") {
    Watch watch;
    std::mt19937 random{Catch::rngSeed()};
    watch.settle();
    watch.change();
    watch.stays(true, 4);
    for (int i = 0; i < 200; ++i) {
        REQUIRE(watch.stays(true, std::uniform_int_distribution<int>(1, 2044)(random)));
        watch.change();
    }
}

TEST_CASE(
    "clock watch: a clock that stops takes the enable away within a millisecond, and one that comes back gives it "
    "back") {
    Watch watch;
    watch.settle();
    for (int level = 0; level < 2; ++level) {  // stopped high and stopped low
        watch.change();
        watch.stays(true, 4);
        REQUIRE(watch.running());
        int periods = 4;
        while (watch.running() && periods < 10000) {
            watch.stays(true, 1);
            ++periods;
        }
        CHECK(periods >= 2048);
        CHECK(periods / (oscillator_hz * 0.85) < 1.1e-3);  // the slowest oscillator
        CHECK(periods / oscillator_hz == Approx(0.85e-3).epsilon(0.01));
        CHECK(watch.stays(false, 10000));
    }
}
