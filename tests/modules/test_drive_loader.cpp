// SPDX-License-Identifier: Apache-2.0
// rtl/amplitudes/drive_loader.v with a memory that the test drives: when a record's words are complete, what they are,
// and where a focus record is looked for.
#include <Vdrive_loader.h>

#include <array>
#include <optional>
#include <vector>

#include "bench.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/focus_engine.hpp"

using namespace haptogram;

namespace {
constexpr std::uint32_t channels = PARAMETER_CHANNELS;
constexpr std::uint32_t record_words = channels + 4;
constexpr std::uint32_t memory_words = PARAMETER_RECORDS * record_words;
constexpr int most = most_record_foci;

/// What a load did: after how many clocks of the one that took the entry its words were complete, and the first
/// address.
struct Load {
    int clocks = 0;
    bool refused = false, silent = false, far = false;
    std::optional<std::uint32_t> first_address;
};

class Loader {
public:
    Bench<Vdrive_loader> bench;
    std::vector<std::uint16_t> memory = std::vector<std::uint16_t>(memory_words);
    FocusEngine engine;

    Loader() {
        bench->i_preempt = bench->i_entry = bench->i_common = bench->i_set_geometry = bench->i_take_over = 0;
        bench->i_index = bench->i_dwell = bench->i_tag = bench->i_word = bench->i_set_address = bench->i_set_word = 0;
        bench->i_foci_base = bench->i_foci_count = bench->i_foci_last = bench->i_foci_whole = 0;
        bench->i_foci_cycle = 1250;
        bench->i_wave_number = bench->i_gain = 0;
        bench->i_swept = bench->i_channel = 0;
        bench.reset();
    }

    void clock() {
        const std::uint16_t read = memory[bench->o_address % memory.size()];
        bench.clock();
        bench->i_word = coming_;
        coming_ = read;
        bench->eval();
    }
    /// Any geometry, near the origin.
    void set_up() {
        engine.wave_number = static_cast<std::uint32_t>(bench.number(0, 0x3ffff));
        engine.gain = static_cast<std::uint16_t>(bench.number(0, 0xffff));
        engine.geometry.resize(channels);
        for (std::uint32_t k = 0; k < channels; ++k) {
            for (std::uint32_t w = 0; w < 4; ++w) {
                engine.geometry[k][w] = static_cast<std::uint16_t>(bench.number(-9000, 9000));
                bench->i_set_geometry = 1;
                bench->i_set_address = static_cast<std::uint8_t>(4 * k + w);
                bench->i_set_word = engine.geometry[k][w];
                clock();
            }
        }
        bench->i_set_geometry = 0;
        bench->i_wave_number = engine.wave_number;
        bench->i_gain = engine.gain;
    }
    /// In the clock after the entry is taken this returns.
    void ask(std::uint32_t index) {
        bench->i_entry = 1;
        bench->i_index = static_cast<std::uint16_t>(index);
        bench->eval();
        for (int left = 10; !bench->o_take; --left) {
            REQUIRE(left > 0);
            clock();
        }
        clock();
        bench->i_entry = 0;
        bench->eval();
    }
    Load load(std::uint32_t index) {
        ask(index);
        Load found{1, false, false, false, {}};
        while (true) {
            found.refused |= bench->o_refused != 0;
            found.far |= bench->o_far != 0;
            if (bench->o_reading && !found.first_address) found.first_address = bench->o_address;
            if (bench->o_ready) break;
            clock();
            REQUIRE(++found.clocks < 2000);
        }
        found.silent = bench->o_silent;
        return found;
    }
    void drop() {
        bench->i_preempt = 1;
        clock();
        bench->i_preempt = 0;
        bench->eval();
    }
    /// Takes the loaded record over, and returns its words.
    std::array<std::uint32_t, channels> take_over() {
        bench->i_take_over = 1;
        clock();
        bench->i_take_over = 0;
        bench->i_swept = !bench->i_swept;
        std::array<std::uint32_t, channels> words{};
        for (std::uint32_t k = 0; k < channels; ++k) {
            bench->i_channel = static_cast<std::uint8_t>(k);
            clock();
            clock();
            words[k] = bench->o_word;
        }
        return words;
    }
    /// Random foci from word 4 · `place` on, within a metre.
    std::vector<FocusWords> write_foci(std::uint32_t place, int count) {
        std::vector<FocusWords> foci;
        for (int f = 0; f < count; ++f) {
            const auto metres = [&] { return 1e-3 * bench.number(-300, 300); };
            foci.push_back(pack_focus({{metres(), metres(), metres()}, 1e-3 * bench.number(0, 1000)}));
            for (std::uint32_t w = 0; w < 4; ++w)
                memory[4 * (place + static_cast<std::uint32_t>(f)) + w] = foci.back()[w];
        }
        return foci;
    }
    void require_foci(const std::array<std::uint32_t, channels>& words, const std::vector<FocusWords>& foci) {
        const std::vector<ChannelDrive> drives = engine_drives(engine, foci);
        for (std::uint32_t k = 0; k < channels; ++k) {
            REQUIRE(words[k] >> 16 == drives[k].amplitude);
            if (drives[k].amplitude != 0) REQUIRE((words[k] & 0xffff) == drives[k].phase);
        }
    }

private:
    std::uint16_t coming_ = 0;
};
}  // namespace

TEST_CASE("drive loader: the words of timings and of amplitudes, in CHANNELS + 8 clocks, at least 33") {
    Loader loader;
    for (const bool amplitudes : {false, true}) {
        const std::uint32_t at =
            static_cast<std::uint32_t>(loader.bench.number(0, PARAMETER_RECORDS - 1)) * record_words;
        const std::vector<int> header = {1250, amplitudes ? 0 : 100 << 8, 1, amplitudes ? 256 : 0};
        for (std::uint32_t i = 0; i < record_words; ++i)
            loader.memory[at + i] = static_cast<std::uint16_t>(i < 4 ? header[i] : loader.bench.number(0, 0xffff));
        const Load load = loader.load(at / record_words + 1);
        REQUIRE(load.first_address == at);
        REQUIRE(!load.silent);
        REQUIRE(load.clocks == static_cast<int>(load_clocks({.channels = channels, .width_bits = 1})));
        REQUIRE((loader.bench->o_amplitudes != 0) == amplitudes);
        const auto words = loader.take_over();
        for (std::uint32_t k = 0; k < channels; ++k) {
            const std::uint32_t word = loader.memory[at + 4 + k], high = word >> 8, low = word & 0xff;
            REQUIRE(words[k] == (amplitudes ? high << 24 | high << 16 | low << 8 : 0xffff0000U | word));
        }
    }
}

TEST_CASE("drive loader: one to eight foci, in as many clocks as rtl/README.md says") {
    Loader loader;
    loader.set_up();
    for (int foci = 1; foci <= most; ++foci) {
        loader.bench->i_foci_base = 40;
        loader.bench->i_foci_count = 3;
        loader.bench->i_foci_last = static_cast<std::uint8_t>(foci - 1);
        for (std::uint32_t n = 0; n < 3; ++n) {
            const std::uint32_t place = 40 + n * static_cast<std::uint32_t>(foci);
            const std::vector<FocusWords> written = loader.write_foci(place, foci);
            const Load load = loader.load(PARAMETER_RECORDS + 1 + n);
            REQUIRE(load.first_address == 4 * place);
            REQUIRE(!load.refused);
            REQUIRE(loader.bench->o_cycle_length == 1250);
            REQUIRE(load.clocks ==
                    static_cast<int>(load_clocks({.channels = channels}, static_cast<std::uint32_t>(foci))));
            loader.require_foci(loader.take_over(), written);
        }
    }
}

TEST_CASE(
    "drive loader: a focus record is played to the memory's last word, and refused beyond it and beyond the count") {
    Loader loader;
    int refused = 0;
    for (int i = 0; i < 600; ++i) {
        const int foci = loader.bench.number(1, most);
        const int base =
            loader.bench.chance(0.1) ? loader.bench.number(0, 65535) : loader.bench.number(0, memory_words / 4);
        const int count = loader.bench.chance(0.1) ? loader.bench.number(0, 65535) : loader.bench.number(0, 40);
        // Often the record that just fits, or the next one.
        const int fits = (static_cast<int>(memory_words) / 4 - base) / foci;
        int n = loader.bench.number(0, 40);
        if (loader.bench.chance(0.3)) n = count + loader.bench.number(-1, 0);
        if (loader.bench.chance(0.3)) n = fits + loader.bench.number(-1, 0);
        n = std::clamp(n, 0, 65535 - PARAMETER_RECORDS - 1);
        loader.bench->i_foci_base = static_cast<std::uint16_t>(base);
        loader.bench->i_foci_count = static_cast<std::uint16_t>(count);
        loader.bench->i_foci_last = static_cast<std::uint8_t>(foci - 1);
        const Load load = loader.load(PARAMETER_RECORDS + 1 + static_cast<std::uint32_t>(n));
        const bool there = n < count && 4LL * base + 4LL * foci * (n + 1LL) <= memory_words;
        INFO(n << " of " << count << ", " << foci << " foci each, from " << base);
        REQUIRE(load.refused == !there);
        REQUIRE(load.silent == !there);
        REQUIRE(load.first_address.has_value() == there);
        if (there) REQUIRE(*load.first_address == static_cast<std::uint32_t>(4 * (base + n * foci)));
        refused += !there;
        loader.drop();
    }
    REQUIRE(refused > 100);
    REQUIRE(refused < 500);
}

TEST_CASE("drive loader: a load that is dropped at any clock leaves nothing behind") {
    Loader loader;
    loader.set_up();
    loader.bench->i_foci_count = 5;
    loader.bench->i_foci_last = 7;
    for (int clocks = 0; clocks < 240; ++clocks) {
        const std::vector<FocusWords> written = loader.write_foci(8, 8);
        loader.ask(loader.bench.chance(0.3) ? 1 : PARAMETER_RECORDS + 1);
        for (int i = 0; i < clocks; ++i) loader.clock();
        loader.drop();
        const Load load = loader.load(PARAMETER_RECORDS + 2);
        REQUIRE(load.clocks == static_cast<int>(load_clocks({.channels = channels}, 8)));
        REQUIRE(!load.refused);
        loader.require_foci(loader.take_over(), written);
    }
}
