// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::live {
namespace {

constexpr double nap_s = 0.5e-3;

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Latency spread_of(std::vector<double> latencies) {
    if (latencies.empty()) return {};
    std::sort(latencies.begin(), latencies.end());
    return {latencies.size(), latencies.front(), latencies[latencies.size() / 2], latencies.back(), 0.0};
}

}  // namespace

void Loop::miss() {
    ++report_.missed;
    if (++misses_ == options_.misses_to_fade && player_.playing()) {
        ++report_.fades;
        player_.fade();
    }
}

void Loop::serve_until(double time_s) {
    // The board's time goes on while it is served, so late shots are seen here.
    for (double now = clock_.now_s(); now < time_s; now = clock_.now_s()) {
        while (!holds_ && last_time_s_ &&
               now - begin_s_ > *last_time_s_ + (static_cast<double>(absent_) + 1.5) / rate_hz_) {
            ++absent_;
            miss();
        }
        if (!player_.service()) clock_.rest_until_s(std::min(time_s, now + nap_s));
    }
}

void Loop::play(const std::optional<Path>& path, const ShotReport& shot) {
    if (path) {
        ++report_.given;
        player_.replace(*path, shot.number, shot.time_s + begin_s_);
        return;
    }
    // A finger that has left is nothing to feel any more; one that cannot be rendered fades.
    if (shot.fingers > 0 || !shot.troubles.empty()) {
        if (player_.playing() && !player_.fading()) {
            ++report_.fades;
            player_.fade();
        }
    } else if (!player_.fading()) {
        player_.silence();
    }
}

/// Counts what came of the shot before, and what lies between them.
ShotReport Loop::begin(const Frame& shot) {
    // The path of the frame before should be on the board by now. A late frame was counted when it was late.
    if (absent_ == 0 && player_.sending() && !player_.fading()) {
        ++report_.unsent;
        miss();
    } else if (absent_ == 0 && !blind_) {
        misses_ = 0;
    }
    absent_ = 0;
    ShotReport now;
    now.number = shot.number;
    now.time_s = shot.time_s;
    if (last_time_s_ && shot.number > last_number_ + 1) {
        report_.lost += shot.number - last_number_ - 1;
        now.troubles.push_back(
            fmt::format("{} shots before number {} were lost", shot.number - last_number_ - 1, shot.number));
    }
    return now;
}

bool Loop::take(const Frame& frame, const FrameSource& source, Feeler& feeler, const Told& told) {
    if (last_time_s_ && (frame.time_s <= *last_time_s_ || frame.number <= last_number_)) {
        ++report_.out_of_order;
        return true;
    }
    if (last_time_s_ && frame.time_s < *last_time_s_ + options_.interval_s - 1e-6) {
        ++report_.skipped;
        report_.lost += frame.number - last_number_ - 1;
        last_number_ = frame.number;
        return true;
    }
    rate_hz_ = source.rate_hz() / std::max(1.0, std::ceil(options_.interval_s * source.rate_hz() - 1e-6));
    // A live frame is due as it comes. When the others are due follows from it anew: a camera's clock is not the
    // machine's.
    if (!last_time_s_ || source.live()) begin_s_ = frame.came_s.value_or(clock_.now_s()) - frame.time_s;
    serve_until(begin_s_ + frame.time_s);
    ShotReport now = begin(frame);
    const double began_s = processor_s();
    const std::optional<Path> path = feeler.feel(frame, now);
    // A frame without any picture is as good as lost: what plays goes on, and fades when the next one is, too.
    blind_ = now.blind;
    if (blind_) {
        ++report_.blind;
        miss();
    } else {
        play(path, now);
    }
    if (now.compute_s == 0.0) now.compute_s = processor_s() - began_s;
    report_.compute_s.push_back(now.compute_s);
    if (!player_.sent().empty()) now.latency_s = player_.sent().back().expected_s - player_.sent().back().shot_s;
    ++report_.shots;
    last_time_s_ = frame.time_s;
    last_number_ = frame.number;
    return !told || told(now, frame, path);
}

/// Keeps the ring turning until a shot is there, and of a live source, until the line has taken what the last one made:
/// the newest is taken then. @return whether one is, or the source's end
bool Loop::await(FrameSource& source, const std::function<bool()>& waits) {
    for (;;) {
        const bool ready = source.ready();
        holds_ = ready && source.live() && player_.sending() && !player_.fading();
        if (ready && !holds_) return true;
        if (waits && !waits()) return false;
        serve_until(clock_.now_s() + nap_s);
    }
}

void Loop::play_all(FrameSource& source, Feeler& feeler, const Told& told, const std::function<bool()>& waits) {
    const link::Status before = device_.status();
    bool going = true;
    while (going && await(source, waits)) {
        const std::optional<Frame> frame = source.next();
        if (!frame) break;
        going = take(*frame, source, feeler, told);
    }
    // The last ring is played until the shot after it would have been missed.
    if (last_time_s_) serve_until(begin_s_ + *last_time_s_ + 1.5 / rate_hz_);
    device_.wait();
    player_.settle();
    const link::Status status = device_.status();
    link::require_on(status, &before);
    report_.underruns = static_cast<std::uint16_t>(status.underruns - before.underruns);
}

LoopReport Loop::run(FrameSource& source, Feeler& feeler, const Told& told, const std::function<bool()>& waits) {
    link::while_on(device_, options_.watchdog_ms, [&] { play_all(source, feeler, told, waits); });
    report_.rings = player_.sent();
    static_cast<ShotCounts&>(report_) = feeler.counts();
    return report_;
}

void require_played(const LoopReport& report) {
    if (report.with_rings == 0) return;
    if (report.rings.empty())
        throw Error(
            ErrorCode::failed, "live",
            fmt::format("nothing was played: {} of {} shots made something to feel, and none was on the board in "
                        "time; take fewer frames a second, a faster line, or a board that computes foci",
                        report.with_rings, report.shots));
    const std::uint64_t due = report.given - std::min(report.given, report.skipped);  // what was skipped was said
    if (4 * report.rings.size() < due)
        throw Error(ErrorCode::failed, "live",
                    fmt::format("only {} paths began of {} that were sent; take a board that computes foci, or an "
                                "algorithm whose passes are shorter",
                                report.rings.size(), due));
    if (2 * report.unsent > report.shots)
        throw Error(ErrorCode::failed, "live",
                    fmt::format("what {} of {} shots made was not on the board in time; take fewer frames a second, or "
                                "a faster line",
                                report.unsent, report.shots));
}

std::string overtaken_in_words(const LoopReport& report) {
    const std::uint64_t due = report.with_rings - std::min(report.with_rings, report.skipped);
    if (4 * report.rings.size() >= due) return {};
    return fmt::format(
        "only {} of {} frames that made something to feel were played, each the newest there was; the "
        "others came while the line and the machine were busy with one before",
        report.rings.size(), due);
}

Latency latency_of(std::span<const SentRing> rings, std::span<const std::pair<double, std::uint16_t>> starts) {
    std::vector<double> latencies;
    for (const SentRing& ring : rings) {
        const auto start = std::find_if(starts.begin(), starts.end(), [&](const auto& s) {
            return s.first >= ring.pushed_s && s.second == ring.first_index;
        });
        if (start != starts.end()) latencies.push_back(start->first - ring.shot_s);
    }
    return spread_of(std::move(latencies));
}

Latency latency_of(std::span<const SentRing> rings) {
    std::vector<double> latencies;
    double uncertain_s = 0.0;
    for (const SentRing& ring : rings) {
        if (!ring.began_s) continue;
        latencies.push_back(ring.began_s->middle() - ring.shot_s);
        uncertain_s = std::max(uncertain_s, ring.began_s->half());
    }
    Latency latency = spread_of(std::move(latencies));
    latency.uncertain_s = uncertain_s;
    return latency;
}

}  // namespace haptogram::live
