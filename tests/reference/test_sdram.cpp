// SPDX-License-Identifier: Apache-2.0
// A board whose records lie in an SDRAM against the reference board, which has no such memory: commands that come early
// in a carrier period find their records fetched in time, so every pulse is at the same clock. Answers may be some
// clocks late.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <random>

#include "lock_step.hpp"
#include "reference_board.hpp"
#include "simulated_board.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

constexpr std::uint64_t period = 1250;
using Words = std::vector<std::uint16_t>;

class Both {
public:
    explicit Both(std::uint32_t seed) : random_(seed) {
        of_core_.watch(core_);
        of_reference_.watch(reference_);
        run_to_cycle(4);
    }

    std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_()) % count; }
    std::uint16_t word() { return static_cast<std::uint16_t>(random_()); }
    [[nodiscard]] const interface::CoreParameters& parameters() const { return core_.parameters(); }

    void say(interface::Command command, const Words& words) {
        const bool message = command == interface::Command::stream;
        Bytes payload;
        for (const std::uint16_t one : words) {
            payload.push_back(static_cast<std::uint8_t>(one));
            payload.push_back(static_cast<std::uint8_t>(one >> 8));
        }
        const Bytes frame = link::encode_request(message ? session : number_, command, payload);
        if (!message) ++number_;
        core_.send(frame);
        reference_.send(frame);
    }
    void write(std::uint32_t address, const Words& words) {
        Words all = {static_cast<std::uint16_t>(address), static_cast<std::uint16_t>(address >> 16)};
        all.insert(all.end(), words.begin(), words.end());
        say(interface::Command::write, all);
    }
    void ask(interface::Command command, std::uint32_t address, std::uint32_t bytes) {
        say(command, {static_cast<std::uint16_t>(address), static_cast<std::uint16_t>(address >> 16),
                      static_cast<std::uint16_t>(bytes)});
    }

    /// To the beginning of a cycle, this many from now on, and compares what was seen meanwhile.
    void run_to_cycle(unsigned count) {
        const std::size_t before = of_core_.cycles.size();
        REQUIRE(core_.run_until([&] { return of_core_.cycles.size() >= before + count; }, 20 * period * count));
        reference_.run(core_.now() - reference_.now());
        compare();
    }
    [[nodiscard]] std::uint64_t cycles() const { return cycles_; }
    [[nodiscard]] std::uint64_t edges() const { return edges_; }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_.size(); }
    std::uint8_t session = 5;

private:
    void compare() {
        INFO("at clock " << core_.now());
        REQUIRE(of_core_.cycles.size() == of_reference_.cycles.size());
        for (std::size_t i = 0; i < of_core_.cycles.size(); ++i) {
            INFO(fmt::format("cycle at {}, record {}; reference at {}, record {}", of_core_.cycles[i].clock,
                             of_core_.cycles[i].index, of_reference_.cycles[i].clock, of_reference_.cycles[i].index));
            REQUIRE(of_core_.cycles[i] == of_reference_.cycles[i]);
        }
        REQUIRE(of_core_.edges == of_reference_.edges);
        for (const sim::Arrival& arrival : of_core_.arrivals) bytes_.push_back(arrival.byte);
        for (const sim::Arrival& arrival : of_reference_.arrivals) expected_.push_back(arrival.byte);
        const std::size_t both = std::min(bytes_.size(), expected_.size());
        REQUIRE(std::equal(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(both), expected_.begin()));
        cycles_ += of_core_.cycles.size();
        edges_ += of_core_.edges.size();
        of_core_.clear();
        of_reference_.clear();
    }

    sim::SimulatedBoard core_{"colorlight-5a-75e-v7.1-sdram", {.power_up_seed = 3}};
    sim::ReferenceBoard reference_{"colorlight-5a-75e-v7.1-sdram"};
    Seen of_core_, of_reference_;
    std::mt19937 random_;
    std::uint8_t number_ = 5;
    Bytes bytes_, expected_;
    std::uint64_t cycles_ = 0, edges_ = 0;
};

Words record_of(Both& boards) {
    Words words(interface::record_header_words);
    interface::record_field::cycle_length.set(words, period);
    interface::record_field::prescaler.set(words, 1);
    interface::record_field::kind.set(words, static_cast<unsigned>(interface::Kind::amplitudes));
    for (std::uint32_t k = 0; k < boards.parameters().channels; ++k) words.push_back(boards.word());
    return words;
}

std::uint32_t address_of(const Both& boards, std::uint32_t index) {
    return (index - 1) * 2 * (boards.parameters().channels + interface::record_header_words);
}

/// Foci in reach of the array, which begin at `base`, in units of four words.
void set_foci(Both& boards, std::uint32_t base, std::uint32_t foci) {
    for (std::uint32_t k = 0; k < boards.parameters().channels; k += 10) {
        Words words;
        for (std::uint32_t i = 0; i < 10; ++i)
            words.insert(words.end(),
                         {static_cast<std::uint16_t>(1280 * i), static_cast<std::uint16_t>(128 * k), 0, 0});
        boards.write(interface::geometry_base + 8 * k, words);
        boards.run_to_cycle(1);
    }
    Words parameters(interface::parameters_words);
    namespace field = interface::parameters_field;
    field::foci_base.set(parameters, base);
    field::foci_count.set(parameters, 0x7fff - boards.parameters().records);
    field::foci_last.set(parameters, foci - 1);
    field::foci_cycle.set(parameters, period);
    field::wave_number.set(parameters, 122'000);
    field::gain.set(parameters, 39953 / foci);
    boards.write(interface::parameters_base, parameters);
    boards.run_to_cycle(2);
}

Words foci_of(Both& boards, std::uint32_t foci) {
    Words words;
    for (std::uint32_t i = 0; i < foci; ++i) {
        const auto place = [&] { return static_cast<std::uint16_t>(boards.below(12000)); };
        const std::uint16_t x = place(), y = place(), z = static_cast<std::uint16_t>(15000 + place());
        // 18 bits each: their upper two are in the last word, below the amplitude.
        words.insert(words.end(), {x, y, z, static_cast<std::uint16_t>(boards.below(256) << 8)});
    }
    return words;
}

void open(Both& boards) {
    boards.say(interface::Command::identify, {});
    boards.say(interface::Command::watchdog, {0});
    boards.say(interface::Command::enable, {});
    boards.run_to_cycle(2);
}

}  // namespace

TEST_CASE("reference: records anywhere in an SDRAM play as those in block RAM, while others are written and read") {
    Both boards(Catch::rngSeed());
    open(boards);
    const std::uint32_t foci = 1 + boards.below(8), base = 60'000, last = boards.parameters().records;
    set_foci(boards, base, foci);
    // Two banks of a sequence and their records: while one plays, the other one is written.
    constexpr std::uint32_t entries = 60;
    std::vector<std::uint32_t> used[2];
    for (unsigned round = 0; round < 12; ++round) {
        std::vector<std::uint32_t>& bank = used[round % 2];
        bank.clear();
        Words sequence;
        for (std::uint32_t i = 0; i < entries; ++i) {
            // The banks' records are odd or even ones, so that none is written while it is loaded. What a START begins
            // with has no foci, which may be late for the same period as without an SDRAM.
            const bool of_foci = i > 0 && boards.below(3) == 0;
            std::uint32_t index =
                of_foci ? last + 1 + 2 * boards.below(1000) + round % 2 : 1 + 2 * boards.below(1000) + round % 2;
            if (i == 0) index = last - round % 2;
            const Words words = of_foci ? foci_of(boards, foci) : record_of(boards);
            boards.write(of_foci ? 8 * (base + (index - last - 1) * foci) : address_of(boards, index), words);
            bank.push_back(index);
            sequence.insert(sequence.end(),
                            {static_cast<std::uint16_t>(index), static_cast<std::uint16_t>(1 + i % 3 / 2)});
            boards.run_to_cycle(1);
        }
        const std::uint32_t first = 1 + round % 2 * entries;
        for (std::uint32_t i = 0; i < entries; i += 20) {
            boards.write(interface::sequence_base + 4 * (first + i),
                         {sequence.begin() + 2 * i, sequence.begin() + 2 * std::min(i + 20, entries)});
            boards.run_to_cycle(1);
        }
        boards.say(interface::Command::start,
                   {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(entries), 0});
        boards.run_to_cycle(2);
        for (int i = 0; i < 5; ++i) {
            const std::uint32_t index = bank[boards.below(entries)];
            const std::uint32_t address =
                index > last ? 8 * (base + (index - last - 1) * foci) : address_of(boards, index);
            boards.ask(boards.below(2) == 0 ? interface::Command::read : interface::Command::digest, address,
                       index > last ? 8 * foci : 208);
            boards.run_to_cycle(4);
        }
    }
    boards.run_to_cycle(100);
    fmt::print("{} cycles, {} edges, {} bytes; {} foci a record\n", boards.cycles(), boards.edges(), boards.bytes(),
               foci);
    REQUIRE(boards.edges() > 50'000);
    REQUIRE(boards.bytes() > 12 * 60 * 6);
}

TEST_CASE("reference: a stream whose slots lie in an SDRAM plays each pattern in its own period") {
    const bool of_foci = GENERATE(false, true);
    Both boards(Catch::rngSeed());
    open(boards);
    constexpr std::uint32_t foci = 8, base = 60'000;
    set_foci(boards, base, foci);
    const std::uint32_t last = boards.parameters().records;
    // Slots: 64 of 256, from here on.
    boards.write(interface::stream_base, {static_cast<std::uint16_t>(of_foci ? last + 1 : 300), 6, 4, 3000});
    boards.run_to_cycle(1);
    for (std::uint32_t k = 300; !of_foci && k < 364; ++k) {  // their headers
        boards.write(address_of(boards, k), record_of(boards));
        boards.run_to_cycle(1);
    }
    std::uint64_t next = boards.cycles() + 8;
    for (unsigned datagram = 0; datagram < 300; ++datagram) {
        const std::uint32_t patterns = of_foci ? 7 : 2;
        Words words = {static_cast<std::uint16_t>(next), static_cast<std::uint16_t>(next >> 16), 0};
        for (std::uint32_t i = 0; i < patterns; ++i) {
            const Words pattern = of_foci ? foci_of(boards, foci) : record_of(boards);
            words.insert(words.end(), pattern.begin() + (of_foci ? 0 : interface::record_header_words), pattern.end());
        }
        boards.say(interface::Command::stream, words);
        next += patterns + (boards.below(10) == 0 ? 1 : 0);  // some are lost
        boards.run_to_cycle(patterns);
        while (boards.cycles() + 8 < next) boards.run_to_cycle(1);
    }
    fmt::print("{} cycles, {} edges\n", boards.cycles(), boards.edges());
    REQUIRE(boards.edges() > 50'000);
}
