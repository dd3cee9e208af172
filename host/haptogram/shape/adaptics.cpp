// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/adaptics.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "haptogram/base/error.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/adaptics_pattern.hpp"
#include "haptogram/shape/draw.hpp"

namespace haptogram::adaptics {
namespace {

class PatternReader {
public:
    PatternReader(const JsonMember& root, const Parameters& given) : root_(root), given_(given) {}

    Pattern read() {
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
        require_use_of_given();
        if (pattern_.frames.empty() || pattern_.frames.front().second != FrameKind::standard)
            throw root_.at("keyframes").wrong("a list that begins with a standard key frame, which has a place");
        const double begin_ms = pattern_.frames.front().first;
        if (pattern_.frames.back().first <= begin_ms)
            pattern_.frames.emplace_back(begin_ms + template_ms(), FrameKind::stop);
        return std::move(pattern_);
    }

private:
    static double time_of(const JsonMember& frame) { return frame.at("time").number(0.0, largest); }

    /// How long a pattern of one key frame plays.
    [[nodiscard]] double template_ms() const {
        const double beats = pattern_.brushes.empty() ? 0.0 : pattern_.brushes.back().value.am_hz / adaptics_brush_hz;
        double turns = 1.0;
        while (turns < adaptics_brush_hz && std::abs(turns * beats - std::round(turns * beats)) > 1e-9) ++turns;
        return turns * pattern_.speed * 1e3 / adaptics_brush_hz;
    }

    void read_parameters() {
        parameters_ = given_;
        const auto definitions = root_.find("user_parameter_definitions");
        if (!definitions) return;
        for (const auto& [name, unused] : definitions->object().items()) {
            const JsonMember definition = definitions->at(name);
            const auto bound = [&](const char* key, double none) {
                const auto found = definition.find(key);
                return found && !found->value().is_null() ? found->number(-largest, largest) : none;
            };
            const double low = bound("min", -largest), high = std::max(low, bound("max", largest));
            const double standard = std::clamp(definition.at("default").number(-largest, largest), low, high);
            const double value = parameters_.try_emplace(name, standard).first->second;
            if (!(value >= low && value <= high))
                throw impossible("set", fmt::format("found {}={}, expected {} to {}, which is the pattern's range; set "
                                                    "another value",
                                                    name, value, low, high));
            used_.insert(name);
        }
    }

    void require_use_of_given() const {
        for (const auto& [name, unused] : given_)
            if (!used_.contains(name))
                throw impossible("set",
                                 fmt::format("found the parameter {}, expected one of the pattern's: {}; correct "
                                             "the name",
                                             shown(name), used_.empty() ? "it has none" : joined()));
    }
    [[nodiscard]] std::string joined() const { return fmt::format("{}", fmt::join(used_, ", ")); }

    /// A parameter that is nowhere defined is 0, as in the designer.
    double parameter(const std::string& name) {
        used_.insert(name);
        return parameters_.try_emplace(name, 0.0).first->second;
    }

    double formula(const JsonMember& member) {
        const std::string type = lower_case(member.at("type").text());
        const JsonMember value = member.at("value");
        if (type == "constant") return value.number(-largest, largest);
        if (type == "parameter") return parameter(value.text());
        const std::vector<JsonMember> sides = value.list();
        if (sides.size() != 2) throw value.wrong("the two sides of the formula");
        const double left = formula(sides[0]), right = formula(sides[1]);
        if (type == "add") return left + right;
        if (type == "subtract") return left - right;
        if (type == "multiply") return left * right;
        if (type == "divide") return left / right;
        throw member.at("type").wrong("constant, parameter, add, subtract, multiply or divide");
    }

    /// A number, a parameter's value, or what a formula of them comes to.
    double dynamic(const JsonMember& member) {
        const std::string type = member.at("type").text();
        const JsonMember value = member.at("value");
        if (type == "f64") return value.number(-largest, largest);
        if (type == "param" || type == "dynamic") return parameter(value.text());
        if (type != "formula") throw member.at("type").wrong("f64, param or formula");
        const double result = formula(value);
        if (!(std::abs(result) <= largest))
            throw value.wrong(fmt::format("a formula that comes to at most {}, not to {}", largest, result));
        return result;
    }

    Vec3 dynamic_vector(const JsonMember& member) {
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

    Brush brush_of(const JsonMember& member) {
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

    double intensity_of(const JsonMember& member) {
        if (member.at("name").text() != "constant")
            throw member.at("name").wrong("\"constant\"; a path cannot have a random intensity");
        return dynamic(member.at("params").at("value"));
    }

    /// Whether the pattern goes back to its beginning from here.
    [[nodiscard]] bool jumps(const JsonMember& frame) const {
        const auto jumps = frame.find("cjumps");
        if (!jumps || time_of(frame) == 0.0) return false;  // the designer does not look at jumps of the beginning
        for (const JsonMember& jump : jumps->list()) {
            const JsonMember condition = jump.at("condition");
            const auto found = parameters_.find(condition.at("parameter").text());
            const double value = condition.at("value").number(-largest, largest);
            const std::string name = condition.at("operator").at("name").text();
            if (found == parameters_.end()) continue;  // such a condition never holds
            const bool holds = name == "lt"      ? found->second < value
                               : name == "lt_eq" ? found->second <= value
                               : name == "gt"    ? found->second > value
                               : name == "gt_eq" ? found->second >= value
                                                 : throw condition.at("operator").wrong("lt, lt_eq, gt or gt_eq");
            if (!holds) continue;
            const JsonMember to = jump.at("jump_to");
            if (to.number(0.0, largest) != 0.0)
                throw to.wrong(
                    "0, the beginning, as its condition holds and a path can only repeat; set the parameter "
                    "so that it does not hold, or remove the jump");
            return true;
        }
        return false;
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
        const auto present = [&](const char* key) {
            const auto found = frame.find(key);
            return found && !found->value().is_null() ? found : std::nullopt;
        };
        if (const auto brush = present("brush"))
            pattern_.brushes.push_back({time, brush_of(brush->at("brush")), is_step(*brush)});
        if (const auto intensity = present("intensity"))
            pattern_.intensities.push_back({time, intensity_of(intensity->at("intensity")), is_step(*intensity)});
        stopped_ = jumps(frame);
    }

    const JsonMember& root_;
    Pattern pattern_;
    const Parameters& given_;
    Parameters parameters_;
    std::set<std::string> used_;
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

}  // namespace

Pattern read_pattern(std::string_view text, const std::string& where, const Parameters& parameters) {
    const nlohmann::ordered_json document = parse_json(text, where);
    return PatternReader(JsonMember(document, where), parameters).read();
}

Moment moment_of(const Pattern& pattern, double after_ms, double time_ms) {
    const auto [place, next_place, place_part] = around(pattern.places, after_ms, time_ms, Vec3{});
    const Vec3 at = place + place_part * (next_place - place);
    const auto [a, b, brush_part] = around(pattern.brushes, after_ms, time_ms, Brush{});
    const auto [from, to, part] = around(pattern.intensities, after_ms, time_ms, 1.0);
    return {turned({at.x * pattern.scale.x, at.y * pattern.scale.y, at.z * pattern.scale.z}, pattern.turn_deg) +
                pattern.translate,
            blend(a, b, brush_part), pattern.intensity_factor * (from + part * (to - from))};
}

namespace {

/// @param played_s  since the pattern began, in real time: brushes turn and pulsate in it, whatever the speed is
Focus focus_at(const Pattern& pattern, double pattern_ms, double played_s) {
    const auto [place, brush, intensity] = moment_of(pattern, pattern_ms, pattern_ms);
    const double turns = 2.0 * std::numbers::pi * adaptics_brush_hz * played_s;
    const Vec3 at =
        place + turned({brush.half_x_mm * std::cos(turns), brush.half_y_mm * std::sin(turns), 0.0}, brush.turn_deg);
    const double pulsation = 0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * brush.am_hz * played_s);
    return {from_mm(at.x, at.y, at.z), intensity * pulsation};
}

}  // namespace
}  // namespace haptogram::adaptics

namespace haptogram {

Path path_from_adaptics(std::string_view text, const std::string& where, double carrier_hz, std::size_t samples,
                        const Parameters& parameters) {
    const adaptics::Pattern pattern = adaptics::read_pattern(text, where, parameters);
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
        const Focus focus = adaptics::focus_at(pattern, begin_ms + played_s * pattern.speed * 1e3, played_s);
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

}  // namespace haptogram
