// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/adaptics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/shape/draw.hpp"

namespace haptogram {
namespace {

constexpr double largest = 1e9;  ///< of any number in a pattern

/// Something that changes from key frame to key frame.
template <class Value>
struct Keyed {
    double time_ms = 0.0;
    Value value;
    bool step = false;  ///< holds its value until the next one, instead of changing linearly
};

/// A circle has two equal half-axes; a line has its length and its thickness.
struct Brush {
    bool line = false;
    double half_x_mm = 0.0, half_y_mm = 0.0, turn_deg = 0.0, am_hz = 0.0;
};

enum class FrameKind { standard, pause, stop };

struct Keyframes {
    std::vector<std::pair<double, FrameKind>> frames;  ///< times in ms, rising
    std::vector<Keyed<Vec3>> places;                   ///< mm; one a frame, for a pause that of the frame before
    std::vector<Keyed<Brush>> brushes;
    std::vector<Keyed<double>> intensities;
    Vec3 scale{1.0, 1.0, 1.0}, translate;  ///< mm
    double turn_deg = 0.0, intensity_factor = 1.0, speed = 1.0;
};

class PatternReader {
public:
    explicit PatternReader(const JsonMember& root) : root_(root) {}

    Keyframes read() {
        if (root_.at("$DATA_FORMAT").text() != "MidAirHapticsAnimationFileFormat")
            throw root_.at("$DATA_FORMAT").wrong("\"MidAirHapticsAnimationFileFormat\"");
        const std::string revision = root_.at("$REVISION").text();
        if (!revision.starts_with("0.0.10-") && !revision.starts_with("0.1.0-"))
            throw root_.at("$REVISION").wrong("0.0.10 or 0.1.0; open and save the pattern with a newer designer");
        read_parameters();
        read_transform();
        std::vector<JsonMember> frames = root_.at("keyframes").list();
        std::stable_sort(frames.begin(), frames.end(),
                         [](const JsonMember& a, const JsonMember& b) { return time_of(a) < time_of(b); });
        for (const JsonMember& frame : frames) add(frame);
        if (pattern_.frames.size() < 2 || pattern_.frames.back().first <= pattern_.frames.front().first)
            throw root_.at("keyframes").wrong("a list of key frames that lasts some time");
        if (pattern_.frames.front().second != FrameKind::standard)
            throw root_.at("keyframes").wrong("a list that begins with a standard key frame, which has a place");
        return std::move(pattern_);
    }

private:
    static double time_of(const JsonMember& frame) { return frame.at("time").number(0.0, largest); }

    void read_parameters() {
        const auto definitions = root_.find("user_parameter_definitions");
        if (!definitions) return;
        for (const auto& [name, unused] : definitions->object().items()) {
            const JsonMember definition = definitions->at(name);
            double value = definition.at("default").number(-largest, largest);
            const auto bound = [&](const char* key) {
                const auto found = definition.find(key);
                return found && !found->value().is_null() ? std::optional(found->number(-largest, largest))
                                                          : std::nullopt;
            };
            if (const auto low = bound("min")) value = std::max(value, *low);
            if (const auto high = bound("max")) value = std::min(value, *high);
            parameters_[name] = value;
        }
    }

    /// A number, or the value of the parameter that is named.
    [[nodiscard]] double dynamic(const JsonMember& member) const {
        const std::string type = member.at("type").text();
        const JsonMember value = member.at("value");
        if (type == "f64") return value.number(-largest, largest);
        if (type != "dynamic") throw member.at("type").wrong("\"f64\" or \"dynamic\"");
        if (!value.value().is_string()) throw value.wrong("the name of a parameter; formulas are not read");
        const auto found = parameters_.find(value.text());
        if (found == parameters_.end())
            throw value.wrong("a parameter that user_parameter_definitions has; formulas are not read");
        return found->second;
    }

    [[nodiscard]] Vec3 dynamic_vector(const JsonMember& member) const {
        return {dynamic(member.at("x")), dynamic(member.at("y")), dynamic(member.at("z"))};
    }

    void read_transform() {
        const JsonMember transform = root_.at("pattern_transform");
        const JsonMember geometry = transform.at("geometric_transforms");
        pattern_.scale = dynamic_vector(geometry.at("scale"));
        pattern_.translate = dynamic_vector(geometry.at("translate"));
        pattern_.turn_deg = dynamic(geometry.at("rotation"));
        pattern_.intensity_factor = dynamic(transform.at("intensity_factor"));
        pattern_.speed = dynamic(transform.at("playback_speed"));
        if (!(pattern_.speed >= 1e-3 && pattern_.speed <= 1e3))
            throw transform.at("playback_speed").wrong("from 0.001 to 1000");
    }

    static bool is_step(const JsonMember& member) {
        const JsonMember name = member.at("transition").at("name");
        if (name.text() != "linear" && name.text() != "step") throw name.wrong("\"linear\" or \"step\"");
        return name.text() == "step";
    }

    [[nodiscard]] Brush brush_of(const JsonMember& member) const {
        const JsonMember params = member.at("params");
        const std::string name = member.at("name").text();
        Brush brush;
        brush.am_hz = dynamic(params.at("am_freq"));
        if (name == "circle") {
            brush.half_x_mm = brush.half_y_mm = dynamic(params.at("radius"));
        } else if (name == "line") {
            // The designer takes the length for the half-axis, and draws a line without thickness.
            brush.line = true;
            brush.half_x_mm = dynamic(params.at("length"));
            brush.turn_deg = dynamic(params.at("rotation"));
        } else {
            throw member.at("name").wrong("\"circle\" or \"line\"");
        }
        return brush;
    }

    [[nodiscard]] double intensity_of(const JsonMember& member) const {
        if (member.at("name").text() != "constant")
            throw member.at("name").wrong("\"constant\"; a path cannot have a random intensity");
        return dynamic(member.at("params").at("value"));
    }

    void refuse_jumps(const JsonMember& frame) const {
        const auto jumps = frame.find("cjumps");
        if (!jumps) return;
        for (const JsonMember& jump : jumps->list()) {
            const JsonMember condition = jump.at("condition");
            const auto found = parameters_.find(condition.at("parameter").text());
            if (found == parameters_.end()) continue;  // such a condition never holds
            const double value = condition.at("value").number(-largest, largest);
            const std::string name = condition.at("operator").at("name").text();
            const bool holds = name == "lt"      ? found->second < value
                               : name == "lt_eq" ? found->second <= value
                               : name == "gt"    ? found->second > value
                               : name == "gt_eq" ? found->second >= value
                                                 : throw condition.at("operator").wrong("lt, lt_eq, gt or gt_eq");
            if (holds)
                throw condition.wrong(
                    "a condition that does not hold for the parameters' defaults; a path cannot jump, so remove it");
        }
    }

    void add(const JsonMember& frame) {
        const double time = time_of(frame);
        const std::string type = frame.at("type").text();
        const FrameKind kind = type == "standard" ? FrameKind::standard
                               : type == "pause"  ? FrameKind::pause
                               : type == "stop"   ? FrameKind::stop
                                                  : throw frame.at("type").wrong("standard, pause or stop");
        if (stopped_) return;  // nothing after a stop is played
        stopped_ = kind == FrameKind::stop;
        pattern_.frames.emplace_back(time, kind);
        if (kind == FrameKind::standard) {
            const JsonMember coords = frame.at("coords");
            const JsonMember xyz = coords.at("coords");
            const auto axis = [&](const char* key) { return xyz.at(key).number(-largest, largest); };
            pattern_.places.push_back({time, {axis("x"), axis("y"), axis("z")}, is_step(coords)});
        } else if (!pattern_.places.empty()) {
            // Holds the place until now: a step from the frame before to the same place.
            pattern_.places.push_back({time, pattern_.places.back().value, pattern_.places.back().step});
        }
        if (stopped_) return;
        refuse_jumps(frame);
        const auto present = [&](const char* key) {
            const auto found = frame.find(key);
            return found && !found->value().is_null() ? found : std::nullopt;
        };
        if (const auto brush = present("brush"))
            pattern_.brushes.push_back({time, brush_of(brush->at("brush")), is_step(*brush)});
        if (const auto intensity = present("intensity"))
            pattern_.intensities.push_back({time, intensity_of(intensity->at("intensity")), is_step(*intensity)});
    }

    const JsonMember& root_;
    Keyframes pattern_;
    std::map<std::string, double> parameters_;
    bool stopped_ = false;
};

/// The two neighbours of a time and how far it is from the first to the second; the same one twice at either end.
/// @param after  what is around this time goes on until `time`: of a step the value that it ends, not that it begins
template <class Value>
std::tuple<Value, Value, double> around(const std::vector<Keyed<Value>>& keys, double after, double time,
                                        const Value& before) {
    const auto next = std::upper_bound(keys.begin(), keys.end(), after,
                                       [](double t, const Keyed<Value>& key) { return t < key.time_ms; });
    if (next == keys.begin()) return {before, before, 0.0};
    const Keyed<Value>& last = *(next - 1);
    if (next == keys.end() || last.step) return {last.value, last.value, 0.0};
    return {last.value, next->value, (time - last.time_ms) / (next->time_ms - last.time_ms)};
}

Brush blend(const Brush& a, const Brush& b, double part) {
    if (a.line != b.line) return a;
    const auto mix = [part](double x, double y) { return x + part * (y - x); };
    return {a.line, mix(a.half_x_mm, b.half_x_mm), mix(a.half_y_mm, b.half_y_mm), mix(a.turn_deg, b.turn_deg),
            mix(a.am_hz, b.am_hz)};
}

Vec3 turned(Vec3 p, double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    return {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
}

/// What key frames say of a moment.
struct Moment {
    Vec3 place;  ///< mm, where the pattern's transform has brought it
    Brush brush;
    double intensity = 0.0;
};

/// @param after  as around() has it
Moment moment_of(const Keyframes& pattern, double after_ms, double time_ms) {
    const auto [place, next_place, place_part] = around(pattern.places, after_ms, time_ms, Vec3{});
    const Vec3 at = place + place_part * (next_place - place);
    const auto [a, b, brush_part] = around(pattern.brushes, after_ms, time_ms, Brush{});
    const auto [from, to, part] = around(pattern.intensities, after_ms, time_ms, 1.0);
    return {turned({at.x * pattern.scale.x, at.y * pattern.scale.y, at.z * pattern.scale.z}, pattern.turn_deg) +
                pattern.translate,
            blend(a, b, brush_part), pattern.intensity_factor * (from + part * (to - from))};
}

bool same(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max({1.0, std::abs(a), std::abs(b)}); }
bool same(const Moment& a, const Moment& b) {
    return same(a.place.x, b.place.x) && same(a.place.y, b.place.y) && same(a.place.z, b.place.z) &&
           same(a.brush.half_x_mm, b.brush.half_x_mm) && same(a.intensity, b.intensity);
}

/// @param played_s  since the pattern began, in real time: brushes turn and pulsate in it, whatever the speed is
Focus focus_at(const Keyframes& pattern, double pattern_ms, double played_s) {
    const auto [place, brush, intensity] = moment_of(pattern, pattern_ms, pattern_ms);
    const double turns = 2.0 * std::numbers::pi * adaptics_brush_hz * played_s;
    const Vec3 at =
        place + turned({brush.half_x_mm * std::cos(turns), brush.half_y_mm * std::sin(turns), 0.0}, brush.turn_deg);
    const double pulsation = 0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * brush.am_hz * played_s);
    return {from_mm(at.x, at.y, at.z), intensity * pulsation};
}

}  // namespace

Path path_from_adaptics(std::string_view text, const std::string& where, double carrier_hz, std::size_t samples) {
    const nlohmann::ordered_json document = parse_json(text, where);
    const JsonMember root(document, where);
    const Keyframes pattern = PatternReader(root).read();
    const double begin_ms = pattern.frames.front().first;
    const double length_s = (pattern.frames.back().first - begin_ms) * 1e-3 / pattern.speed;
    if (samples == 0) throw bad_argument("points", "found 0, expected at least 1 sample of the pattern", {"points"});
    const double each_s = length_s / static_cast<double>(samples);
    if (each_s * carrier_hz < 1.0)
        throw impossible("points", fmt::format("{} samples of a pattern of {:.6g} s last less than a carrier period "
                                               "each; take at most {:.0f}",
                                               samples, length_s, std::floor(length_s * carrier_hz)));
    std::vector<Stretch> stretches;
    for (std::size_t i = 0; i < samples; ++i) {
        const double played_s = each_s * (static_cast<double>(i) + 0.5);
        const Focus focus = focus_at(pattern, begin_ms + played_s * pattern.speed * 1e3, played_s);
        if (!(focus.amplitude >= 0.0 && focus.amplitude <= 1.0))
            throw bad_input(where, fmt::format("an intensity of {:.6g} after {:.6g} s; expected 0 to 1, with "
                                               "intensity_factor",
                                               focus.amplitude, played_s));
        const double periods = each_s * carrier_hz;
        // A focus that stays is one stretch.
        const std::vector<Focus> foci = focus.amplitude > 0.0 ? std::vector{focus} : std::vector<Focus>{};
        if (!stretches.empty() && stretches.back().foci == foci)
            stretches.back().periods += periods;
        else
            stretches.push_back({foci, periods});
    }
    return path_of(stretches);
}

AdapticsFrames frames_from_adaptics(std::string_view text, const std::string& where) {
    const nlohmann::ordered_json document = parse_json(text, where);
    const JsonMember root(document, where);
    const Keyframes pattern = PatternReader(root).read();
    const auto cannot = [&](const std::string& why) {
        return bad_input(where, fmt::format("key frames of a shape cannot say it: {}", why));
    };
    std::vector<double> times_ms;
    for (const auto& [time_ms, kind] : pattern.frames)
        if (times_ms.empty() || time_ms > times_ms.back()) times_ms.push_back(time_ms);
    std::vector<Moment> moments;
    double widest_mm = 0.0, narrowest_mm = largest;
    for (const double time_ms : times_ms) {
        const Moment& now = moments.emplace_back(moment_of(pattern, time_ms, time_ms));
        if (now.brush.line) throw cannot(fmt::format("at {:g} ms its brush is a line", time_ms));
        if (now.brush.am_hz != moments.front().brush.am_hz)
            throw cannot(fmt::format("its strength beats {:g} times a second at first and {:g} times at {:g} ms",
                                     moments.front().brush.am_hz, now.brush.am_hz, time_ms));
        if (!(now.intensity >= 0.0 && now.intensity <= 1.0))
            throw cannot(fmt::format("its intensity is {:g} at {:g} ms, and not from 0 to 1", now.intensity, time_ms));
        widest_mm = std::max(widest_mm, now.brush.half_x_mm);
        narrowest_mm = std::min(narrowest_mm, now.brush.half_x_mm);
    }
    if (narrowest_mm < 0.0 || (narrowest_mm == 0.0 && widest_mm > 0.0))
        throw cannot(fmt::format("its brush is a circle of {:g} mm at one time, and none at another", widest_mm));
    AdapticsFrames found;
    if (widest_mm > 0.0) found.diameter_m = 2.0 * widest_mm * millimetre;
    const Vec3 first = moments.front().place;
    found.centre = from_mm(first.x, first.y, first.z);
    for (std::size_t i = 0; i < moments.size(); ++i) {
        const double time_ms = times_ms[i];
        const auto& [place, brush, intensity] = moments[i];
        KeyFrame frame;
        frame.time_s = (time_ms - times_ms.front()) * 1e-3 / pattern.speed;
        frame.move = from_mm(place.x - first.x, place.y - first.y, place.z - first.z);
        if (widest_mm > 0.0) frame.scale = brush.half_x_mm / widest_mm;
        frame.amplitude = intensity;
        frame.am_hz = brush.am_hz;
        if (i + 1 < moments.size()) {
            const Moment end = moment_of(pattern, time_ms, times_ms[i + 1]);
            const bool stays = same(end, moments[i]);
            if (!stays && !same(end, moments[i + 1]))
                throw cannot(fmt::format("from {:g} ms on one thing changes evenly and another in a step", time_ms));
            if (stays && !same(moments[i], moments[i + 1])) frame.ease = Ease::step;
        }
        found.frames.push_back(frame);
    }
    return found;
}

}  // namespace haptogram
