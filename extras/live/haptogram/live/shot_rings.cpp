// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/shot_rings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::live {
namespace {

std::string unreachable(const Array& array, const Path& ring) {
    for (const PathStep& step : ring.steps)
        for (const Focus& focus : step.foci)
            if (std::string why = array.unreachable(focus.position); !why.empty()) return why;
    return {};
}

/// The still focus' modulation as perception knows it.
perception::Wanted wanted_of(double magnitude, const RingOptions& ring) {
    if (ring.motion != FocusMotion::still)
        throw bad_argument("magnitude",
                           "is known of a focus that rests and is modulated; take the still focus (--algorithm still), "
                           "or leave the magnitude out");
    return perception::wanted_of(magnitude, fmt::format("sine:{}", ring.still_am_hz), false);
}

void append(Path& all, const Path& ring) {
    if (all.steps.empty()) {
        all = ring;
        return;
    }
    for (std::size_t j = 0; j < all.steps.size(); ++j)
        all.steps[j].foci.insert(all.steps[j].foci.end(), ring.steps[j].foci.begin(), ring.steps[j].foci.end());
}

}  // namespace

ShotRings::ShotRings(const Array& array, double carrier_hz, const FingerOptions& options,
                     std::vector<DepthCamera> cameras)
    : array_(array),
      carrier_hz_(carrier_hz),
      options_(options),
      cameras_(std::move(cameras)),
      clouds_(options.cloud),
      scene_(options.scene),
      predictor_(options.predict),
      weigher_(array),
      tables_(perception::find_tables()) {
    haptogram::require_sound(options.ring);
    if (!(options.rate_hz > 0.0))
        throw bad_argument("rate", fmt::format("found {}, expected more than 0", options.rate_hz));
    if (options.magnitude)
        commands_ =
            std::make_unique<perception::CommandLattice>(tables_, wanted_of(*options.magnitude, options.ring), array_);
}

/// @return why it cannot, or nothing
std::optional<std::string> ShotRings::give_magnitude(Path& ring) {
    if (!commands_) return {};
    try {
        perception::give_magnitude(ring, *commands_);
    } catch (const Error& error) {
        return error.message();
    }
    const double make_up = 1.0 / std::sqrt(held_fundamental(options_.ring));
    for (PathStep& step : ring.steps)
        for (Focus& focus : step.foci)
            if ((focus.amplitude *= make_up) > 1.0) return "the array is too weak there for a wave in steps";
    return {};
}

std::string ShotRings::about() const {
    if (options_.ring.motion != FocusMotion::revolving) return {};
    constexpr double step_m = 0.5e-3, highest_m = 0.3;
    Vec3 top = options_.object.pose.origin;
    while (scene_.distance_to(top) < 0.0 && top.z < options_.object.pose.origin.z + highest_m) top.z += step_m;
    return reach_in_words(array_, top, options_.ring.points);
}

/// Gives each focus of a ring the amplitude with which all places feel alike, and takes away those that the finger
/// hides.
void ShotRings::weigh(Path& ring, const FingerCut& contact) {
    std::vector<Vec3> places;
    for (const PathStep& step : ring.steps) places.push_back(step.foci.front().position);
    const std::optional<FingerForm> form = form_of(contact);
    const std::optional<RingReach> reach = form ? weigher_.weigh(places, *form) : std::nullopt;
    if (!reach) {
        ++counts_.unweighed;
        return;
    }
    if (reach->reached < places.size()) ++counts_.hidden;
    for (std::size_t j = 0; j < places.size(); ++j) {
        ring.steps[j].foci.front().amplitude *= reach->amplitudes[j];
        if (reach->amplitudes[j] == 0.0) ring.steps[j].foci.clear();
    }
}

std::optional<Path> ShotRings::ring_of(const SceneFinger& finger, const std::optional<Vec3>& sight,
                                       ShotReport& report) {
    const auto refuse = [&](std::uint64_t& count, const std::string& why) {
        ++count;
        report.troubles.push_back(fmt::format("finger {} {}: it gets no ring", finger.id, why));
        return std::optional<Path>{};
    };
    const double half = 0.5 * options_.scene.size_m;
    if (options_.scene.kind != "half-space" && finger.deepest_m > half)
        return refuse(counts_.through,
                      fmt::format("is {:.1f} mm deep, behind the object's middle", 1e3 * finger.deepest_m));
    const auto section = section_of(finger.section, finger.surface, finger.inward, sight, options_.section);
    if (!section)
        return refuse(
            counts_.no_section,
            fmt::format("has {} points beside the surface that are no section of a finger", finger.section.size()));
    Ellipse placed = section->ellipse;
    placed.centre = predictor_.ahead(finger.id, placed.centre, report.time_s, report.time_s);
    const auto last = last_start_.find(finger.id);
    const std::optional<Vec3> start = last == last_start_.end() ? std::optional<Vec3>{} : last->second;
    Path ring = ring_path({&placed, 1}, {&start, 1}, carrier_hz_, options_.ring);
    if (const std::string why = unreachable(array_, ring); !why.empty())
        return refuse(counts_.out_of_reach, fmt::format("is out of the array's reach, {}", why));
    if (const auto why = give_magnitude(ring))
        return refuse(counts_.without_magnitude, fmt::format("cannot feel with that magnitude, {}", *why));
    const Vec3 moved = placed.centre - section->ellipse.centre;
    if (options_.ring.motion == FocusMotion::revolving)
        weigh(ring, {placed, finger.inward, finger.place + moved, finger.deepest_m});
    if (section->constrained) ++counts_.constrained;
    report.sections.push_back(section->ellipse);
    report.centres.push_back(placed.centre);
    return ring;
}

void ShotRings::tell_object(ShotReport& report) const {
    report.objects = {options_.object};
    // A mesh stays where it is. Its solid stands in the array's frame, and so the scene knows no pose of it.
    if (!options_.scene.solid) report.objects.front().pose = scene_.object();
}

void ShotRings::note_cameras(const DepthShot& shot, ShotReport& report) {
    counts_.without_picture.resize(std::max(counts_.without_picture.size(), shot.pictures.size()));
    bool missing = false;
    for (std::size_t i = 0; i < shot.pictures.size(); ++i) {
        if (shot.pictures[i]) continue;
        missing = true;
        ++counts_.without_picture[i];
        report.troubles.push_back(fmt::format("camera {} gave no picture", i + 1));
    }
    if (missing) ++counts_.without_camera;
}

std::optional<Path> ShotRings::take(std::span<const DepthCamera> cameras, const DepthShot& shot, ShotReport& report) {
    note_cameras(shot, report);
    tell_object(report);
    // When all cameras are gone nothing is known of the fingers: the scene stays as it is, as when a shot is lost.
    report.blind =
        std::none_of(shot.pictures.begin(), shot.pictures.end(), [](const auto& p) { return p.has_value(); });
    if (report.blind) return {};
    std::optional<Vec3> eye;
    if (cameras.size() == 1) eye = cameras.front().pose.origin;
    const std::vector<Vec3> cloud = clouds_.cloud(cameras, shot);
    if (cloud.empty()) report.troubles.emplace_back("there is nothing in the workspace");
    return rings_of(cloud, eye, report);
}

/// Points all around the fingers where they are near the object, and not within one another.
std::vector<Vec3> ShotRings::cloud_of(const Hand& hand) const {
    constexpr double near_m = 5e-3, apart_m = 1e-3;
    std::vector<Vec3> cloud;
    std::vector<SkinPatch> segments;
    for (const SkinRegion& region : palmar_surface(hand, options_.skin))
        for (const SkinPatch& patch : region.patches)
            if (patch.radius > 0.0) segments.push_back(patch);
    const auto within = [](const SkinPatch& segment, Vec3 p) {
        const double foot = std::clamp(dot(p - segment.from, segment.along), 0.0, segment.length);
        return distance(p, segment.from + foot * segment.along) < segment.radius - 1e-6;
    };
    for (const SkinPatch& segment : segments) {
        const double reach = 0.5 * segment.length + segment.radius + near_m;
        if (scene_.distance_to(segment.from + 0.5 * segment.length * segment.along) > reach) continue;
        const double rim = 0.5 * std::numbers::pi * segment.radius;  // over each round end
        const double around = 2.0 * std::numbers::pi * segment.radius;
        for (double s = -rim; s <= segment.length + rim; s += apart_m) {
            const double over = s < 0.0 ? s : std::max(0.0, s - segment.length);
            const double angle = over / segment.radius;
            const Vec3 middle =
                segment.from + (std::clamp(s, 0.0, segment.length) + segment.radius * std::sin(angle)) * segment.along;
            const double radius = segment.radius * std::cos(angle);
            const auto points = static_cast<int>(std::ceil(around * std::cos(angle) / apart_m)) + 1;
            for (int k = 0; k < points; ++k) {
                const double turn = 2.0 * std::numbers::pi * k / points;
                const Vec3 p = middle + radius * (std::cos(turn) * segment.out + std::sin(turn) * segment.side);
                if (scene_.distance_to(p) < near_m &&
                    std::none_of(segments.begin(), segments.end(), [&](const SkinPatch& o) { return within(o, p); }))
                    cloud.push_back(p);
            }
        }
    }
    return cloud;
}

std::optional<Path> ShotRings::feel(const Frame& frame, ShotReport& report) {
    if (const auto* shot = std::get_if<DepthShot>(&frame.seen)) return take(cameras_, *shot, report);
    std::vector<Vec3> cloud;
    const auto* both = std::get_if<Together>(&frame.seen);
    if (both != nullptr) {
        note_cameras(both->shot, report);
        cloud = clouds_.cloud(cameras_, both->shot);
    }
    for (const Hand& hand : (both != nullptr ? both->hands : std::get<HandFrame>(frame.seen)).hands) {
        // One that is still where its tracker saw it before is missing; it has not stopped.
        if (hand.seen_s && std::exchange(last_seen_s_[hand.id], *hand.seen_s) == *hand.seen_s) continue;
        const std::vector<Vec3> some = cloud_of(hand);
        cloud.insert(cloud.end(), some.begin(), some.end());
    }
    tell_object(report);
    return rings_of(cloud, {}, report);
}

std::optional<Path> ShotRings::rings_of(std::span<const Vec3> cloud, const std::optional<Vec3>& eye,
                                        ShotReport& report) {
    report.points = cloud.size();
    if (cloud.empty()) ++counts_.empty;
    const std::vector<SceneFinger>& fingers = scene_.update(cloud, report.time_s);
    report.fingers = fingers.size();
    std::vector<std::pair<std::uint64_t, Path>> rings;
    for (const SceneFinger& finger : fingers) {
        report.force_n += norm(finger.force);
        if (!finger.seen) continue;
        std::optional<Vec3> sight;
        if (eye) sight = finger.place - *eye;
        if (auto ring = ring_of(finger, sight, report)) rings.emplace_back(finger.id, std::move(*ring));
    }
    predictor_.forget_before(report.time_s - 2.5 / options_.rate_hz);
    if (commands_ && rings.size() > 1) {
        ++counts_.without_magnitude;
        report.troubles.push_back(
            fmt::format("{} fingers touch at a time and share the array's pressure, of which no magnitude is known: "
                        "none gets a ring",
                        rings.size()));
        rings.clear();
        report.sections.clear();
        report.centres.clear();
    }
    report.foci = rings.size();
    tell_object(report);
    last_start_.clear();
    if (rings.empty()) return {};
    ++counts_.with_rings;
    Path all;
    for (const auto& [finger, ring] : rings) {
        if (!ring.steps.front().foci.empty()) last_start_[finger] = ring.steps.front().foci.front().position;
        append(all, ring);
    }
    return all;
}

}  // namespace haptogram::live
