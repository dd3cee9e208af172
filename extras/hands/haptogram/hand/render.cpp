// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/render.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/touch.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/solve/solver.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;

std::vector<SkinRegion> skin_of(const HandFrame& frame, std::size_t number, const SkinOptions& options) {
    std::vector<SkinRegion> skin;
    for (const Hand& hand : frame.hands) {
        try {
            for (SkinRegion& region : palmar_surface(hand, options)) skin.push_back(std::move(region));
        } catch (const Error& error) {
            throw Error(error.code(), fmt::format("frame {}", number), error.what());
        }
    }
    return skin;
}

/// cos² of the angle between the sound's way from the array's centre and the skin's normal; 0 where the skin faces
/// away.
double tilt_of(Vec3 position, Vec3 normal) {
    const double range = norm(position);
    const double cosine = range > 0.0 ? -dot(position, normal) / range : 0.0;
    return cosine > 0.0 ? cosine * cosine : 0.0;
}

/// The numbers of what is drawn, where a focus is in its middle.
/// @param slow  what the focus does is felt where it is, not as a whole
void describe(FrameReport& report, const Touch& touch, const Array& array, const RenderOptions& options, bool slow) {
    report.lines = touch.lines.size();
    report.foci = touch.voices.size();
    report.length_m = length_of(touch.lines);
    if (touch.voices.empty()) return;
    report.draw_hz = 1.0 / touch.voices.front().seconds();
    double weight = 0.0, tilt = 0.0;
    Vec3 middle;
    for (const Voice& voice : touch.voices)
        for (const Leg& leg : voice.legs) {
            if (leg.silent) continue;
            const Vec3 at = 0.5 * (leg.from.position + leg.to.position);
            middle = middle + leg.seconds * at;
            tilt += leg.seconds * tilt_of(at, leg.from.normal);
            weight += leg.seconds;
        }
    if (!(weight > 0.0)) return;
    middle = middle * (1.0 / weight);
    report.tilt = tilt / weight;
    if (!array.unreachable(middle).empty()) return;  // what is said of a focus there would be wrong
    report.width_m = focal_width(array, middle);
    report.focus_pa =
        radiation_pressure(options.amplitude * pressure(array, ideal_drives(array, middle), middle), array.medium);
    double drawn = 0.0;  // by the first focus
    for (const Leg& leg : touch.voices.front().legs)
        if (!leg.silent) drawn += distance(leg.from.position, leg.to.position);
    const double share = slow || drawn < report.width_m ? 1.0 : report.width_m / drawn;
    report.strength_pa = report.focus_pa * share / static_cast<double>(report.foci);
    double weak = 0.0;
    for (const Voice& voice : touch.voices)
        for (const Leg& leg : voice.legs) {
            if (!leg.silent && is_weak(leg, report, options.least_force_n)) weak += leg.seconds;
        }
    report.weak = weak / weight;
}

void check_steps(const RenderOptions& options, bool one) {
    if (!options.points) return;
    if (options.dwell) throw bad_argument("points", "give either the points of a pass or their dwell", {"dwell"});
    if (!one)
        throw bad_argument("points", "are those of one frame's pass; give a frame, or a dwell instead",
                           {"frame", "dwell"});
    if (*options.points == 0) throw bad_argument("points", "found 0, expected at least 1");
}

Error nothing_touched(const TouchObject& object, const HandRecording& hands, const RenderOptions& options) {
    double nearest = INFINITY;
    std::size_t at = 0;
    for (std::size_t i = 0; i < hands.frames.size(); ++i)
        if (!options.frame || i + 1 == *options.frame)
            for (const SkinRegion& region : skin_of(hands.frames[i], i + 1, options.skin))
                for (const Vec3& point : region.points)
                    if (const double distance = object.solid.distance(point); distance < nearest) {
                        nearest = distance;
                        at = i + 1;
                    }
    if (at == 0) return bad_input("hand", "there is no hand in it; take another frame or recording", {"frame", "hand"});
    if (nearest < 0.0)
        return bad_input("hand",
                         fmt::format("algorithm {} has nothing to draw where the hand touches the object; take "
                                     "another algorithm or move the object",
                                     name_of(options.algorithm).letter),
                         {"algorithm", "center"});
    return bad_input("hand",
                     fmt::format("it never touches the object; it comes nearest, to {:.1f} mm, in frame {}; move "
                                 "the object there",
                                 nearest / millimetre, at),
                     {"center"});
}

/// The time between two frames of a recording as it mostly is.
double usual_interval(const HandRecording& hands) {
    std::vector<double> intervals;
    for (std::size_t i = 1; i < hands.frames.size(); ++i)
        intervals.push_back(hands.frames[i].time_s - hands.frames[i - 1].time_s);
    if (intervals.empty()) return 0.0;
    std::nth_element(intervals.begin(), intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2),
                     intervals.end());
    return intervals[intervals.size() / 2];
}

/// Plays what a frame feels until the next one. Where more than two frames are missing nobody knows where the hand is:
/// then it fades in two steps.
/// @return whether it faded
bool play_frame(PathPen& pen, const std::vector<Voice>& voices, double from_s, double until_s, double usual_s,
                Played& played) {
    constexpr double missing = 3.5;  // intervals: three frames should have come, and the next one is late
    if (voices.empty() || until_s - from_s < missing * usual_s) {
        played = pen.play(voices, until_s);
        return false;
    }
    played = pen.play(voices, from_s + 2.0 * usual_s);
    static_cast<void>(pen.play(voices, from_s + 2.5 * usual_s, 2.0 / 3.0));
    static_cast<void>(pen.play(voices, from_s + 3.0 * usual_s, 1.0 / 3.0));
    static_cast<void>(pen.play({}, until_s));
    return true;
}

/// The waveform of the amplitude, and the commands for a magnitude under it.
/// @param am_hz  of the algorithm's own sine; 0: none
void modulate(Rendered& rendered, double am_hz, const Array& array, const RenderOptions& options) {
    if (am_hz > 0.0 && !options.am.empty())
        throw bad_argument("am", fmt::format("algorithm {} has a modulation of its own; leave one of them out",
                                             name_of(options.algorithm).letter));
    const std::string am = am_hz > 0.0 ? fmt::format("sine:{}", am_hz) : options.am;
    const AmplitudeLaw law = am_hz > 0.0 ? AmplitudeLaw::pressure : options.am_law;
    if (!am.empty())
        rendered.path.modulation = modulation_of(am, law, rendered.carrier_hz, options.am_folder).modulation;
    weaken(rendered.path, options.amplitude);
    if (!options.magnitude) return;
    require_one_strength(options.magnitude, options.amplitude);
    const perception::Tables tables = perception::find_tables();
    perception::CommandLattice commands(
        tables, perception::wanted_of(*options.magnitude, am, law == AmplitudeLaw::radiation), array);
    rendered.magnitude = give_magnitude(rendered.path, commands);
}

/// Thousandths of a millimetre are enough to draw.
ordered_json drawn_mm(Vec3 p) {
    const auto rounded = [](double metres) { return std::round(metres / millimetre * 1e3) / 1e3; };
    return {rounded(p.x), rounded(p.y), rounded(p.z)};
}

/// The object's distance in planes of one height, from which the picture takes its outlines.
ordered_json drawn_slices(const TouchObject& object) {
    constexpr int heights = 9, across = 61;
    constexpr double rim = 5e-3;
    const auto share = [](int i, int count, double low, double high) { return low + (high - low) * (i + 0.5) / count; };
    ordered_json slices = ordered_json::array();
    for (int k = 0; k < heights; ++k) {
        const double z = share(k, heights, object.low.z, object.high.z);
        ordered_json distances = ordered_json::array();
        for (int j = 0; j < across; ++j)
            for (int i = 0; i < across; ++i)
                distances.push_back(
                    std::round(1e6 *
                               object.solid.distance({share(i, across, object.low.x - rim, object.high.x + rim),
                                                      share(j, across, object.low.y - rim, object.high.y + rim), z})) /
                    1e3);
        slices.push_back({{"z_mm", z / millimetre},
                          {"low_mm", drawn_mm(object.low - Vec3{rim, rim, 0.0})},
                          {"high_mm", drawn_mm(object.high + Vec3{rim, rim, 0.0})},
                          {"across", across},
                          {"distances_mm", std::move(distances)}});
    }
    return slices;
}

/// The mean square pressure of a path's pass at points.
std::vector<float> squares_of(const Path& pass, const Array& array, const std::vector<Vec3>& points) {
    std::vector<std::vector<std::complex<double>>> drives;
    std::vector<WeightedDrives> sequence;
    for (const PathStep& step : pass.steps) {
        std::vector<std::complex<double>> some(array.elements.size());
        if (!step.foci.empty()) some = solve(array, step.foci);
        for (auto& drive : some) drive *= array.transducer.source_pa_m;
        drives.push_back(std::move(some));
    }
    for (std::size_t i = 0; i < drives.size(); ++i)
        sequence.push_back({static_cast<double>(pass.steps[i].periods), drives[i]});
    return mean_square_pressure_at(array, sequence, points, {.threads = 0});
}

/// A frame's hand, lines, and the radiation pressure on its skin.
ordered_json drawn_frame(const FrameReport& report, const TouchObject& object, const HandFrame& frame,
                         const Array& array, double carrier_hz, const RenderOptions& options) {
    constexpr std::size_t skip = 2;
    const std::vector<SkinRegion> skin = skin_of(frame, report.frame, options.skin);
    const Touch made = touch_of(options.algorithm, object, skin, frame.time_s, options.touch);
    PathPen pen(array, carrier_hz, options.dwell.value_or(usual_dwell(options.algorithm)));
    (void)pen.play_pass(made.voices, options.points);
    std::vector<Vec3> points, normals;
    for (const SkinRegion& region : skin)
        for (std::size_t row = 0; row < region.rows; row += skip)
            for (std::size_t column = 0; column < region.columns; column += skip) {
                points.push_back(region.point(row, column));
                normals.push_back(region.normals[row * region.columns + column]);
            }
    const std::vector<float> squares = squares_of(pen.path(), array, points);
    const Hand& hand = frame.hands.front();
    ordered_json drawn = {{"frame", report.frame},
                          {"time_s", report.time_s},
                          {"palm_mm", drawn_mm(hand.palm)},
                          {"direction", {hand.direction.x, hand.direction.y, hand.direction.z}},
                          {"normal", {hand.normal.x, hand.normal.y, hand.normal.z}},
                          {"length_mm", report.length_m / millimetre},
                          {"draw_hz", report.draw_hz},
                          {"strength_pa", report.strength_pa},
                          {"tilt", report.tilt},
                          {"points_mm", ordered_json::array()},
                          {"radiation_pa", ordered_json::array()},
                          {"lines", ordered_json::array()}};
    for (std::size_t i = 0; i < points.size(); ++i) {
        drawn["points_mm"].push_back(drawn_mm(points[i]));
        const double rms = std::sqrt(static_cast<double>(squares[i]));
        drawn["radiation_pa"].push_back(
            std::round(1e3 * radiation_pressure(std::sqrt(2.0) * rms, array.medium) * tilt_of(points[i], normals[i])) /
            1e3);
    }
    for (const SkinLine& line : made.lines) {
        ordered_json some = ordered_json::array();
        for (const SkinPoint& point : opened(line)) some.push_back(drawn_mm(point.position));
        drawn["lines"].push_back({{"kind", name_of(line.kind)}, {"points_mm", std::move(some)}});
    }
    return drawn;
}

}  // namespace

std::vector<SkinRegion> skin_of(const HandRecording& hands, std::size_t frame, const SkinOptions& options) {
    if (frame == 0 || frame > hands.frames.size())
        throw bad_argument("hand-frame",
                           fmt::format("found {}, the recording has frames 1 to {}", frame, hands.frames.size()));
    std::vector<SkinRegion> skin = skin_of(hands.frames[frame - 1], frame, options);
    if (skin.empty())
        throw bad_input(fmt::format("frame {}", frame), "there is no hand in it; take another frame", {"hand-frame"});
    return skin;
}

std::function<HandSkin(Vec3)> nearest_skin(std::vector<SkinRegion> skin) {
    return [skin = std::move(skin)](Vec3 place) {
        HandSkin nearest;
        double least = INFINITY;
        for (const SkinRegion& region : skin) {
            const SkinPoint point = region.nearest(place);
            if (const double away = distance(point.position, place); away < least) {
                least = away;
                nearest = {point.position, point.normal, std::string(region.name)};
            }
        }
        return nearest;
    };
}

bool is_weak(const Leg& leg, const FrameReport& report, double least_force_n) {
    const double tilt = tilt_of(0.5 * (leg.from.position + leg.to.position), leg.from.normal);
    return report.strength_pa * tilt * report.width_m * report.width_m < least_force_n;
}

ordered_json to_json(const FrameReport& f) {
    ordered_json json = {{"frame", f.frame},
                         {"time_s", f.time_s},
                         {"hands", f.hands},
                         {"lines", f.lines},
                         {"foci", f.foci},
                         {"length_mm", f.length_m / millimetre},
                         {"draw_hz", f.draw_hz},
                         {"focus_pa", f.focus_pa},
                         {"width_mm", f.width_m / millimetre},
                         {"strength_pa", f.strength_pa},
                         {"tilt", f.tilt},
                         {"weak", f.weak},
                         {"out_of_reach", f.out_of_reach},
                         {"lines_missed", f.lines_missed},
                         {"compute_ms", f.compute_s * 1e3}};
    if (!f.why.empty()) json["why"] = f.why;
    return json;
}

Rendered render(const TouchObject& object, const HandRecording& hands, const Array& array, double carrier_hz,
                const RenderOptions& options, const Progress& progress) {
    if (hands.frames.empty()) throw bad_input("hand", "the recording has no frames");
    if (options.frame && (*options.frame == 0 || *options.frame > hands.frames.size()))
        throw bad_argument("frame", fmt::format("found {}, expected 1 to {}", *options.frame, hands.frames.size()));
    const bool one = options.frame.has_value() || hands.frames.size() == 1;
    RenderOptions settings = options;
    if (one && !settings.frame) settings.frame = 1;
    Rendered rendered;
    rendered.carrier_hz = carrier_hz;
    check_steps(settings, one);
    PathPen pen(array, carrier_hz, settings.dwell.value_or(usual_dwell(settings.algorithm)));
    double am_hz = 0.0;
    std::size_t foci = 0, lost = 0, weak_frames = 0, facing_away = 0, gaps = 0;
    const double usual_s = usual_interval(hands);
    std::string why;
    const std::size_t first = one ? *settings.frame - 1 : 0, end = one ? first + 1 : hands.frames.size();
    for (std::size_t i = first; i < end; ++i) {
        progress(static_cast<double>(i - first) / static_cast<double>(end - first), "rendering");
        const HandFrame& frame = hands.frames[i];
        const std::clock_t began = std::clock();
        const std::vector<SkinRegion> skin = skin_of(frame, i + 1, settings.skin);
        const Touch made = touch_of(settings.algorithm, object, skin, frame.time_s, settings.touch);
        am_hz = std::max(am_hz, made.am_hz);
        Played played;
        if (one && made.voices.empty()) throw nothing_touched(object, hands, settings);
        if (one) {
            played = pen.play_pass(made.voices, settings.points);
        } else {
            const double last_s = i > 0 ? frame.time_s - hands.frames[i - 1].time_s : 0.0;
            const double until_s = i + 1 < hands.frames.size() ? hands.frames[i + 1].time_s : frame.time_s + last_s;
            gaps += play_frame(pen, made.voices, frame.time_s, until_s, usual_s, played) ? 1 : 0;
        }
        FrameReport& report = rendered.frames.emplace_back();
        report.compute_s = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
        report.frame = i + 1;
        report.time_s = frame.time_s;
        report.hands = frame.hands.size();
        describe(report, made, array, settings,
                 settings.algorithm == Algorithm::pointer || settings.algorithm == Algorithm::press);
        report.out_of_reach =
            played.foci > 0 ? static_cast<double>(played.out_of_reach) / static_cast<double>(played.foci) : 0.0;
        report.why = played.why;
        report.lines_missed = played.lines_missed;
        if (why.empty()) why = played.why;
        foci += played.foci;
        lost += played.out_of_reach;
        weak_frames += report.weak > 0.5 ? 1 : 0;
        facing_away += report.foci > 0 && report.tilt < 0.05 ? 1 : 0;
        if (one) rendered.touch = made;
    }
    if (foci == 0) throw nothing_touched(object, hands, settings);
    if (lost == foci)
        throw bad_input("hand", fmt::format("everything that it touches is out of the array's reach: {}", why),
                        {"center", "array"});
    rendered.path = pen.path();
    modulate(rendered, am_hz, array, settings);
    if (lost > 0)
        rendered.warnings.push_back(
            fmt::format("{:.1f} % of the foci are out of the array's reach and silent; the first is {}",
                        100.0 * static_cast<double>(lost) / static_cast<double>(foci), why));
    if (gaps > 0)
        rendered.warnings.push_back(
            fmt::format("more than two frames are missing in {} places, where what is felt fades", gaps));
    if (one && rendered.frames.front().lines_missed > 0)
        rendered.warnings.push_back(fmt::format("{} lines are shorter than a step and were missed; take more points",
                                                rendered.frames.front().lines_missed));
    if (facing_away > 0)
        rendered.warnings.push_back(
            fmt::format("in {} frames the skin that is drawn on hardly faces the array, which leaves "
                        "less than 5 % of the radiation pressure",
                        facing_away));
    if (weak_frames > 0)
        rendered.warnings.push_back(
            fmt::format("in {} frames more than half of the lines is estimated to be too weak to be "
                        "felt; see the report",
                        weak_frames));
    return rendered;
}

void draw_render(const std::string& path, const TouchObject& object, const HandRecording& hands, const Array& array,
                 double carrier_hz, const RenderOptions& options, const Rendered& rendered) {
    constexpr std::size_t most_panels = 6;
    std::vector<const FrameReport*> touching;
    for (const FrameReport& report : rendered.frames)
        if (report.foci > 0) touching.push_back(&report);
    ordered_json json = {
        {"object", object.name},
        {"algorithm", fmt::format("{}: {}", name_of(options.algorithm).letter, name_of(options.algorithm).about)},
        {"array", array.name},
        {"elements_mm", ordered_json::array()},
        {"edges_mm", ordered_json::array()},
        {"slices", drawn_slices(object)},
        {"frames", ordered_json::array()}};
    for (const Element& element : array.elements) json["elements_mm"].push_back(drawn_mm(element.position));
    for (const Edge& edge : object.edges) {
        ordered_json points = ordered_json::array();
        for (const Vec3& p : edge) points.push_back(drawn_mm(p));
        json["edges_mm"].push_back(std::move(points));
    }
    const std::size_t panels = std::min(most_panels, touching.size());
    for (std::size_t k = 0; k < panels; ++k) {
        const FrameReport& report = *touching[panels == 1 ? 0 : k * (touching.size() - 1) / (panels - 1)];
        json["frames"].push_back(
            drawn_frame(report, object, hands.frames[report.frame - 1], array, carrier_hz, options));
    }
    Picture picture("shipped:tools/plot_touch.py");
    picture.add("touch.json", json.dump());
    picture.draw(path, ".json and --report");
}

}  // namespace haptogram
