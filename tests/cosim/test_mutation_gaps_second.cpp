// SPDX-License-Identifier: Apache-2.0
// As test_mutation_gaps.cpp, for what came with the second instrument: each case kills a mutant (tests/mutation) that
// no other test had noticed.
#include <memory>
#include <optional>

#include "../refusal.hpp"
#include "wide_bench.hpp"

using namespace haptogram;
using namespace haptogram::test;
using namespace haptogram::test::wide;

namespace {

Words read_words(Bench& bench, std::uint32_t address, std::size_t count) {
    const Bytes bytes = bench.client.read(address, static_cast<std::uint16_t>(2 * count));
    Words words;
    for (std::size_t i = 0; i < bytes.size(); i += 2)
        words.push_back(static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8));
    return words;
}

}  // namespace

TEST_CASE("second instrument: no bit of a setting or of the ring block is overlooked",
          "[second][wide][settings][ring]") {
    auto g = generator();
    Wide bench;
    bench.client.identify();
    // What each word holds, see the parameters block.
    const Words settings = {0xffff, 0xffff, 0xf, 0xffff, 0xffff, 0x3, 0xffff, 0x3, 0xffff, 0xffff, 0xfff};
    const Words ring(3, 0xffff);
    const auto keeps = [&](std::uint32_t address, const Words& held) {
        Words written;
        for (std::size_t i = 0; i < held.size(); ++i)
            written.push_back(static_cast<std::uint16_t>(random(g, 0, 65535)));
        for (int half = 0; half < 2; ++half) {  // each bit is 1 once
            bench.write(address, written);
            const Words found = read_words(bench, address, held.size());
            for (std::size_t i = 0; i < held.size(); ++i) REQUIRE(found[i] == (written[i] & held[i]));
            for (std::uint16_t& word : written) word = static_cast<std::uint16_t>(~word);
        }
    };
    for (int round = 0; round < 4; ++round) {
        keeps(interface::parameters_base, settings);
        keeps(interface::ring_base, ring);
    }
}

TEST_CASE("live foci: a ring of any length, anywhere, goes round and round", "[second][wide][live][ring]") {
    auto g = generator();
    Wide bench;
    bench.open();
    const FocusEngine engine = square_engine(4, 1.0);
    // All of primary memory is focus records of one focus; the ring is some of them.
    constexpr std::uint16_t all = 1280;
    bench.write_engine(engine, 0, all, 1, false);
    const auto count = static_cast<std::uint16_t>(random(g, 257, 300));
    const auto skipped = static_cast<std::uint16_t>(random(g, 0, all - count));
    const auto first = static_cast<std::uint16_t>(records + 1 + skipped);
    bench.write(interface::ring_base, {skipped, first, count});
    const std::size_t begin = bench.recorder.cycles().size();
    std::size_t pushed = 0;
    while (pushed < count + 20U) {
        std::size_t room = 256 - bench.client.status().live_level;
        if (room < 15) {
            bench.board.run(40'000);
            continue;
        }
        Words words;
        for (std::uint32_t n = random(g, 1, 15); n > 0; --n, ++pushed) {
            const FocusWords focus = random_focus(g);
            words.insert(words.end(), focus.begin(), focus.end());
            Played one{{}, 1250};
            for (const ChannelDrive& drive : engine_drives(engine, std::vector{focus}, false))
                one.emissions.push_back({drive.amplitude, drive.phase});
            bench.book[static_cast<std::uint16_t>(pushed + 1)] = one;
        }
        bench.client.push_foci(words, 1);
    }
    bench.client.push({0}, 0);
    REQUIRE(bench.board.run_until([&] { return bench.client.status().live_level == 0; }, 2'000'000));
    bench.wait_for_index(0);
    bench.board.run(5000);
    std::vector<MeasuredCycle> cycles;
    std::size_t played = 0;
    for (std::size_t i = 0; i < bench.recorder.cycles().size(); ++i) {
        const sim::CycleStart& start = bench.recorder.cycles()[i];
        std::uint16_t number = 0;
        if (i >= begin && start.index != 0) {
            // A focus that was late is heard for longer; each is another index than the one before.
            if (start.index != bench.recorder.cycles()[i - 1].index) {
                REQUIRE(start.index == first + played % count);
                ++played;
            }
            number = static_cast<std::uint16_t>(played);
        }
        cycles.push_back({start.clock, number});
    }
    REQUIRE(played == pushed);
    EmissionModel emission(channel_count);
    require_right(compare_periods(
                      cycles, bench.recorder.pulses(), bench.book, begin + 2, cycles.size() - 2,
                      [](std::size_t) { return Setting{}; }, emission),
                  played * 8);
    REQUIRE(bench.client.status().refused_records == 0);
}

TEST_CASE("live foci: no bit of an index in the ring is overlooked", "[second][wide][live][ring]") {
    auto g = generator();
    Wide bench;
    bench.open();
    const FocusEngine engine = square_engine(4, 1.0);
    // Behind the end of primary memory, where no index is played: one that lost a bit would be record 1 or 2.
    bench.write_engine(engine, 1280, 65535, 1, false);
    bench.random_record(g, 1, 1250);
    bench.random_record(g, 2, 1250);
    std::uint16_t refused = 0;
    for (unsigned bit = 9; bit < 16; ++bit) {
        CAPTURE(bit);
        bench.write(interface::ring_base, {0, static_cast<std::uint16_t>((1U << bit) + 1), 257});
        for (int n = 0; n < 2; ++n) bench.client.push_foci(Words(4), 1);
        bench.board.run(10'000);
        refused = static_cast<std::uint16_t>(refused + 2);
        REQUIRE(bench.client.status().refused_records == refused);
    }
}

TEST_CASE("live foci: the ring must be in primary memory and among the foci, to the last word and index",
          "[second][wide][live][ring]") {
    auto g = generator();
    Wide bench;
    bench.open();
    const FocusEngine engine = square_engine(4, 1.0);
    for (std::size_t each = 1; each <= 3; ++each) {
        const std::uint32_t places = 1280 / static_cast<std::uint32_t>(each);  // of focus records in 5,120 words
        const std::uint32_t count = random(g, 257, std::min(places, 400U));
        const std::uint32_t base = 1280 - count * static_cast<std::uint32_t>(each);
        const std::uint32_t foci_count = random(g, count, 60'000);
        bench.write_engine(engine, 0, static_cast<std::uint16_t>(foci_count), each, false);
        const std::uint32_t first = records + 1 + foci_count - count;  // so that its last one is the last that there is
        CAPTURE(each, count, base, foci_count);
        const auto usable = [&](std::uint32_t b, std::uint32_t f, std::uint32_t c) {
            bench.write(interface::ring_base,
                        {static_cast<std::uint16_t>(b), static_cast<std::uint16_t>(f), static_cast<std::uint16_t>(c)});
            try {
                bench.client.push_foci(Words(4 * each), 1);
            } catch (const Error& error) {
                REQUIRE_REFUSAL(heard::Refusal(error));
                return false;
            }
            bench.client.stop();
            return true;
        };
        REQUIRE(usable(base, first, count));
        REQUIRE_FALSE(usable(base + 1, first, count));
        REQUIRE_FALSE(usable(base, first + 1, count));
        REQUIRE_FALSE(usable(base, first, count + 1));
        REQUIRE(usable(base - 1, first - 1, count));
        for (unsigned bit = 11; bit < 16; ++bit) REQUIRE_FALSE(usable(base | 1U << bit, first, count));
        for (unsigned bit = 12; bit < 16; ++bit) REQUIRE_FALSE(usable(0, first, 1U << bit));
        // An index of a record is none of the ring's.
        REQUIRE(usable(0, records + 1, 257));
        REQUIRE_FALSE(usable(0, records, 257));
        REQUIRE_FALSE(usable(0, records + 1, 256));
        for (unsigned bit = 0; bit < 9; ++bit) REQUIRE_FALSE(usable(0, 1U << bit, 257));
    }
}

TEST_CASE("live foci: what is one focus record too much for the FIFO is refused, and what fills it is not",
          "[second][wide][live][ring]") {
    auto g = generator();
    Wide bench;
    bench.open();
    const FocusEngine engine = square_engine(4, 1.0);
    const std::size_t each = GENERATE(1U, 3U);
    const auto push = [&](std::size_t count, std::uint16_t dwell) {
        return bench.client.push_foci(Words(4 * each * count), dwell);
    };
    bench.write_engine(engine, 0, 400, each, false);
    bench.write(interface::ring_base, {0, records + 1, 300});
    push(1, 60'000);  // plays for as long as this takes
    bench.wait_for_index(records + 1);
    const std::size_t most = 15 / each;
    std::size_t level = 0;
    while (level + most <= 256)
        level = push(random(g, static_cast<std::uint32_t>(most + 1) / 2, static_cast<std::uint32_t>(most)), 1);
    for (; level < 256; level = push(1, 1))
        if (256 - level < most) REQUIRE_REFUSED(push(256 - level + 1, 1));
    REQUIRE_REFUSED(push(1, 1));
    REQUIRE(bench.client.status().live_level == 256);
}

TEST_CASE("second instrument: a new setting of the slew limiter holds for all channels from one carrier period on",
          "[second][wide][slew]") {
    using enum interface::ParametersWord;
    auto g = generator();
    Wide bench;
    bench.open();
    constexpr std::uint32_t cycle = 2 * lead;  // so that words are made half of the time
    bench.random_record(g, 1, cycle);
    bench.random_record(g, 2, cycle);
    bench.write_sequence({{1, 10}, {2, 10}});
    SlewLimit slew{.mode = Slew::rate, .phase_rate = 400};
    bench.set(slew_mode, static_cast<std::uint32_t>(slew.mode));
    bench.set(phase_rate, slew.phase_rate);
    std::size_t begin = bench.recorder.cycles().size();
    bench.client.start(1, 2, 0);
    bench.wait_for_index(1);
    EmissionModel model(channel_count);
    for (int round = 0; round < 60; ++round) {
        SlewLimit next = slew;
        // One word a time: two of them may come to two periods.
        const bool switches = round % 4 > 1;
        if (switches)
            next.mode = slew.mode == Slew::rate ? Slew::none : Slew::rate;
        else
            next.phase_rate = static_cast<std::uint16_t>(round % 2 == 0 ? random(g, 2000, 3000) : random(g, 200, 600));
        bench.board.run(20 * cycle + random(g, 0, cycle));
        const std::size_t sent = bench.recorder.cycles().size();
        bench.set(switches ? slew_mode : phase_rate,
                  switches ? static_cast<std::uint32_t>(next.mode) : next.phase_rate);
        const std::size_t told = bench.recorder.cycles().size();
        bench.board.run(20 * cycle);
        const std::size_t end = bench.recorder.cycles().size() - 2;
        std::optional<EmissionModel> found;
        for (std::size_t change = sent - 1; change <= told + 2 && !found; ++change) {
            EmissionModel tried = model;
            const auto setting = [&](std::size_t i) { return Setting{.slew = i < change ? slew : next}; };
            if (bench.compare(begin, end, setting, tried).wrong == 0) found = tried;
        }
        CAPTURE(round);
        REQUIRE(found);
        model = *found;
        begin = end;
        slew = next;
    }
}

TEST_CASE("contract 10: no bit of the number of loops is overlooked by a bank that waits for their end",
          "[contract10]") {
    Bench bench;
    Image image = image_of(16, {record(16, 200, 1, 20, 5), record(16, 200, 1, 20, 6)});
    image.sequence = {{1, 30}, {2, 30}};
    bench.load(image);
    bench.open();
    for (unsigned bit = 1; bit < 16; ++bit) {
        CAPTURE(bit);
        // Passes are counted down, so that a few later just this bit is left.
        const auto loops = static_cast<std::uint16_t>((1U << bit) + 5);
        const std::size_t begin = bench.recorder.cycles().size();
        bench.client.start(1, 1, loops);
        bench.client.start(2, 1, 0, link::When::at_end());
        if (bit < 4) {
            bench.wait_for_index(2);
            std::size_t played = 0;
            for (std::size_t i = begin; i < bench.recorder.cycles().size(); ++i)
                played += bench.recorder.cycles()[i].index == 1;
            REQUIRE(played == 30U * loops);
        } else {
            bench.board.run(7ULL * 30 * 200);
            REQUIRE(bench.client.status().waiting);
            REQUIRE(bench.board.outputs().index == 1);
        }
        bench.client.stop();
        bench.wait_for_index(0);
    }
}

TEST_CASE("contract 10: a bank that is asked for in any clock about a change of record follows without a gap",
          "[contract10]") {
    Bench bench;
    constexpr std::uint32_t cycle = 100, dwell = 60;
    Image image = image_of(16, {record(16, cycle, 1, 20, 5), record(16, cycle, 1, 20, 6), record(16, cycle, 1, 20, 7)});
    image.sequence = {{1, dwell}, {2, dwell}, {3, 1}};
    bench.load(image);
    const auto hello = bench.talk(link::encode_request(0, interface::Command::identify, {}));
    std::uint8_t number = hello.at(0).expected;
    const auto send = [&](interface::Command command, const Bytes& payload) {
        const auto replies = bench.talk(link::encode_request(number++, command, payload));
        REQUIRE(replies.size() == 1);
        REQUIRE(replies[0].status == interface::Status::ok);
    };
    using enum interface::Command;
    send(watchdog, words({0}));
    send(enable, {});
    const Bytes follow = words({3, 1, 0});
    std::uint64_t takes = 0;  // clocks that the frame is on the line
    for (std::uint32_t place = 0; place < 50; ++place) {
        CAPTURE(place);
        // Both entries of a bank, once, and the gate of the next one.
        bench.board.send(link::encode_request(number++, start, words({1, 2, 1})));
        bench.wait_for_index(1);
        const std::size_t first = bench.recorder.cycles().size();
        const std::uint64_t change = bench.recorder.cycles().back().clock + std::uint64_t{dwell} * cycle;
        bench.board.send(link::encode_request(number++, gate, words({0xffff, 0xffff, 0xffff})));
        REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 10'000));
        if (takes != 0) bench.board.run(change - 20 + place - takes - bench.board.now());
        const std::uint64_t sent = bench.board.now();
        bench.board.send(link::encode_request(number++, start, follow));
        REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 10'000));
        takes = bench.board.now() - sent;
        bench.wait_for_index(3);
        const auto& cycles = bench.recorder.cycles();
        REQUIRE(cycles.back().clock == change + std::uint64_t{dwell} * cycle);
        for (std::size_t i = first; i + 1 < cycles.size(); ++i) REQUIRE(cycles[i].index != 0);
        static_cast<void>(bench.board.receive());
        send(stop, {});
        bench.wait_for_index(0);
    }
}

TEST_CASE("contract 10: a gate alone waits for nothing, and gives way to another one or to none",
          "[contract10][link]") {
    auto g = generator();
    Bench bench;
    bench.load(image_of(16, {record(16, 500, 1, 20, 5)}));
    bench.open();
    const auto gate = [&](std::uint64_t period) {
        bench.client.request({interface::Command::gate,
                              words({static_cast<std::uint16_t>(period), static_cast<std::uint16_t>(period >> 16),
                                     static_cast<std::uint16_t>(period >> 32)})});
    };
    for (unsigned bit = 16; bit < 48; bit += 4) {
        CAPTURE(bit);
        gate(std::uint64_t{1} << (bit + random(g, 0, 3)));
        REQUIRE_FALSE(bench.client.status().waiting);
        gate(std::uint64_t{1} << bit | random(g, 0, 0xffff));
        gate(0);
        bench.client.start(1, 1, 0);
        bench.wait_for_index(1, 5000);
        const link::Status status = bench.client.status();
        REQUIRE_FALSE(status.waiting);
        REQUIRE(status.late_changes == 0);
        bench.client.stop();
        bench.wait_for_index(0);
    }
}

TEST_CASE("contract 10: a START by the sequence header waits, too", "[contract10]") {
    Bench bench;
    Image image = image_of(16, {record(16, 500, 1, 20, 5), record(16, 500, 1, 20, 6)});
    image.sequence = {{1, 2}, {2, 3}, {1, 1}};
    image.loops = 2;
    bench.load(image);
    // A netlist was reset after it had been loaded: cycles are numbered from there, as the board does.
    std::destroy_at(&bench.recorder);
    std::construct_at(&bench.recorder, bench.board);
    bench.open();
    const bool at_end = GENERATE(false, true);
    const std::uint64_t period = bench.client.status().period.value() + 60;
    bench.client.start(1, 0, 0, at_end ? link::When::at_end() : link::When::at_period(period));
    bench.wait_for_index(1);
    std::size_t begin = 0;
    while (bench.recorder.cycles()[begin].index != 1) ++begin;
    if (!at_end) REQUIRE(begin + 1 == period);  // the first cycle is period 1
    bench.board.run(20ULL * 500);
    const std::vector<std::uint16_t> pass = {1, 1, 2, 2, 2, 1};
    for (std::size_t i = 0; i < 18; ++i) {
        CAPTURE(i);
        REQUIRE(bench.recorder.cycles()[begin + i].index == (i < 2 * pass.size() ? pass[i % pass.size()] : 0));
    }
}

TEST_CASE(
    "second instrument: a period whose words cannot be begun in time is one underrun, whenever the old pulses end",
    "[second][wide][order]") {
    auto g = generator();
    Wide bench;
    bench.open();
    constexpr std::uint32_t cycle = 4 * lead;
    bench.random_record(g, 2, cycle);
    bench.write_sequence({{1, 3}, {2, 6}});
    std::uint16_t underruns = 0;
    // An old pulse may run for so many clocks of the new record's first cycle, until its successor's words are begun.
    constexpr std::uint32_t go = cycle - cycle / 4 - lead;
    for (std::uint32_t pulse = 4; pulse < cycle - 5; pulse += 4) {
        if (pulse + 3 > go && pulse < go + 4) continue;
        CAPTURE(pulse);
        bench.raw_record(g, 1, 800, static_cast<std::uint8_t>(pulse));
        bench.client.start(1, 2, 1);
        bench.wait_for_index(2);
        bench.wait_for_index(0);
        bench.board.run(2000);
        underruns = static_cast<std::uint16_t>(underruns + (pulse > go ? 1 : 0));
        REQUIRE(bench.client.status().underruns == underruns);
    }
}

TEST_CASE("contract 6: a push of one index too much is refused, however many have room", "[contract6][live]") {
    Bench bench;
    bench.load(image_of(16, {record(16, 500, 1, 20, 5)}));
    bench.open();
    const std::uint32_t depth = bench.board.parameters().live_depth;
    for (std::uint32_t room = 0; room <= depth; ++room) {
        CAPTURE(room);
        bench.client.push({1}, 60'000);  // plays for as long as this takes
        bench.wait_for_index(1);
        bench.client.push({1}, 1);  // which is loaded, and has left the FIFO
        const auto push = [&](std::uint32_t count) {
            return bench.client.push(std::vector<std::uint16_t>(count, 1), 1);
        };
        if (room < depth) push(depth - room);
        REQUIRE_REFUSED(push(room + 1));
        if (room > 0) REQUIRE(push(room) == depth);
        bench.client.stop();
        bench.wait_for_index(0);
    }
}

TEST_CASE("safety: a frame of any length that only contains DISABLE or STOP does neither", "[safety]") {
    auto g = generator();
    Bench bench;
    bench.load(image_of(16, {record(16, 500, 1, 20, 5)}));
    bench.open();
    bench.client.select(1, 0);
    bench.wait_for_index(1);
    for (int round = 0; round < 100; ++round) {
        Bytes data;
        const bool stops = random(g, 0, 1) == 0;
        for (std::uint32_t n = random(g, 1, 8); n > 0; --n) {
            data.push_back(static_cast<std::uint8_t>(random(g, 0, 255)));
            data.push_back(static_cast<std::uint8_t>(stops ? interface::Command::stop : interface::Command::disable));
        }
        bench.client.write(interface::primary_base + 400, data);
        REQUIRE(bench.board.outputs().enabled);
        REQUIRE(bench.client.status().mode == link::Mode::single);
    }
    REQUIRE(bench.board.outputs().index == 1);
}

TEST_CASE("safety: the watchdog does not count while outputs are off", "[safety][watchdog]") {
    Bench bench;
    bench.client.identify();
    const std::uint64_t clocks = std::uint64_t{bench.board.parameters().watchdog_ms} * 50'000;
    bench.board.run(2 * clocks);
    REQUIRE(bench.client.status().watchdog_trips == 0);
    bench.client.enable();
    bench.client.disable();
    bench.board.run(2 * clocks);
    REQUIRE(bench.client.status().watchdog_trips == 0);
    REQUIRE_FALSE(bench.board.outputs().fault);
}
