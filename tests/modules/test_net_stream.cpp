// SPDX-License-Identifier: Apache-2.0
// A stream of patterns over Ethernet, whole: what each pin does in each carrier period is measured, and compared with
// the pattern that was sent for that period: the middle of a pulse with its phase, its width with Hoshi et al. 2010,
// eq. 7. What foci make of each channel is the host's model of the engine.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "../soak.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "net_core.hpp"

using namespace haptogram;
using namespace net;

namespace {

constexpr long cycle = 1250;
constexpr unsigned patterns_a_datagram = 7, slot_bits = has_sdram ? 10 : 6;
constexpr long slots = 1 << slot_bits;

struct Drive {
    double phase, amplitude;  ///< 256ths of the cycle, 255ths
};

/// Phases all round the cycle and hardly the same twice, but so near from period to period that pulses do not touch.
Drive drive(long period, unsigned channel) {
    const auto mixed = static_cast<std::uint64_t>(period * 1009 + channel) * 0x9e3779b97f4a7c15ULL;
    return {static_cast<double>(channel * 37 % 236 + (mixed >> 56) % 20),
            static_cast<double>(100 + (mixed >> 40) % 100)};
}
Bytes pattern(long period) {
    Bytes bytes;
    for (unsigned c = 0; c < channels; ++c) {
        const Drive one = drive(period, c);
        bytes.insert(bytes.end(), {static_cast<std::uint8_t>(one.phase), static_cast<std::uint8_t>(one.amplitude)});
    }
    return bytes;
}
/// The same phases, as words of a record of timings: ticks after the cycle's start.
Bytes timings(long period) {
    Bytes bytes;
    for (unsigned c = 0; c < channels; ++c) {
        const auto ticks = static_cast<unsigned>(drive(period, c).phase * 4);
        bytes.insert(bytes.end(), {static_cast<std::uint8_t>(ticks), static_cast<std::uint8_t>(ticks >> 8)});
    }
    return bytes;
}
double width(double amplitude) { return cycle * std::asin(amplitude / 255) / std::numbers::pi; }

/// Pulses and carrier periods at the pins, by clocks since reset.
class Pins {
public:
    struct Pulse {
        unsigned channel;
        long rise, fall;
    };
    std::vector<long> starts{0};       ///< of each period by its number; 0 is what was before the first
    std::vector<unsigned> indices{0};  ///< of the record that plays in it
    std::vector<Pulse> pulses;

    explicit Pins(Network& network) : network_(network) {
        network.before_clock = [this] { look(); };
    }
    [[nodiscard]] long clock() const { return clock_; }

private:
    void look() {
        if (network_.bench->o_cycle_start) {
            starts.push_back(clock_);
            indices.push_back(network_.bench->o_index);
        }
        for (unsigned word = 0; word < before_.size(); ++word) {
            const std::uint32_t now = network_.bench->o_pins[word];
            for (std::uint32_t changed = now ^ before_[word]; changed != 0; changed &= changed - 1) {
                const unsigned bit = static_cast<unsigned>(std::countr_zero(changed)), channel = 32 * word + bit;
                if ((now >> bit & 1U) != 0)
                    rises_[channel] = clock_;
                else
                    pulses.push_back({channel, rises_[channel], clock_});
            }
            before_[word] = now;
        }
        ++clock_;
    }
    Network& network_;
    long clock_ = 0;
    std::array<std::uint32_t, (channels + 31) / 32> before_{};
    std::array<long, channels> rises_{};
};

/// A board that plays streams, and the host that sends them.
class Stream {
public:
    Network network;
    Pins pins{network};
    std::set<long> sent;  ///< the periods whose pattern arrived in time
    std::uint8_t session = 0;

    /// What each channel does in a period.
    std::function<Drive(long, unsigned)> drive_of = drive;
    std::function<Bytes(long)> pattern_of = pattern;

    explicit Stream(unsigned hold, unsigned fade = 65535, std::uint16_t first = first_index, std::uint16_t kind = 1)
        : first_(first) {
        if (has_sdram) network.run(300'000);  // until it has started
        session = static_cast<std::uint8_t>(network.next_number());
        send(network.frame(Command::identify));
        answered(1);
        send(network.frame(Command::watchdog, {0, 0}));
        std::vector<std::uint16_t> header(interface::record_header_words, 0);
        interface::record_field::cycle_length.set(header, cycle);
        interface::record_field::prescaler.set(header, 1);
        interface::record_field::kind.set(header, kind);
        if (kind == 0) interface::record_field::pulse_length.set(header, timed_width);
        // A focus record has none.
        for (unsigned slot = 0; first == first_index && slot < slots; ++slot) {
            write((first_index - 1 + slot) * record_words * 2, header);
            network.run(2000);
        }
        settings({first, slot_bits, static_cast<std::uint16_t>(hold), static_cast<std::uint16_t>(fade)});
        send(network.frame(Command::enable));
        answered(4 + (first == first_index ? slots : 0));
    }
    void write(unsigned address, std::span<const std::uint16_t> all) {
        send(network.frame(Command::write, little(address) + little(address >> 16) + words(all)));
    }
    void settings(std::initializer_list<std::uint16_t> all) { write(interface::stream_base, all); }
    void send(const Bytes& payload) { network.send(host, payload); }
    void answered(std::size_t count) {
        REQUIRE(network.answered(count));
        for (const link::Reply& reply : network.replies) REQUIRE(reply.status == interface::Status::ok);
    }
    [[nodiscard]] long now() const { return static_cast<long>(pins.starts.size()) - 1; }
    [[nodiscard]] unsigned slot_of(long period) const { return first_ + static_cast<unsigned>(period & (slots - 1)); }

    /// A frame of patterns for the periods from `first` on. @param content  the period that they belong to otherwise
    [[nodiscard]] Bytes frame(long first, unsigned count, long content, std::size_t cut = 0) const {
        Bytes payload = little(first & 0xffff) + little(first >> 16 & 0xffff) + Bytes{0, 0};
        for (unsigned k = 0; k < count; ++k) payload = payload + pattern_of(content + k);
        payload.resize(payload.size() - cut);
        return link::encode_request(session, Command::stream, payload);
    }
    /// Patterns for the periods from `first` on, in frames of two.
    [[nodiscard]] Bytes datagram(long first, unsigned count = patterns_a_datagram) const {
        Bytes all;
        for (unsigned k = 0; k < count; k += 2) all = all + frame(first + k, std::min(2U, count - k), first + k);
        REQUIRE(all.size() <= interface::network::datagram_bytes);
        return all;
    }
    void note(long first, unsigned count = patterns_a_datagram) {
        for (unsigned k = 0; k < count; ++k) sent.insert(first + k);
    }
    void run_to(long period) {
        while (now() < period) network.run(5'000);
    }
    std::uint16_t status(interface::StatusWord word) {
        network.rests = false;
        const std::size_t before = network.replies.size();
        send(network.frame(Command::status));
        REQUIRE(network.answered(before + 1));
        const Bytes& data = network.replies.back().data;
        REQUIRE(data.size() == 2 * interface::status_words);
        const auto place = 2 * static_cast<std::size_t>(word);
        return static_cast<std::uint16_t>(data[place] | data[place + 1] << 8);
    }

    /// How many pulses of the periods are not those of the pattern that `source` names for each (0: silence), or are
    /// missing.
    template <class Source>
    long wrong(long from, long to, Source source) {
        std::vector<unsigned> found(static_cast<std::size_t>(to - from), 0);
        long unexplained = 0;
        for (const Pins::Pulse& pulse : pins.pulses) {
            const double middle = 0.5 * static_cast<double>(pulse.rise + pulse.fall);
            const auto after = std::upper_bound(pins.starts.begin(), pins.starts.end(), static_cast<long>(middle));
            const long around = after - pins.starts.begin() - 1;
            bool explained = around < from || around >= to;
            for (long p = std::max(from, around - 1); !explained && p <= std::min(to - 1, around + 1); ++p) {
                const long named = source(p);
                if (named == 0) continue;
                const Drive one = drive_of(named, pulse.channel);
                const double due =
                    static_cast<double>(pins.starts[static_cast<std::size_t>(p)]) + one.phase * cycle / 256;
                explained = std::abs(middle - due) <= 1.01 &&
                            std::abs(static_cast<double>(pulse.fall - pulse.rise) - width(one.amplitude)) <= 2;
                if (explained) ++found[static_cast<std::size_t>(p - from)];
            }
            unexplained += !explained;
        }
        for (long p = from; p < to; ++p)
            unexplained += source(p) == 0 ? 0
                                          : std::abs(static_cast<long>(found[static_cast<std::size_t>(p - from)]) -
                                                     static_cast<long>(channels));
        return unexplained;
    }
    /// What plays in a period when everything that was noted has arrived.
    [[nodiscard]] long plays(long period, long hold) const {
        const auto after = sent.upper_bound(period);
        if (after == sent.begin()) return 0;
        const long last = *std::prev(after);
        return period - last <= hold ? last : 0;
    }

    static constexpr std::uint16_t first_index = 3, timed_width = 200;

private:
    std::uint16_t first_;
};

/// The same with eight foci for each period, out of which the board computes what each channel does.
class FociStream : public Stream {
public:
    explicit FociStream(unsigned hold) : Stream(hold, 65535, records + 1) {
        const Vec3 centre = {0, 0, 150 * millimetre};
        for (unsigned c = 0; c < channels; ++c)
            engine_.geometry.push_back(
                pack_geometry({(c % 10 - 4.5) * 10 * millimetre, (c / 10 - 4.5) * 10 * millimetre, 0}));
        // In the middle of the period, so that a pulse does not come twice in one and not in the next.
        const std::vector<ChannelDrive> middle = engine_drives(engine_, std::vector{pack_focus({centre, 1})});
        for (unsigned c = 0; c < channels; ++c)
            engine_.geometry[c][3] = static_cast<std::uint16_t>((128U - (middle[c].phase >> 8)) << 8);
        pattern_of = [this](long period) {
            Bytes all;
            for (const FocusWords& focus : foci(period)) all = all + words(focus);
            return all;
        };
        drive_of = [this](long period, unsigned channel) {
            if (!drives_.contains(period)) drives_[period] = engine_drives(engine_, foci(period));
            const ChannelDrive& one = drives_[period][channel];
            return Drive{one.phase / 256.0, one.amplitude * 255 / 65535.0};
        };
        write(interface::parameters_base,
              std::array<std::uint16_t, 7>{0, slots, most_record_foci - 1, cycle,
                                           static_cast<std::uint16_t>(engine_.wave_number),
                                           static_cast<std::uint16_t>(engine_.wave_number >> 16), engine_.gain});
        constexpr unsigned at_once = 20;  // channels
        for (unsigned c = 0; c < channels; c += at_once) {
            std::vector<std::uint16_t> all;
            for (unsigned k = c; k < c + at_once; ++k)
                all.insert(all.end(), engine_.geometry[k].begin(), engine_.geometry[k].end());
            write(interface::geometry_base + 8 * c, all);
        }
        answered(network.replies.size() + 1 + channels / at_once);
    }

private:
    /// Near each other and near those of the period before, so that pulses do not touch, but hardly the same twice.
    static std::vector<FocusWords> foci(long period) {
        const auto mixed = static_cast<std::uint64_t>(period) * 0x9e3779b97f4a7c15ULL;
        const auto part = [mixed](unsigned low) { return static_cast<double>(mixed >> low & 0xff) / 255; };
        std::vector<FocusWords> all;
        for (unsigned k = 0; k < most_record_foci; ++k)
            all.push_back(pack_focus({{(0.6 * part(56) + 0.1 * k) * millimetre, (0.6 * part(48) - 0.1 * k) * millimetre,
                                       (150 + 0.4 * part(40)) * millimetre},
                                      0.45 + 0.3 * part(32)}));
        return all;
    }
    FocusEngine engine_{{}, wave_number_word(8.5 * millimetre), gain_word(most_record_foci)};
    std::map<long, std::vector<ChannelDrive>> drives_;
};

}  // namespace

TEST_CASE("stream: each pattern plays in its own carrier period, and where one is missing the last one stays") {
    const bool lossy = GENERATE(false, true);
    const auto periods = static_cast<long>(haptogram::test::soaked(100'000, 600));
    const long lead = has_sdram ? 1'000 : 30;
    constexpr unsigned hold = 100;
    Stream stream(hold);
    std::mt19937_64& random = stream.network.bench.random;
    const long begin = stream.now() + lead + 10;
    stream.network.rests = true;
    unsigned left_out = 0;
    for (long p = begin; p < begin + periods; p += patterns_a_datagram) {
        stream.run_to(p - lead);
        if (lossy && p > begin && random() % 100 == 0) {
            left_out += patterns_a_datagram;
            continue;
        }
        stream.send(stream.datagram(p));
        stream.note(p);
    }
    const long end = begin + periods - periods % patterns_a_datagram;
    stream.run_to(end + 4);
    CHECK((left_out > 0) == lossy);
    CHECK(stream.status(interface::StatusWord::stream_late) == 0);
    CHECK(stream.status(interface::StatusWord::stream_early) == 0);
    CHECK(stream.status(interface::StatusWord::stream_repeated) == 0);
    CHECK(stream.status(interface::StatusWord::underruns) == 0);
    CHECK(stream.pins.pulses.size() >= static_cast<std::size_t>(periods - 10) * channels);
    CHECK(stream.wrong(begin + 1, end, [&](long p) { return stream.plays(p, hold); }) == 0);
}

TEST_CASE("stream: eight foci for each carrier period play in that period") {
    constexpr long periods = 400, lead = 30;
    FociStream stream(10);
    const long begin = stream.now() + lead + 10, end = begin + periods - periods % patterns_a_datagram;
    stream.network.rests = true;
    for (long p = begin; p < end; p += patterns_a_datagram) {
        stream.run_to(p - lead);
        stream.send(stream.datagram(p));
        stream.note(p);
    }
    stream.run_to(end + 4);
    CHECK(stream.status(interface::StatusWord::stream_late) == 0);
    CHECK(stream.status(interface::StatusWord::underruns) == 0);
    CHECK(stream.status(interface::StatusWord::refused_records) == 0);
    CHECK(stream.wrong(begin + 1, end, [&](long p) { return stream.plays(p, 10); }) == 0);
}

TEST_CASE("stream: foci are at the pins two and a half carrier periods after the end of their datagram") {
    constexpr unsigned datagrams = 100;
    FociStream stream(1000);
    std::vector<double> taken;                  // carrier periods
    for (unsigned k = 0; k < datagrams; ++k) {  // in every part of a period alike
        for (const long before = stream.now(); stream.now() == before;) stream.network.run(20);
        stream.network.run(25'000.0 * k / datagrams);
        const long now = stream.now();
        stream.send(stream.frame(now + 2, 3, now + 2));
        while (stream.network.frames_left() != 0) stream.network.run(8);
        const long arrived = stream.pins.clock();
        stream.run_to(now + 6);
        long first = now + 2;
        while (first < now + 5 && stream.pins.indices[static_cast<std::size_t>(first)] != stream.slot_of(first))
            ++first;
        REQUIRE(first < now + 5);
        taken.push_back(static_cast<double>(stream.pins.starts[static_cast<std::size_t>(first)] - arrived) / cycle);
    }
    std::sort(taken.begin(), taken.end());
    const double median = taken[taken.size() / 2], worst = taken.back();
    if (std::getenv("HAPTOGRAM_FIGURES") != nullptr)
        std::cout << "foci, datagram to pins: " << taken.front() << " to " << worst << " carrier periods, median "
                  << median << "\n";
    CHECK(median <= 2.1);
    CHECK(worst <= 2.6);
}

TEST_CASE(
    "stream: in any order, doubled with other words and cut, no period plays anything but its own pattern whole") {
    constexpr long block = 16, blocks = 25, lead = 36, others = 1'000'000;
    Stream stream(block);
    std::mt19937_64& random = stream.network.bench.random;
    const long begin = stream.now() + lead + 20, end = begin + block * blocks;
    stream.network.rests = true;
    std::uint64_t doubled = 0, cut = 0;
    for (long first = begin; first < end; first += block) {
        stream.run_to(first - lead);
        std::vector<long> periods(block);
        std::iota(periods.begin(), periods.end(), first);
        std::shuffle(periods.begin(), periods.end(), random);
        for (const long p : periods) {
            if (p != first && random() % 8 == 0) continue;  // lost
            // The second one of a frame that is cut is not there.
            const bool cuts = random() % 4 == 0 && p + 1 < first + block && !stream.sent.contains(p + 1);
            if (stream.sent.contains(p)) continue;
            stream.send(stream.frame(p, cuts ? 2 : 1, p, cuts ? 2 + random() % 99 * 2 : 0));
            cut += cuts;
            stream.note(p, 1);
            if (random() % 2 != 0) continue;
            ++doubled;
            stream.send(stream.frame(p, 1, p + others));
        }
    }
    stream.run_to(end + 4);
    CHECK(stream.status(interface::StatusWord::stream_repeated) == doubled);
    CHECK(stream.status(interface::StatusWord::frames_refused) == cut);
    CHECK(stream.status(interface::StatusWord::stream_late) == 0);
    CHECK(stream.status(interface::StatusWord::frames_damaged) == 0);
    CHECK(stream.wrong(begin + 1, end, [&](long p) { return stream.plays(p, block); }) == 0);
}

TEST_CASE("stream: what is late, early or of another session plays nothing, and is counted") {
    Stream stream(20);
    const long begin = stream.now() + 30;
    stream.send(stream.datagram(begin));
    stream.note(begin);
    stream.send(stream.datagram(begin + slots + 8));  // for slots whose own periods get nothing
    stream.run_to(begin + 2);
    stream.send(stream.datagram(begin - 6, 6));
    ++stream.session;
    stream.send(stream.datagram(begin + 7, 2));
    stream.run_to(begin + 20);
    CHECK(stream.status(interface::StatusWord::stream_early) == 7);
    CHECK(stream.status(interface::StatusWord::stream_late) == 6);
    CHECK(stream.status(interface::StatusWord::stream_repeated) == 0);
    CHECK(stream.status(interface::StatusWord::frames_refused) == 1);
    CHECK(stream.wrong(begin + 1, begin + 18, [&](long p) { return stream.plays(p, 20); }) == 0);
}

TEST_CASE("stream: the settings are read as they were written") {
    Stream stream(20);
    for (unsigned times = 0; times < 20; ++times) {
        std::array<std::uint16_t, interface::stream_words> all{};
        for (std::uint16_t& word : all) word = static_cast<std::uint16_t>(stream.network.bench.random());
        all[1] &= 15;  // slot_bits
        stream.write(interface::stream_base, all);
        stream.send(stream.network.frame(
            Command::read,
            little(interface::stream_base) + little(interface::stream_base >> 16) + little(2 * all.size())));
        stream.answered(stream.network.replies.size() + 2);
        CHECK(stream.network.replies.back().data == words(all));
    }
}

TEST_CASE("stream: when no pattern comes the last one is held, and then its amplitudes fall to nothing") {
    constexpr long hold = 9, fade = 2000;
    Stream stream(hold, fade);
    const long begin = stream.now() + 20, last = begin + 6;
    stream.send(stream.datagram(begin));
    stream.note(begin);
    const std::uint16_t before = stream.status(interface::StatusWord::flags);
    stream.run_to(begin + 3);
    const std::uint16_t during = stream.status(interface::StatusWord::flags);
    stream.run_to(last + hold + 45);
    const std::uint16_t after = stream.status(interface::StatusWord::flags);
    const auto streaming = [](std::uint16_t flags) {
        return interface::status_field::streaming.get(std::array{flags});
    };
    CHECK(streaming(before) == 0);
    CHECK(streaming(during) == 1);
    CHECK(streaming(after) == 0);
    CHECK(stream.status(interface::StatusWord::stream_lost) == hold + 1);
    CHECK(stream.wrong(begin + 1, last + hold, [&](long p) { return stream.plays(p, hold); }) == 0);
    long fading = 0, wrong = 0;
    for (const Pins::Pulse& pulse : stream.pins.pulses) {
        const long at = (pulse.rise + pulse.fall) / 2;
        const auto next = std::upper_bound(stream.pins.starts.begin(), stream.pins.starts.end(), at);
        const Drive one = drive(last, pulse.channel);
        // Its middle does not move, so it says which period it belongs to even at a period's edge.
        const long period = std::lround(static_cast<double>(next - stream.pins.starts.begin() - 1) +
                                        static_cast<double>(at - *std::prev(next)) / cycle - one.phase / 256);
        const long steps = period - last - hold;
        if (steps <= 0) continue;
        const double left = one.amplitude - static_cast<double>(steps * fade) / 257;
        ++fading;
        wrong += left <= 0 || std::abs(static_cast<double>(pulse.fall - pulse.rise) - width(left)) > 4;
    }
    CHECK(fading > 10 * static_cast<long>(channels));
    CHECK(wrong == 0);
}

TEST_CASE("stream: of a stream that DISABLE ended nothing plays, however soon ENABLE follows") {
    const bool timed = GENERATE(false, true);
    const std::size_t tries = haptogram::test::soaked(1250, 16);
    Stream stream(1000, 65535, Stream::first_index, timed ? 0 : 1);
    if (timed) stream.pattern_of = timings;
    Network& network = stream.network;
    long old = 0, late = 0;
    for (std::size_t k = 0; k < tries; ++k) {  // in every part of a period
        const long begin = stream.now() + 6;
        stream.send(stream.datagram(begin));
        stream.run_to(begin + 3);
        for (const long before = stream.now(); stream.now() == before;) network.run(20);
        network.run(25'000.0 * static_cast<double>(k) / static_cast<double>(tries));
        stream.send(network.frame(Command::disable));
        for (const std::size_t answers = network.replies.size(); network.replies.size() == answers;) network.run(8);
        stream.send(network.frame(Command::enable));
        const long off = stream.pins.clock();
        const std::size_t before = stream.pins.pulses.size();
        while (!network.bench->o_enabled) network.run(8);
        network.run(200'000);
        late += network.bench->o_enabled == 0;
        for (std::size_t i = before; i < stream.pins.pulses.size(); ++i) old += stream.pins.pulses[i].rise > off;
    }
    CHECK(old == 0);
    CHECK(late == 0);
}

TEST_CASE("stream: SELECT ends a stream, or comes about its end, and nothing of that plays once more") {
    const bool timed = GENERATE(false, true), ends = GENERATE(false, true);
    const std::size_t tries = haptogram::test::soaked(1250, 16);
    constexpr std::uint16_t selected = 1, hold = 4, selected_width = 60;  // of the stream's pulses none is so short
    Stream stream(hold, 65535, Stream::first_index, timed ? 0 : 1);
    if (timed) stream.pattern_of = timings;
    Network& network = stream.network;
    std::vector<std::uint16_t> record(record_words, 300);
    std::fill_n(record.begin(), interface::record_header_words, 0);
    interface::record_field::cycle_length.set(record, cycle);
    interface::record_field::prescaler.set(record, 1);
    interface::record_field::pulse_length.set(record, selected_width);
    stream.write(0, record);
    REQUIRE(network.answered(network.replies.size() + 1));
    long again = 0, late = 0, streamed = 0;
    for (std::size_t k = 0; k < tries; ++k) {  // in every part of a period
        const long begin = stream.now() + 6, last = begin + patterns_a_datagram - 1;
        stream.send(stream.datagram(begin));
        stream.run_to(ends ? last + hold - 1 + static_cast<long>(k % 4) : begin + 3);
        for (const long before = stream.now(); stream.now() == before;) network.run(20);
        network.run(25'000.0 * static_cast<double>(k) / static_cast<double>(tries));
        const long sent = stream.now();
        stream.send(network.frame(Command::select, {selected, 0, 0, 0}));
        stream.run_to(sent + 8);
        const auto of_stream = [&](long p) {
            return stream.pins.indices[static_cast<std::size_t>(p)] >= Stream::first_index;
        };
        long over = begin;  // the first period that plays something else
        while (over < stream.now() && of_stream(over)) {
            ++streamed;
            const unsigned index = stream.pins.indices[static_cast<std::size_t>(over)];
            again += index != stream.slot_of(std::min(over, last)) && over > sent + 2;
            ++over;
        }
        late += over > std::min(sent + 3, last + hold + 2);
        for (long p = over; p < stream.now(); ++p) again += of_stream(p);
        const long clock = stream.pins.starts[static_cast<std::size_t>(over)];
        for (const Pins::Pulse& pulse : stream.pins.pulses)
            again += pulse.rise > clock + cycle / 2 && pulse.fall - pulse.rise > selected_width + 2;
        stream.send(network.frame(Command::select, {0, 0, 0, 0}));
        network.run(100'000);
        stream.pins.pulses.clear();
    }
    CHECK(again == 0);
    CHECK(late == 0);
    CHECK(streamed > static_cast<long>(3 * tries));
}

TEST_CASE("stream: DISABLE, STOP, the stop input, a new session, a lost link and other commands forget what waits") {
    Stream stream(5);
    const int what = GENERATE(range(0, 8));
    const long begin = stream.now() + 30;
    stream.send(stream.datagram(begin));
    stream.run_to(begin - 20);
    switch (what) {
        case 0: stream.send(stream.network.frame(Command::disable)); break;
        case 1: stream.send(stream.network.frame(Command::stop)); break;
        case 2: stream.send(stream.network.frame(Command::identify)); break;
        case 3: stream.network.send(stranger, {'H', 'G', 5, 0}, open_port); break;
        case 4: stream.settings({Stream::first_index, slot_bits, 5, 65535}); break;
        case 5: stream.write(interface::parameters_base, std::array<std::uint16_t, 1>{8}); break;  // foci_base
        case 6: stream.send(stream.network.frame(Command::select, {0, 0, 0, 0})); break;
        default:
            stream.network.bench->i_stop = 1;
            stream.network.run(200);
            stream.network.bench->i_stop = 0;
    }
    stream.network.run(100'000);
    if (what == 3) stream.send(stream.network.frame(Command::identify));  // which ended the session
    stream.send(stream.network.frame(Command::enable));
    // What comes afterwards plays, but in another session.
    if (what != 2 && what != 3) {
        stream.send(stream.datagram(begin + 10));
        stream.note(begin + 10);
    }
    stream.run_to(begin + 30);
    CHECK(stream.network.bench->o_enabled);
    CHECK(stream.wrong(begin - 10, begin + 20, [&](long p) { return stream.plays(p, 5); }) == 0);
}
