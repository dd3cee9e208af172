// SPDX-License-Identifier: Apache-2.0
// Contract 9: sample i belongs to the carrier periods i · N … (i + 1) · N − 1.
#include <Vmodulation.h>

#include <vector>

#include "bench.hpp"

namespace {
constexpr int depth = PARAMETER_DEPTH;

class Modulation {
public:
    Bench<Vmodulation> bench;
    std::vector<int> samples;

    Modulation() {
        bench->i_write = bench->i_start = bench->i_stop = bench->i_period = bench->i_loop = 0;
        bench->i_write_address = bench->i_read_address = 0;
        bench->i_drop = bench->i_at_pass_end = bench->i_first = 0;
        bench->i_write_word = 0;
        bench->i_length = 1;
        bench->i_divider = 1;
        bench.reset();
        CHECK(bench->o_sample == 255);
        for (int i = 0; i < depth; ++i) samples.push_back(bench.number(0, 255));
        for (int i = 0; i < depth; i += 2) {
            bench->i_write = 1;
            bench->i_write_address = static_cast<std::uint8_t>(i / 2);
            bench->i_write_word = static_cast<std::uint16_t>(samples[at(i)] | samples[at(i + 1)] << 8);
            bench.clock();
        }
        bench->i_write = 0;
    }
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }

    void set(int length, int divider, bool loop) {
        bench->i_length = static_cast<std::uint8_t>(length);
        bench->i_divider = static_cast<std::uint16_t>(divider);
        bench->i_loop = loop;
    }
    void strobe(bool start, bool stop, bool at_pass_end = false) {
        bench->i_start = start;
        bench->i_stop = stop;
        bench->i_at_pass_end = at_pass_end;
        bench.clock();
        bench->i_start = bench->i_stop = bench->i_at_pass_end = 0;
    }
    void drop() {
        bench->i_drop = 1;
        bench.clock();
        bench->i_drop = 0;
    }
    /// A carrier period of so many clocks, at least 4. Its sample is there after four, and stays.
    int period(int clocks = 4, bool start = false) {
        bench->i_period = 1;
        bench->i_start = start;
        bench.clock();
        bench->i_period = bench->i_start = 0;
        bench->i_read_address = static_cast<std::uint8_t>(bench.number(0, depth / 2 - 1));  // replies go on meanwhile
        for (int c = 1; c < 4; ++c) bench.clock();
        const int sample = bench->o_sample;
        for (int c = 4; c < clocks; ++c) {
            bench.clock();
            same = same && bench->o_sample == sample;
        }
        return sample;
    }
    bool same = true;
};
}  // namespace

TEST_CASE("contract 9: a loop, at N of 1, 3 and 65535") {
    Modulation modulation;
    const int divider = GENERATE(1, 3, 65535);
    const int length = divider == 65535 ? 3 : GENERATE(1, 5, depth);
    modulation.set(length, divider, true);
    modulation.strobe(true, false);
    const long periods = divider == 65535 ? 4 * 65535L + 10 : 3L * length * divider + 7;
    long wrong = 0;
    for (long p = 0; p < periods; ++p) {
        const int expected = modulation.samples[static_cast<std::size_t>(p / divider % length)];
        wrong += modulation.period(divider == 65535 ? 4 : 25) != expected || !modulation.bench->o_running;
    }
    CHECK(wrong == 0);
    CHECK(modulation.same);
}

TEST_CASE("contract 9: once, after which the last sample stays") {
    Modulation modulation;
    const int divider = GENERATE(1, 3, 7), length = GENERATE(1, 2, 9, depth);
    modulation.set(length, divider, false);
    modulation.strobe(true, false);
    for (int p = 0; p < length * divider; ++p) {
        REQUIRE(modulation.period() == modulation.samples[Modulation::at(p / divider)]);
        REQUIRE(modulation.bench->o_running);
    }
    for (int p = 0; p < 3 * divider + 5; ++p) {
        REQUIRE(modulation.period() == modulation.samples[Modulation::at(length - 1)]);
        REQUIRE(!modulation.bench->o_running);
    }
    modulation.strobe(false, true);
    REQUIRE(modulation.period() == 255);
}

TEST_CASE("a stop in the middle takes effect at the next period, and a restart begins with sample 0") {
    Modulation modulation;
    modulation.set(10, 3, true);
    modulation.strobe(true, false);
    int before = 255;
    for (int p = 0; p < 17; ++p) before = modulation.period();
    REQUIRE(before == modulation.samples[5]);
    modulation.strobe(false, true);
    for (int c = 0; c < 50; ++c) {
        REQUIRE(modulation.bench->o_sample == before);  // not before the period's end
        REQUIRE(modulation.bench->o_running);
        modulation.bench.clock();
    }
    REQUIRE(modulation.period() == 255);
    REQUIRE(!modulation.bench->o_running);
    for (int p = 0; p < 5; ++p) REQUIRE(modulation.period() == 255);
    modulation.set(4, 2, true);
    modulation.strobe(true, false);
    REQUIRE(modulation.bench->o_sample == 255);
    for (int p = 0; p < 11; ++p) REQUIRE(modulation.period() == modulation.samples[Modulation::at(p / 2 % 4)]);
    modulation.strobe(true, false);  // also without a stop
    for (int p = 0; p < 5; ++p) REQUIRE(modulation.period() == modulation.samples[Modulation::at(p / 2)]);
}

TEST_CASE("of a start and a stop in one period the later counts, and of both at once the stop") {
    Modulation modulation;
    modulation.set(4, 1, true);
    modulation.strobe(true, false);
    modulation.strobe(false, true);
    CHECK(modulation.period() == 255);
    modulation.strobe(false, true);
    modulation.strobe(true, false);
    CHECK(modulation.period() == modulation.samples[0]);
    CHECK(modulation.period() == modulation.samples[1]);
    modulation.strobe(true, true);
    CHECK(modulation.period() == 255);
    CHECK(modulation.period(4, true) == modulation.samples[0]);  // a start with the strobe of the period itself
    CHECK(modulation.period() == modulation.samples[1]);
}

TEST_CASE("contract 10: samples follow others where their pass ends, from any first one on, with no period between") {
    Modulation modulation;
    const int length = GENERATE(1, 2, 5), divider = GENERATE(1, 3), first = GENERATE(0, 2, depth - 4);
    const bool loop = GENERATE(true, false);
    const int pass = length * divider;
    const int asked = modulation.bench.number(0, pass - 1);  // period of the second pass, or after the end
    modulation.set(length, divider, loop);
    modulation.strobe(true, false);
    for (int p = 0; p < pass; ++p) REQUIRE(modulation.period() == modulation.samples[Modulation::at(p / divider)]);
    const int until = loop ? pass : asked + 1;  // what was played once has ended already
    for (int p = 0; p < until; ++p) {
        if (p == asked) {
            modulation.bench->i_first = static_cast<std::uint8_t>(first / 2);
            modulation.set(4, 2, true);
        }
        const int sample = loop ? p / divider : length - 1;
        const int found = modulation.period();
        REQUIRE(found == modulation.samples[Modulation::at(sample)]);
        if (p == asked) modulation.strobe(true, false, true);
    }
    for (int p = 0; p < 20; ++p) REQUIRE(modulation.period() == modulation.samples[Modulation::at(first + p / 2 % 4)]);
    modulation.strobe(false, true, true);
    for (int p = 20; p < 24; ++p) REQUIRE(modulation.period() == modulation.samples[Modulation::at(first + p / 2 % 4)]);
    REQUIRE(modulation.period() == 255);
}

TEST_CASE("a start or a stop that waits can be dropped") {
    Modulation modulation;
    modulation.set(4, 1, true);
    modulation.strobe(true, false);
    modulation.drop();
    REQUIRE(modulation.period() == 255);
    modulation.strobe(true, false);
    REQUIRE(modulation.period() == modulation.samples[0]);
    modulation.strobe(false, true, true);
    modulation.drop();
    for (int p = 1; p < 12; ++p) REQUIRE(modulation.period() == modulation.samples[Modulation::at(p % 4)]);
}

TEST_CASE("the memory is read back while nothing is fetched") {
    Modulation modulation;
    for (int word = 0; word < depth / 2; ++word) {
        modulation.bench->i_read_address = static_cast<std::uint8_t>(word);
        modulation.bench.clock();
        modulation.bench.clock();
        REQUIRE(modulation.bench->o_word ==
                (modulation.samples[Modulation::at(2 * word)] | modulation.samples[Modulation::at(2 * word + 1)] << 8));
    }
}
