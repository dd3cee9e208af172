// SPDX-License-Identifier: Apache-2.0
// What the other files promise, at the values where a single wrong bit in the RTL shows: each case kills a mutant
// (tests/mutation) that no other test had noticed.
#include "../refusal.hpp"
#include "wide_bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

constexpr std::uint16_t never = 0xffff;

/// Two records of which one channel is high for 30,000 clocks, longer than the guard's bound of 20,000: its pulse
/// begins in the last tick of the first one, and then takes the longer ticks of the second one.
Image too_long(std::uint32_t channel) {
    Image image = image_of(16, {record(16, 256, 1, 250, never), record(16, 300, 120, 1, never)});
    image.records[0].timings[channel] = 255;
    return image;
}

void play(Bench& bench, const Image& image) {
    bench.load(image);
    bench.open();
    bench.client.select(1);
}

void play_in_turn(Bench& bench, const Image& image) {
    bench.load(image);
    bench.open();
    bench.client.start(1, static_cast<std::uint16_t>(image.records.size()), 0);
}

/// Runs clock by clock; some pin must be high when this begins, and none in any clock in which outputs are disabled.
void require_low_when_disabled(Bench& bench, std::uint64_t clocks) {
    REQUIRE(bench.board.run_until([&] { return bench.board.any_pin(); }, 10'000));
    bool high = false;
    for (std::uint64_t i = 0; i < clocks; ++i) {
        bench.board.run(1);
        high = high || (bench.board.any_pin() && !bench.board.outputs().enabled);
    }
    REQUIRE_FALSE(high);
    REQUIRE_FALSE(bench.board.outputs().enabled);
}

}  // namespace

TEST_CASE("contract 1: what was cut by disabling does not go on after enabling, nor across a change of record",
          "[contract1]") {
    auto g = generator();
    Bench bench;
    // 1,750 clocks high, from tick 200 to tick 194 of the next cycle, which is the other record's.
    const Image image = image_of(16, {record(16, 256, 7, 250, 200), record(16, 256, 7, 250, 200)});
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, 0);
    bench.wait_for_index(2);
    std::vector<std::uint64_t> cuts;
    const auto run = [&](std::uint64_t clocks) {
        for (std::uint64_t i = 0; i < clocks; ++i) {
            const bool enabled = bench.board.outputs().enabled;
            bench.board.run(1);
            if (enabled && !bench.board.outputs().enabled) cuts.push_back(bench.board.now() - 1);
        }
    };
    std::uint8_t number = 4;  // after identify, watchdog, enable, start
    for (int i = 0; i < 30; ++i) {
        run(random(g, 0, 1792));
        bench.board.send(link::encode_request(number++, interface::Command::disable, {}));
        bench.board.send(link::encode_request(number++, interface::Command::enable, {}));
        run(6000);
        REQUIRE(bench.board.outputs().enabled);
    }
    REQUIRE(cuts.size() == 30);
    std::size_t cut = 0;
    for (const Pulse& p : bench.recorder.pulses()) {
        if (p.fall - p.rise == 1750) continue;
        REQUIRE(std::ranges::find(cuts, p.fall) != cuts.end());
        ++cut;
    }
    REQUIRE(cut > 16 * 20);
}

TEST_CASE("contract 4: one channel alone that is high for too long ends every output", "[contract4]") {
    for (std::uint32_t k = 0; k < 16; ++k) {
        CAPTURE(k);
        Bench bench;
        play_in_turn(bench, too_long(k));
        REQUIRE(bench.board.run_until([&] { return bench.board.outputs().fault; }, 60'000));
        REQUIRE_FALSE(bench.board.outputs().enabled);
        REQUIRE(bench.recorder.pulses().size() == 1);
        const Pulse pulse = bench.recorder.pulses()[0];
        REQUIRE(pulse.channel == k);
        REQUIRE(pulse.fall - pulse.rise <= 20'000);
        REQUIRE(pulse.fall - pulse.rise >= 9999);  // nor much too early: half the bound is always allowed
    }
}

TEST_CASE("contract 4: no pin is high in a clock in which outputs are disabled", "[contract4]") {
    Bench bench;
    Image image = image_of(16, {record(16, 250, 1, 125, 0)});
    for (std::uint16_t k = 0; k < 16; ++k) image.records[0].timings[k] = static_cast<std::uint16_t>(k * 15);
    SECTION("by command") {
        play(bench, image);
        bench.board.send(link::encode_request(4, interface::Command::disable, {}));
        require_low_when_disabled(bench, 5000);
    }
    SECTION("by the watchdog") {
        play(bench, image);
        bench.client.set_watchdog(1);
        require_low_when_disabled(bench, 60'000);
        REQUIRE(bench.client.status().watchdog_trips == 1);
    }
    SECTION("by the guard") {
        play_in_turn(bench, too_long(3));
        require_low_when_disabled(bench, 40'000);
        REQUIRE(bench.client.status().guard_trips == 1);
    }
    SECTION("by reset") {
        play(bench, image);
        REQUIRE(bench.board.run_until([&] { return bench.board.any_pin(); }, 10'000));
        bench.board.reset(1);
        REQUIRE_FALSE(bench.board.outputs().enabled);
        REQUIRE_FALSE(bench.board.any_pin());
    }
}

TEST_CASE("contract 4: a pin may be high for almost half the bound, whenever that begins", "[contract4]") {
    Bench bench;
    // 9,960 clocks high of 10,296, so that each pulse begins elsewhere in the guard's windows of 9,999.
    const Image image = image_of(16, {record(16, 256, 1, 249, 255), record(16, 251, 40, 1, never)});
    play_in_turn(bench, image);
    bench.board.run(110ULL * 10'296);
    REQUIRE(bench.client.status().guard_trips == 0);
    require_equal(bench.check(image), 16ULL * 100);
}

TEST_CASE("contract 4: nothing is left of a guard trip that a reset comes together with", "[contract4]") {
    std::uint64_t trip = 0;
    {
        Bench bench;
        play_in_turn(bench, too_long(7));
        while (!bench.board.outputs().fault && bench.board.now() < 1'000'000) bench.board.run(1);
        REQUIRE(bench.board.outputs().fault);
        trip = bench.board.now();
    }
    for (unsigned before = 1; before <= 5; ++before) {
        CAPTURE(before);
        Bench bench;
        play_in_turn(bench, too_long(7));
        REQUIRE(bench.board.now() + 10 < trip);
        bench.board.run(trip - before - bench.board.now());
        bench.board.reset(1);
        bench.board.run(100);
        REQUIRE_FALSE(bench.board.outputs().fault);
        bench.client.identify();
        REQUIRE(bench.client.status().guard_trips == 0);
    }
}

TEST_CASE("contract 4: the bound holds for a board that starts by itself, whatever its registers held",
          "[contract4][power-up]") {
    std::size_t started = 0;
    for (std::uint32_t seed = 1; seed <= 24; ++seed) {
        CAPTURE(seed);
        Bench bench("small-16", {.power_up_seed = seed, .reset_clocks = 4});
        if (bench.board.sequence_memory().empty()) return;  // a netlist's memories cannot be filled before it starts
        bench.load_autostart(too_long(5));
        bench.board.run(37'000 + bench.autostart_clocks());
        for (const Pulse& p : bench.recorder.pulses()) REQUIRE(p.fall - p.rise <= 20'000);
        started += bench.recorder.pulses().size();
    }
    REQUIRE(started > 0);
}

TEST_CASE("contract 4: a record with any reserved bit set is refused", "[contract4]") {
    Bench bench;
    std::vector<Record> records(8, record(16, 100, 1, 20, 5));
    const Image image = image_of(16, records);
    bench.load(image);
    bench.open();
    for (std::uint32_t i = 0; i < 8; ++i)  // word 3, bits 15…8
        bench.client.write(interface::primary_base + i * 40 + 6, words({static_cast<std::uint16_t>(0x100U << i)}));
    bench.client.start(1, 8, 1);
    bench.board.run(20'000);
    REQUIRE(bench.client.status().refused_records == 8);
    REQUIRE(bench.recorder.pulses().empty());
}

TEST_CASE("contract 4: a pulse one tick shorter than its cycle plays, one as long is refused", "[contract4]") {
    for (std::uint32_t bit = 1; bit <= 8; ++bit)
        for (const std::uint32_t cycle : {(1U << bit) - 1, 1U << bit, (1U << bit) + 1}) {
            if (cycle < 2 || cycle > 256) continue;
            CAPTURE(cycle);
            Bench bench;
            std::vector<Record> records = {record(16, cycle, 3, static_cast<std::uint8_t>(cycle - 1), 0)};
            if (cycle < 256) records.push_back(record(16, cycle, 3, static_cast<std::uint8_t>(cycle), 0));
            const Image image = image_of(16, records);
            play(bench, image);
            bench.wait_for_index(1);
            bench.board.run(3000);
            REQUIRE(bench.client.status().refused_records == 0);
            require_equal(bench.check(image), 16);
            if (cycle == 256) continue;
            bench.client.select(2);
            bench.wait_for_index(2);
            REQUIRE(bench.client.status().refused_records == 1);
        }
}

TEST_CASE("contract 5: a frame too short for a command is damaged though its CRC is good, and none at all is none",
          "[contract5]") {
    Bench bench;
    bench.client.identify();
    for (const Bytes& start : {Bytes{}, Bytes{0x5a}}) {
        Bytes frame = start;
        const std::uint16_t crc = link::crc16(frame);
        frame.push_back(static_cast<std::uint8_t>(crc >> 8));
        frame.push_back(static_cast<std::uint8_t>(crc));
        Bytes code = link::cobs_encode(frame);
        code.push_back(0);
        REQUIRE(bench.talk(code).empty());
    }
    REQUIRE(bench.client.status().frames_damaged == 2);
    REQUIRE(bench.talk({0, 0, 0, 0, 0}).empty());
    REQUIRE(bench.client.status().frames_damaged == 2);
}

TEST_CASE("contract 5: one byte more than a command takes is a wrong length", "[contract5]") {
    Bench bench;
    REQUIRE(bench.talk(link::encode_request(0, interface::Command::identify, {})).size() == 1);
    const std::vector<std::pair<interface::Command, Bytes>> whole = {
        {interface::Command::stop, {}},
        {interface::Command::select, words({0, 0})},
        {interface::Command::push, words({1, 1})},
        {interface::Command::write, words({0, 0, 7})},
    };
    for (const auto& [command, payload] : whole) {
        Bytes odd = payload;
        odd.push_back(0);
        const auto replies = bench.talk(link::encode_request(1, command, odd));
        REQUIRE(replies.size() == 1);
        REQUIRE(replies[0].status == interface::Status::bad_length);
        REQUIRE(replies[0].expected == 1);
    }
    REQUIRE(bench.memory(interface::primary_base, 2) == Bytes{0, 0});
}

TEST_CASE("contract 6: no bit of an index above RECORDS is overlooked", "[contract6]") {
    Bench bench;
    // Memory repeats the same four words, so that wherever a wrong index leads to, there is a record that can be
    // played.
    Record everywhere = record(16, 100, 1, 0, 0);
    for (std::size_t k = 0; k < 16; ++k) everywhere.timings[k] = std::array<std::uint16_t, 4>{100, 0, 1, 0}[k % 4];
    Image image = image_of(16, std::vector<Record>(40, everywhere));
    image.sequence.clear();
    for (std::uint32_t bit = 6; bit < 15; ++bit)
        image.sequence.push_back({static_cast<std::uint16_t>(1U << bit | 1U), 1});
    bench.load(image);
    bench.open();
    bench.client.start(1, 9, 1);
    bench.board.run(20'000);
    REQUIRE(bench.client.status().refused_records == 9);
}

TEST_CASE("contract 6: an index above RECORDS is silence at once, not after a load", "[contract6]") {
    Bench bench;
    Image image = image_of(16, {record(16, 16, 1, 1, 1)});  // a cycle shorter than a load
    image.sequence.clear();
    for (std::uint16_t index = 41; index < 64; ++index) {
        image.sequence.push_back({1, 1});
        image.sequence.push_back({index, 4});  // in which record 1 is loaded again
    }
    bench.load(image);
    bench.open();
    bench.client.start(1, static_cast<std::uint16_t>(image.sequence.size()), 1);
    bench.board.run(60'000);
    REQUIRE(bench.client.status().refused_records == 23);
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 7: every power of two is a cycle length and a prescaler", "[contract7]") {
    for (std::uint32_t bit = 1; bit < 24; ++bit) {
        CAPTURE(bit);
        Bench bench;
        const auto pulse = static_cast<std::uint8_t>(std::min((1U << bit) - 1, 255U));
        const Image image =
            image_of(16, {record(16, 1U << bit, 1, pulse, never), record(16, 2, 1U << bit, bit > 10 ? 0 : 1, never)});
        for (const std::uint16_t index : {std::uint16_t{1}, std::uint16_t{2}}) {
            bench.load(image);
            bench.open();
            bench.client.select(index);
            // What plays is seen a tick late, of up to 8 million clocks; whether it is refused is known when it is
            // loaded.
            if (index == 1 || bit < 12) bench.wait_for_index(index);
            bench.board.run(5000);
            REQUIRE(bench.client.status().refused_records == 0);
            bench.board.reset();
        }
    }
}

TEST_CASE("contract 7: no bit of the counter or the prescaler is overlooked", "[contract7][long][deep]") {
    const auto [cycle, prescaler] = GENERATE(table<std::uint32_t, std::uint32_t>({{0x800000, 1}, {1, 0x800000}}));
    CAPTURE(cycle, prescaler);
    Bench bench;
    play(bench, image_of(16, {record(16, cycle, prescaler, 0, 2)}));
    bench.wait_for_index(1, 9'000'000);  // a tick late
    const auto& cycles = bench.recorder.cycles();
    const std::size_t begin = cycles.size();
    REQUIRE(bench.board.run_until([&] { return cycles.size() > begin; }, 9'000'000));
    REQUIRE(cycles[begin].clock - cycles[begin - 1].clock == 0x800000);
}

TEST_CASE("contract 7: a dwell is exact whatever the parity of the cycle", "[contract7]") {
    const std::uint16_t dwell =
        GENERATE(std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}, std::uint16_t{0x5555}, std::uint16_t{0xaaaa});
    Bench bench;
    const Image image = image_of(16, {record(16, 23, 1, 2, 3)});
    bench.load(image);
    bench.open();
    bench.client.select(1, dwell);
    bench.board.run(2000);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 2'000'000));
    std::uint32_t cycles = 0;
    for (const sim::Dwell& d : bench.recorder.dwells()) cycles += d.index == 1 ? d.cycles : 0;
    REQUIRE(cycles == dwell);
}

TEST_CASE("contract 2: a record is late when its predecessor leaves it one clock less than a load", "[contract2]") {
    // A load begins with the last tick in which a pulse from before the change can be high, and takes 33 clocks.
    const auto [pulse, prescaler, least] =
        GENERATE(table<std::uint8_t, std::uint32_t, std::uint32_t>({{1, 1, 34}, {20, 1, 53}, {9, 4, 17}}));
    CAPTURE(static_cast<int>(pulse), prescaler);
    for (const std::uint32_t cycle : {least - 1, least}) {
        CAPTURE(cycle);
        Bench bench;
        bench.load(image_of(16, {record(16, cycle, prescaler, pulse, 1), record(16, cycle, prescaler, pulse, 0)}));
        bench.open();
        bench.client.start(1, 2, 30);
        bench.wait_for_index(2);
        bench.board.run(20'000);
        REQUIRE((bench.client.status().underruns == 0) == (cycle == least));
    }
}

TEST_CASE("contract 2: every change that is late is counted, and once", "[contract2]") {
    const std::uint32_t cycle = GENERATE(11U, 15U, 16U, 21U);  // a load takes 33 clocks
    CAPTURE(cycle);
    Bench bench;
    const Image image = image_of(16, {record(16, cycle, 1, 3, 1), record(16, cycle, 1, 3, 2)});
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, 30);
    bench.wait_for_index(2);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 100'000));
    std::uint32_t late = 0;
    for (const sim::Dwell& d : bench.recorder.dwells()) late += d.index != 0 && d.cycles > 1 ? 1 : 0;
    REQUIRE(late >= 58);
    // The silence at the end needs no loading, but its entry has to be fetched.
    REQUIRE(bench.client.status().underruns == late);
}

TEST_CASE("contract 4: no bit of a length in clocks is overlooked, and none that was too much is forgotten",
          "[contract4]") {
    Bench bench;
    std::vector<Record> records = {
        record(16, 100, 0x1005, 1, 5),   // a pulse of 4,101 clocks, which is 5 in 11 bits
        record(16, 0x800000, 17, 0, 5),  // a cycle of 2^27 + 2^23 clocks, which is 2^23 in 26 bits
    };
    // The smallest cycles that are longer than a second by one bit.
    const std::uint64_t longest = bench.board.parameters().clock_hz;
    for (unsigned bit = 2; bit < 26; ++bit)
        if ((longest >> bit & 1U) == 0)
            records.push_back(record(16, static_cast<std::uint32_t>(((longest >> bit | 1U) << bit) / 4), 4, 0, 5));
    const Image image = image_of(16, records);
    bench.load(image);
    bench.open();
    bench.client.start(1, static_cast<std::uint16_t>(records.size()), 1);
    bench.board.run(100'000);
    REQUIRE(bench.client.status().refused_records == records.size());
}

TEST_CASE("contract 2: a record that is asked for while another one loads plays as it is", "[contract2]") {
    auto g = generator();
    Bench bench;
    const Image image = image_of(16, {record(16, 64, 1, 5, 3), record(16, 66, 1, 5, 4), record(16, 50, 3, 5, 6)});
    bench.load(image);
    bench.open();
    for (int i = 0; i < 60; ++i) {
        bench.client.start(1, 2, 0);  // loads half of the time
        bench.board.run(random(g, 1000, 1200));
        bench.client.select(3);
        bench.board.run(2000);
        REQUIRE(bench.board.outputs().index == 3);
        const auto& cycles = bench.recorder.cycles();
        const std::uint64_t length = cycles.back().clock - cycles[cycles.size() - 2].clock;
        REQUIRE(length == 150);
    }
    REQUIRE(bench.client.status().refused_records == 0);
}

TEST_CASE("contract 2: a command in any clock in which the next record may be taken over is not answered by that one",
          "[wide][takeover]") {
    auto g = generator();
    wide::Wide bench;
    bench.open();
    constexpr std::uint32_t cycle = 1250;
    for (std::uint16_t i = 1; i <= 3; ++i) bench.random_record(g, i, cycle);
    constexpr std::uint16_t dwell = 6;  // longer than START's answer takes
    bench.write_sequence({{1, dwell}, {2, 400}});
    for (std::uint32_t place = 0; place < 90; ++place) {
        CAPTURE(place);
        const auto& cycles = bench.recorder.cycles();
        std::size_t first = cycles.size();
        bench.client.start(1, 2, 0);
        bench.wait_for_index(1);
        while (cycles[first].index != 1) ++first;
        const std::uint64_t change = cycles[first].clock + std::uint64_t{dwell} * cycle;
        // The frame is 1,667 clocks long. Record 2 is taken over some 60 clocks before the change.
        bench.board.run(change - 1800 + place - bench.board.now());
        bench.client.submit({interface::Command::select, words({3, 0})});
        bench.client.flush();
        // Perhaps record 2 has a cycle before, but not 400 of them.
        bench.board.run(change + cycle + 20 - bench.board.now());
        REQUIRE(bench.board.outputs().index == 3);
        bench.client.wait();
    }
}

TEST_CASE("contract 10: no bit of a carrier period's number is overlooked", "[contract10][long][periods]") {
    using link::When;
    Bench bench;
    bench.load(image_of(16, {record(16, 500, 1, 20, 5)}));
    bench.open();
    for (unsigned bit = 12; bit < 48; ++bit) {
        const std::uint64_t period = std::uint64_t{1} << bit;
        CAPTURE(bit);
        bench.client.start(1, 1, 0, When::at_period(period));
        REQUIRE(bench.client.status().waiting);
        // Another one, which differs in one bit.
        const std::uint64_t other = period ^ std::uint64_t{1} << (bit + 17) % 48;
        REQUIRE_REFUSED(bench.client.start(1, 1, 0, When::at_period(other)));
        bench.client.stop();
        const link::Status status = bench.client.status();
        REQUIRE_FALSE(status.waiting);
        REQUIRE(status.present_index == 0);
        REQUIRE(status.late_changes == 0);
    }
}
