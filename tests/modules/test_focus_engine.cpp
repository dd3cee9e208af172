// SPDX-License-Identifier: Apache-2.0
#include <Vfocus_engine.h>
#include <verilated.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <deque>
#include <random>
#include <vector>

#include "haptogram/format/focus_engine.hpp"

using namespace haptogram;

namespace {

/// A record as the engine is given it.
struct FociRecord {
    std::vector<FocusWords> foci;
    bool whole = false;
};

/// The engine with its clock. Every result is compared with what the host's model expects next.
class EngineBench {
public:
    explicit EngineBench(std::uint32_t seed) {
        context_.randReset(2);
        context_.randSeed(static_cast<int>(seed | 1U));
        core_ = std::make_unique<Vfocus_engine>(&context_);
        core_->i_geometry = core_->i_focus = core_->i_start = 0;
        reset();
    }
    ~EngineBench() { core_->final(); }
    EngineBench(const EngineBench&) = delete;
    EngineBench& operator=(const EngineBench&) = delete;

    /// Drops whatever is under way.
    void reset() {
        core_->rst = 1;
        expected_.clear();
        clock();
        clock();
        core_->rst = 0;
    }

    /// While nothing is computed: the settings, and the geometry, word by word in any order.
    void set_up(const FocusEngine& engine, std::mt19937_64& g) {
        REQUIRE(expected_.empty());
        engine_ = engine;
        core_->i_wave_number = engine.wave_number;
        core_->i_gain = engine.gain;
        std::vector<std::size_t> words(4 * engine.geometry.size());
        for (std::size_t i = 0; i < words.size(); ++i) words[i] = i;
        std::ranges::shuffle(words, g);
        for (const std::size_t word : words) {
            core_->i_geometry = 1;
            core_->i_geometry_address = static_cast<std::uint16_t>(word);
            core_->i_geometry_word = engine.geometry[word / 4][word % 4];
            clock();
        }
        core_->i_geometry = 0;
    }

    void write(std::size_t focus, std::size_t word, std::uint16_t value) {
        core_->i_focus = 1;
        core_->i_focus_address = static_cast<std::uint8_t>(4 * focus + word);
        core_->i_focus_word = value;
        clock();
        core_->i_focus = 0;
    }

    /// Asks for a start until it is granted; the words must have been written.
    void start(const FociRecord& record) {
        core_->i_start = 1;
        core_->i_last_focus = static_cast<std::uint8_t>(record.foci.size() - 1);
        core_->i_whole = record.whole;
        int left = 2'000;
        while (!ready()) {
            REQUIRE(--left > 0);
            clock();
        }
        for (const ChannelDrive& drive : engine_drives(engine_, record.foci, record.whole)) expected_.push_back(drive);
        started_ = clocks_;
        clock();
        core_->i_start = 0;
    }

    void play(const FociRecord& record) {
        for (std::size_t i = 0; i < record.foci.size(); ++i)
            for (std::size_t word = 0; word < 4; ++word) write(i, word, record.foci[i][word]);
        start(record);
    }

    /// Until every result has come.
    void drain() {
        int left = 2'000;
        while (!expected_.empty()) {
            REQUIRE(--left > 0);
            clock();
        }
    }

    void clock() {
        core_->clk = 0;
        core_->eval();
        core_->clk = 1;
        core_->eval();
        ++clocks_;
        if (core_->o_valid) take();
    }

    [[nodiscard]] bool ready() {
        core_->clk = 0;
        core_->eval();
        return core_->o_ready;
    }
    [[nodiscard]] std::uint64_t results() const { return results_; }
    [[nodiscard]] std::uint64_t silent() const { return silent_; }
    [[nodiscard]] std::uint64_t far() const { return far_; }
    /// Clocks from the one that took the start.
    [[nodiscard]] std::uint64_t since_start() const { return clocks_ - started_; }
    [[nodiscard]] std::uint64_t first_after() const { return first_after_; }
    [[nodiscard]] std::uint64_t last_after() const { return last_after_; }

private:
    void take() {
        if (expected_.empty()) FAIL("a result that nobody asked for, for channel " << int{core_->o_channel});
        const ChannelDrive want = expected_.front();
        expected_.pop_front();
        const std::size_t channel =
            (PARAMETER_CHANNELS - expected_.size() % PARAMETER_CHANNELS - 1) % PARAMETER_CHANNELS;
        ChannelDrive got{core_->o_phase, core_->o_amplitude, core_->o_far != 0};
        if (got.amplitude == 0) got.phase = 0;
        // Compared here and not by Catch, which is slow.
        if (got != want || core_->o_channel != channel || (core_->o_last != 0) != (channel == PARAMETER_CHANNELS - 1))
            FAIL("result " << results_ << ", channel " << int{core_->o_channel} << " (" << channel << "): phase "
                           << got.phase << " (" << want.phase << "), amplitude " << got.amplitude << " ("
                           << want.amplitude << "), far " << got.far << " (" << want.far << ")");
        ++results_;
        if (got.amplitude == 0) ++silent_;
        if (got.far) ++far_;
        if (channel == 0) first_after_ = since_start();
        if (channel == PARAMETER_CHANNELS - 1) last_after_ = since_start();
    }

    VerilatedContext context_;
    std::unique_ptr<Vfocus_engine> core_;
    FocusEngine engine_;
    std::deque<ChannelDrive> expected_;
    std::uint64_t clocks_ = 0, started_ = 0, results_ = 0, silent_ = 0, far_ = 0, first_after_ = 0, last_after_ = 0;
};

using Words = std::uniform_int_distribution<std::uint32_t>;

std::uint16_t any_word(std::mt19937_64& g) { return static_cast<std::uint16_t>(Words(0, 0xffff)(g)); }

/// Foci as in use: within reach of a tile, of any amplitude.
FocusWords near_focus(std::mt19937_64& g) {
    std::uniform_real_distribution<double> lateral(-0.12, 0.12), height(0.0, 0.4), amplitude(0.0, 1.0);
    return pack_focus({{lateral(g), lateral(g), height(g)}, amplitude(g)});
}

/// Any bits that a focus may have: mostly too far for some channels.
FocusWords any_focus(std::mt19937_64& g) {
    return {any_word(g), any_word(g), any_word(g), static_cast<std::uint16_t>(any_word(g) & 0xff3f)};
}

FociRecord random_record(std::mt19937_64& g) {
    FociRecord record;
    record.whole = Words(0, 3)(g) == 0;
    record.foci.resize(Words(1, 8)(g));
    const auto kind = Words(0, 9)(g);
    for (FocusWords& focus : record.foci) {
        focus = kind < 2 || Words(0, 15)(g) == 0 ? any_focus(g) : near_focus(g);
        if (kind == 2 || Words(0, 15)(g) == 0) focus[3] &= 0x00ff;  // a sum of nothing
        if (kind == 3) focus = record.foci.front();                 // the longest sums
        if (kind == 3) focus[3] |= 0xff00;
    }
    return record;
}

FocusEngine tile() {
    Array array;
    for (int row = 0; row < 10; ++row)
        for (int column = 0; column < 10; ++column)
            array.elements.push_back({from_mm(10.16 * (column - 4.5), 10.16 * (row - 4.5), 0.1 * row)});
    array.elements.resize(PARAMETER_CHANNELS);
    return focus_engine(array);
}

/// Any geometry, wave number and gain, among them the ends of their ranges.
FocusEngine random_engine(std::mt19937_64& g) {
    FocusEngine engine = tile();
    if (Words(0, 1)(g) == 0)
        for (GeometryWords& place : engine.geometry) place = {any_word(g), any_word(g), any_word(g), any_word(g)};
    const auto kind = Words(0, 9)(g);
    engine.wave_number = kind == 0 ? 0 : kind == 1 ? 0x3ffff : kind < 6 ? Words(0, 0x3ffff)(g) : engine.wave_number;
    engine.gain = kind == 2 ? 0 : kind == 3 ? 0xffff : kind < 6 ? any_word(g) : engine.gain;
    return engine;
}

}  // namespace

TEST_CASE("focus engine: a million results equal the model's, bit by bit", "[modules]") {
    std::mt19937_64 g(Catch::rngSeed());
    EngineBench bench(Catch::rngSeed());
    while (bench.results() < 1'000'000) {
        bench.set_up(random_engine(g), g);
        // The next record's foci are written while the last one is computed, and its start is asked for at once.
        for (int i = 0; i < 40; ++i) {
            bench.play(random_record(g));
            if (Words(0, 7)(g) == 0)
                for (auto pause = Words(1, 900)(g); pause > 0; --pause) bench.clock();
        }
        bench.drain();
    }
    UNSCOPED_INFO(bench.results() << " results, " << bench.silent() << " of amplitude 0, " << bench.far()
                                  << " with a far focus");
    CHECK(bench.silent() > bench.results() / 20);
    CHECK(bench.silent() < bench.results() / 2);
    CHECK(bench.far() > bench.results() / 20);
    CHECK(bench.far() < bench.results() / 2);
}

TEST_CASE("focus engine: the edges of what is too far, and distance 0", "[modules]") {
    std::mt19937_64 g(Catch::rngSeed());
    EngineBench bench(Catch::rngSeed());
    FocusEngine engine = tile();
    for (GeometryWords& place : engine.geometry) place = {0, 0, 0, any_word(g)};
    const auto unweighed = static_cast<std::uint64_t>(
        std::ranges::count_if(engine.geometry, [](const GeometryWords& place) { return (place[3] & 0xff) == 0xff; }));
    bench.set_up(engine, g);
    // -2^17 is a difference too far, -2^17 + 1 and 2^17 - 1 are not; from x = ±1 those are.
    for (const std::uint16_t element : std::vector<std::uint16_t>{0, 1, 0xffff}) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (GeometryWords& place : engine.geometry) place[axis] = element;
            bench.set_up(engine, g);
            for (const std::int32_t at : {-0x20000, -0x1ffff, -0x1fffe, 0, 0x1fffe, 0x1ffff}) {
                FocusWords focus{0, 0, 0, 0xff00};
                focus[axis] = static_cast<std::uint16_t>(at & 0xffff);
                focus[3] |= static_cast<std::uint16_t>((at >> 16 & 3) << (2 * axis));
                const std::uint64_t far = bench.far();
                const std::uint64_t silent = bench.silent();
                bench.play({{focus}, false});
                bench.drain();
                const bool is_far = std::abs(at - static_cast<std::int16_t>(element)) >= 0x20000;
                REQUIRE(bench.far() - far == (is_far ? PARAMETER_CHANNELS : 0));
                REQUIRE(bench.silent() - silent == (is_far ? PARAMETER_CHANNELS : unweighed));
            }
            for (GeometryWords& place : engine.geometry) place[axis] = 0;
        }
    }
}

TEST_CASE("focus engine: foci that cancel out, also where all channels are to be full", "[modules]") {
    std::mt19937_64 g(Catch::rngSeed());
    EngineBench bench(Catch::rngSeed());
    FocusEngine engine = tile();
    for (GeometryWords& place : engine.geometry) place = {0, 0, 0, any_word(g)};
    engine.wave_number = 0x10000;  // 1,024 units are half a turn
    bench.set_up(engine, g);
    for (const std::uint16_t amplitude : std::vector<std::uint16_t>{0x0100, 0x8000, 0xff00}) {
        for (const bool whole : {false, true}) {
            bench.play({{{0, 0, 10'000, amplitude}, {0, 0, 11'024, amplitude}}, whole});
            bench.play({{{0, 0, 10'000, 0}, {0, 0, 11'024, 0}}, whole});
            bench.play({{{0, 0, 10'000, 0}}, whole});
        }
    }
    bench.drain();
    CHECK(bench.silent() > 12 * PARAMETER_CHANNELS);
}

TEST_CASE("focus engine: the longest sums, at every phase", "[modules]") {
    std::mt19937_64 g(Catch::rngSeed());
    EngineBench bench(Catch::rngSeed());
    FocusEngine engine = tile();
    const FociRecord record{std::vector<FocusWords>(most_record_foci, {0, 0, 0, 0xff00}), false};
    std::uint64_t silent = 0;
    for (std::uint32_t offset = 0; offset < 0x10000;) {
        for (GeometryWords& place : engine.geometry) {
            silent += (offset & 0xff) == 0xff ? 1 : 0;  // a weight of 0
            place = {0, 0, 0, static_cast<std::uint16_t>(offset++)};
        }
        bench.set_up(engine, g);
        bench.play(record);
        bench.drain();
    }
    CHECK(bench.silent() == silent);
}

TEST_CASE("focus engine: clocks that a record takes", "[modules]") {
    std::mt19937_64 g(Catch::rngSeed());
    EngineBench bench(Catch::rngSeed());
    bench.set_up(tile(), g);
    for (std::size_t count = 1; count <= most_record_foci; ++count) {
        bench.play({std::vector<FocusWords>(count, near_focus(g)), false});
        bench.drain();
        CHECK(bench.first_after() == 33 + count);
        CHECK(bench.last_after() == 33 + PARAMETER_CHANNELS * count);
    }
    // Records back to back: each is granted when the last one's foci have been counted through.
    const std::uint64_t before = bench.results();
    bench.play({{near_focus(g), near_focus(g)}, false});
    for (int i = 0; i < 20; ++i) {
        for (std::size_t word = 0; word < 8; ++word)
            bench.write(word / 4, word % 4, FocusWords{0, 0, 20'000, 0x8000}[word % 4]);
        std::uint64_t waited = 8;
        while (!bench.ready()) {
            bench.clock();
            ++waited;
        }
        REQUIRE(waited == 2 * PARAMETER_CHANNELS - 1);
        bench.start({{{0, 0, 20'000, 0x8000}, {0, 0, 20'000, 0x8000}}, false});
    }
    bench.drain();
    CHECK(bench.results() - before == 21 * PARAMETER_CHANNELS);
}

TEST_CASE("focus engine: a reset drops what is under way, and the next record is whole", "[modules]") {
    std::mt19937_64 g(Catch::rngSeed());
    EngineBench bench(Catch::rngSeed());
    bench.set_up(random_engine(g), g);
    for (int i = 0; i < 400; ++i) {
        for (auto records = Words(1, 3)(g); records > 0; --records) bench.play(random_record(g));
        for (auto clocks = Words(0, 900)(g); clocks > 0; --clocks) bench.clock();
        bench.reset();
        REQUIRE(bench.ready());
        // A result of what was dropped would be one too many.
        for (auto clocks = Words(0, 60)(g); clocks > 0; --clocks) bench.clock();
        bench.play(random_record(g));
        bench.drain();
    }
}
