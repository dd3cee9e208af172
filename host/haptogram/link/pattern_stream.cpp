// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/pattern_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/focus_ring.hpp"

namespace haptogram::link {
namespace {

constexpr std::uint32_t most_slots = 1024;  // that a core can have
constexpr std::uint32_t least_ahead = 4;    // periods: what plays is decided 1.4 before, and a datagram takes a half
constexpr std::uint32_t least_lead = 2 * least_ahead;  // with no more than least_ahead nothing would be sent
constexpr std::uint32_t least_slots = 16;              // for a lead that can still change
constexpr double look_s = 5e-3;                        // between two looks at the device's clock and counters
constexpr double step_s = 1e-3;                        // between two sendings
constexpr double lead_growth = 1.5;  // when patterns came too late; a third of it is given back when too early
constexpr unsigned lost_probes = 3;  // on a line that loses

Error no_stream(const std::string& why) { return {ErrorCode::device, "board", why}; }

void write_headers(Commands& device, std::uint32_t first, std::uint32_t slots) {
    const Identity& identity = device.identity();
    std::array<std::uint16_t, interface::record_header_words> header{};
    interface::record_field::cycle_length.set(header, std::lround(identity.clock_hz * pattern_period_s));
    interface::record_field::prescaler.set(header, 1);
    interface::record_field::kind.set(header, static_cast<std::uint32_t>(interface::Kind::amplitudes));
    std::vector<Request> requests;
    for (std::uint32_t slot = 0; slot < slots; ++slot)
        requests.push_back(
            write_request(interface::primary_base +
                              static_cast<std::uint32_t>(2 * record_words(identity.channels)) * (first - 1 + slot),
                          header));
    device.pipeline(std::move(requests));
}

/// How far a counter of 16 bits has gone on.
std::uint16_t further(std::uint16_t now, std::uint16_t before) { return static_cast<std::uint16_t>(now - before); }

/// The host's place ahead of the device, by the device's own clock.
class StreamPace {
public:
    StreamPace(const Status& first, double now_s, std::uint32_t slots)
        : first_period_(*first.period), first_s_(now_s), counts_(*first.stream), slots_(slots) {
        played.lead = slots / 2;
        learn(first, now_s);
    }

    void learn(const Status& status, double now_s) {
        period_ = *status.period;
        seen_s_ = now_s;
        if (now_s > first_s_) rate_hz_ = static_cast<double>(period_ - first_period_) / (now_s - first_s_);
        const StreamCounts& now = *status.stream;
        if (now.late != counts_.late)
            played.lead = std::min(slots_ - least_ahead, static_cast<std::uint32_t>(played.lead * lead_growth) + 1);
        else if (now.early != counts_.early)
            played.lead = std::max(least_lead, static_cast<std::uint32_t>(played.lead / lead_growth));
        played.late += further(now.late, counts_.late);
        played.lost += further(now.lost, counts_.lost);
        played.early += further(now.early, counts_.early);
        played.repeated += further(now.repeated, counts_.repeated);
        counts_ = now;
    }
    [[nodiscard]] bool is_old(double now_s) const { return now_s - seen_s_ > look_s; }
    /// At the pins now: a little less than there is, as the answer was on its way.
    [[nodiscard]] std::uint64_t period(double now_s) const {
        return period_ + static_cast<std::uint64_t>(std::min(now_s - seen_s_, look_s) * rate_hz_);
    }

    PlayedPatterns played;

private:
    std::uint64_t first_period_, period_ = 0;
    double first_s_, seen_s_ = 0.0, rate_hz_ = 1.0 / pattern_period_s;
    StreamCounts counts_;
    std::uint32_t slots_;
};

}  // namespace

PatternStream::PatternStream(Commands& device, const PatternSettings& settings) : device_(device) {
    const Identity& identity = device.identity();
    if (!interface::has(identity.features, interface::Feature::stream))
        throw no_stream("it takes no streams of patterns; that takes a board with the parameter STREAM");
    if (device.status().stopped) throw no_stream("its stop input is active; release it first");
    if (settings.slots != 0 && (settings.slots < least_slots || !std::has_single_bit(settings.slots)))
        throw bad_argument("slots",
                           fmt::format("found {}, expected a power of two from {} on", settings.slots, least_slots));
    words_ = identity.channels;
    std::uint32_t room = identity.records;
    if (settings.foci) {
        const FocusRing ring = make_ring(device);
        words_ = 4 * ring.each;
        room = ring.count;
    }
    constexpr std::size_t before_patterns = 8;  // number, command, period
    most_ = (identity.frame_bytes - before_patterns) / (2 * words_);
    std::uint32_t slots = settings.slots != 0 ? settings.slots : std::min(most_slots, std::bit_floor(room));
    while (slots > room || !takes(slots, settings)) {
        if (settings.slots != 0 || slots <= least_slots)
            throw no_stream(
                fmt::format("it refuses a stream through {} slots; the STREAM of its configuration says "
                            "how many it has, and the slots are among its {} records",
                            slots, room));
        slots /= 2;
    }
    slots_ = slots;
}

/// Lays out so many slots. A pattern that is too late for its period is counted by a device that has them.
bool PatternStream::takes(std::uint32_t slots, const PatternSettings& settings) {
    const std::uint32_t records = device_.identity().records;
    const std::uint32_t first = settings.foci ? make_ring(device_).first : records + 1 - slots;
    std::array<std::uint16_t, interface::stream_words> block{};
    interface::stream_field::first.set(block, first);
    interface::stream_field::slot_bits.set(block, std::countr_zero(slots));
    interface::stream_field::hold.set(block, settings.hold);
    interface::stream_field::fade.set(block, settings.fade);
    device_.request(write_request(interface::stream_base, block));
    const std::uint16_t before = device_.status().stream->late;
    const std::vector<std::uint16_t> silence(words_, 0);
    for (unsigned tries = 0; tries < lost_probes; ++tries) {
        send(0, silence);
        if (device_.status().stream->late == before) continue;
        if (!settings.foci) write_headers(device_, first, slots);
        return true;
    }
    return false;
}

void PatternStream::send(std::uint64_t period, std::span<const std::uint16_t> patterns) {
    if (patterns.size() % words_ != 0)
        throw bad_argument("patterns", fmt::format("{} words, expected a multiple of {}, those of a pattern",
                                                   patterns.size(), words_));
    for (std::size_t count = 0; !patterns.empty(); patterns = patterns.subspan(count * words_), period += count) {
        count = std::min(most_, patterns.size() / words_);
        device_.tell(stream_request(period, patterns.first(count * words_)));
    }
    device_.flush();
}

PlayedPatterns play_patterns(Commands& device, const PatternSettings& settings, const PatternSource& source,
                             const std::function<bool(const PatternsPlaying&)>& watch) {
    PatternStream stream(device, settings);
    Clock& clock = device.clock();
    const auto rest = [&clock] { clock.rest(Clock::time(step_s)); };
    std::optional<StreamPace> kept;  // also when a signal ends it in the middle of a question
    const bool interrupted = while_on(device, settings.watchdog_ms, [&] {
        const Status before = device.status();
        StreamPace& pace = kept.emplace(before, clock.now_s(), stream.slots());
        std::uint64_t following = *before.period + pace.played.lead, at_pins = 0;
        const auto look = [&] {
            const Status status = device.status();
            require_on(status, &before);
            pace.learn(status, clock.now_s());
            at_pins = *status.period;
            pace.played.interrupted = watch && !watch({status, pace.played});
            return !pace.played.interrupted;
        };
        std::vector<std::uint16_t> patterns, last;
        std::uint64_t end = 0;  // of the source, once it has ended; what is behind it plays the last pattern on
        for (bool more = true; (more || at_pins < end) && (!pace.is_old(clock.now_s()) || look()); rest()) {
            const std::uint64_t period = pace.period(clock.now_s());
            following = std::max(following, period + least_ahead);
            if (period + pace.played.lead <= following) continue;
            std::size_t count = period + pace.played.lead - following;
            patterns.resize(count * stream.words());
            if (more) {
                const std::optional<std::size_t> filled = source(following, patterns);
                more = filled.has_value();
                if (!more) end = following;
                if (filled.value_or(0) > count)
                    throw bad_argument("source",
                                       fmt::format("it filled in {} patterns, expected {} at most", *filled, count));
                count = filled.value_or(count);
            }
            if (more && count > 0) {
                const auto first = patterns.begin() + static_cast<std::ptrdiff_t>((count - 1) * stream.words());
                last.assign(first, first + static_cast<std::ptrdiff_t>(stream.words()));
                pace.played.sent += count;
            }
            if (!more && last.empty()) break;
            for (std::size_t i = 0; !more && i < patterns.size(); ++i) patterns[i] = last[i % last.size()];
            stream.send(following, std::span(patterns).first(count * stream.words()));
            following += count;
        }
    });
    PlayedPatterns played = kept ? kept->played : PlayedPatterns{};
    played.interrupted |= interrupted;
    return played;
}

}  // namespace haptogram::link
