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

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Ellipse shifted(Ellipse ellipse, Vec3 to) {
    ellipse.centre = to;
    return ellipse;
}

std::optional<std::string> unreachable(const Array& array, const Path& ring) {
    for (const PathStep& step : ring.steps)
        for (const Focus& focus : step.foci)
            if (std::string why = array.unreachable(focus.position); !why.empty()) return why;
    return {};
}

}  // namespace

Loop::Loop(link::Commands& device, const Clock& clock, const Array& array, const LoopOptions& options)
    : device_(device),
      clock_(clock),
      array_(array),
      options_(options),
      clouds_(options.cloud),
      scene_(options.scene),
      predictor_(options.predict),
      player_(device, clock, array, options.ring.points, options.method, options.watchdog_ms) {
    haptogram::require_sound(options.ring);
    if (!(options.rate_hz > 0.0))
        throw bad_argument("rate", fmt::format("found {}, expected more than 0", options.rate_hz));
}

void Loop::miss() {
    ++report_.missed;
    if (++misses_ == options_.misses_to_fade && player_.playing()) {
        ++report_.fades;
        player_.fade();
    }
}

void Loop::serve_until(double time_s) {
    // The board's time goes on while it is served, so late shots are seen here.
    constexpr double nap_s = 0.5e-3;
    for (double now = clock_.now_s(); now < time_s; now = clock_.now_s()) {
        while (last_time_s_ &&
               now - begin_s_ > *last_time_s_ + (static_cast<double>(absent_) + 1.5) / options_.rate_hz) {
            ++absent_;
            miss();
        }
        if (!player_.service()) clock_.wait_until(std::min(time_s, now + nap_s));
    }
}

void Loop::gather(const SceneFinger& finger, const std::optional<Vec3>& sight, ShotReport& shot, Wanted& wanted) {
    if (!finger.seen) return;
    const double half = 0.5 * options_.scene.size_m;
    if (options_.scene.kind != "half-space" && finger.deepest_m > half) {
        ++report_.through;
        shot.troubles.push_back(fmt::format("finger {} is {:.1f} mm deep, behind the object's middle: it gets no ring",
                                            finger.id, 1e3 * finger.deepest_m));
        return;
    }
    const auto section = section_of(finger.section, finger.surface, finger.inward, sight, options_.section);
    if (!section) {
        ++report_.no_section;
        shot.troubles.push_back(fmt::format("finger {}: its {} points beside the surface are no section of a finger",
                                            finger.id, finger.section.size()));
        return;
    }
    if (section->constrained) ++report_.constrained;
    const Ellipse placed = shifted(section->ellipse, predictor_.ahead(finger.id, section->ellipse.centre, shot.time_s));
    shot.sections.push_back(section->ellipse);
    shot.centres.push_back(placed.centre);
    wanted.sections.push_back(placed);
    wanted.fingers.push_back(finger.id);
    const auto last = last_start_.find(finger.id);
    wanted.starts.push_back(last == last_start_.end() ? std::optional<Vec3>{} : last->second);
}

void Loop::play(const Wanted& wanted, const ShotReport& shot) {
    if (wanted.sections.empty()) {
        // A finger that has left is nothing to feel any more; one that cannot be rendered fades.
        if (shot.fingers > 0 || !shot.troubles.empty()) {
            if (player_.playing() && !player_.fading()) {
                ++report_.fades;
                player_.fade();
            }
        } else if (!player_.fading()) {
            player_.silence();
        }
        return;
    }
    const Path ring = ring_path(wanted.sections, wanted.starts, player_.timer().carrier_hz(), options_.ring);
    if (unreachable(array_, ring)) {
        ++report_.out_of_reach;
        return;
    }
    last_start_.clear();
    for (std::size_t f = 0; f < wanted.fingers.size(); ++f)
        if (f < ring.steps.front().foci.size()) last_start_[wanted.fingers[f]] = ring.steps.front().foci[f].position;
    ++report_.with_rings;
    player_.replace(ring, shot.number, shot.time_s + begin_s_);
}

bool Loop::take(const DepthShot& shot, std::span<const DepthCamera> cameras, const Told& told) {
    if (last_time_s_ && (shot.time_s <= *last_time_s_ || shot.number <= last_number_)) {
        ++report_.out_of_order;
        return true;
    }
    serve_until(begin_s_ + shot.time_s);
    // The ring of the shot before should be on the board by now. A late shot was counted when it was late.
    if (absent_ == 0 && player_.sending() && !player_.fading())
        miss();
    else if (absent_ == 0)
        misses_ = 0;
    absent_ = 0;

    ShotReport now;
    now.number = shot.number;
    now.time_s = shot.time_s;
    if (last_time_s_ && shot.number > last_number_ + 1) {
        report_.lost += shot.number - last_number_ - 1;
        now.troubles.push_back(
            fmt::format("{} shots before number {} were lost", shot.number - last_number_ - 1, shot.number));
    }
    const double began_s = processor_s();
    std::optional<Vec3> sight;
    for (std::size_t i = 0; i < shot.pictures.size(); ++i)
        if (!shot.pictures[i]) now.troubles.push_back(fmt::format("camera {} gave no picture", i + 1));
    if (!now.troubles.empty() &&
        std::any_of(shot.pictures.begin(), shot.pictures.end(), [](const auto& p) { return !p; }))
        ++report_.without_camera;
    const std::vector<Vec3> cloud = clouds_.cloud(cameras, shot);
    now.points = cloud.size();
    if (cloud.empty()) {
        ++report_.empty;
        now.troubles.emplace_back("there is nothing in the workspace");
    }
    Wanted wanted;
    for (const SceneFinger& finger : scene_.update(cloud, shot.time_s)) {
        if (cameras.size() == 1) sight = finger.place - cameras.front().pose.origin;
        ++now.fingers;
        now.force_n += norm(finger.force);
        gather(finger, sight, now, wanted);
    }
    predictor_.forget_before(shot.time_s - 2.5 / options_.rate_hz);
    now.foci = wanted.sections.size();
    now.object = scene_.object();
    play(wanted, now);
    now.compute_s = processor_s() - began_s;
    report_.compute_s.push_back(now.compute_s);
    ++report_.shots;
    last_time_s_ = shot.time_s;
    last_number_ = shot.number;
    return !told || told(now, shot);
}

LoopReport Loop::run(DepthSource& source, const Told& told) {
    const link::Outputs on(device_, options_.watchdog_ms);
    const std::uint16_t underruns_before = device_.status().underruns;
    bool first = true, going = true;
    while (going) {
        const std::optional<DepthShot> shot = source.next();
        if (!shot) break;
        if (std::exchange(first, false)) begin_s_ = clock_.now_s() - shot->time_s;
        going = take(*shot, source.cameras(), told);
    }
    // The last ring is played until the shot after it would have been missed.
    if (last_time_s_) serve_until(begin_s_ + *last_time_s_ + 1.5 / options_.rate_hz);
    device_.wait();
    const link::Status status = device_.status();
    link::require_on(status);
    report_.underruns = static_cast<std::uint16_t>(status.underruns - underruns_before);
    report_.rings = player_.sent();
    return report_;
}

Latency latency_of(std::span<const SentRing> rings, std::span<const std::pair<double, std::uint16_t>> starts) {
    std::vector<double> latencies;
    for (const SentRing& ring : rings) {
        const auto start = std::find_if(starts.begin(), starts.end(), [&](const auto& s) {
            return s.first >= ring.pushed_s && s.second == ring.first_index;
        });
        if (start != starts.end()) latencies.push_back(start->first - ring.shot_s);
    }
    if (latencies.empty()) return {};
    std::sort(latencies.begin(), latencies.end());
    return {latencies.size(), latencies.front(), latencies[latencies.size() / 2], latencies.back()};
}

}  // namespace haptogram::live
