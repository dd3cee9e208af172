// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/robot/modes.hpp"

namespace haptogram::fusion {
namespace {

/// Follows a cue that is the larger the nearer the target is.
class Placer {
public:
    Placer(const PlaceOptions& options, double wanted_m)
        : user_(options.user), lowest_(options.start_m - options.user.search_m), wanted_(wanted_m) {}

    [[nodiscard]] double wanted() const { return wanted_; }
    [[nodiscard]] bool done() const { return phase_ == Phase::placed; }
    [[nodiscard]] bool lost() const { return phase_ == Phase::lost; }

    /// What was felt in the last period, and where the hand is now.
    /// @param change  of the cue that is noticed
    void feel(std::optional<double> cue, double change, double height, double period) {
        switch (phase_) {
            case Phase::lowering:
                wanted_ -= user_.speed_m_s * period;
                if (past_best(cue, change)) {
                    below_ = height;
                    turn(Phase::raising);
                } else if (height < lowest_) {
                    turn(Phase::lost);
                }
                return;
            case Phase::raising:
                wanted_ += user_.speed_m_s * period;
                // The hand goes on downwards for a moment. What is felt there was found out already.
                if (height > below_ && past_best(cue, change)) {
                    middle_ = (below_ + height) / 2.0;
                    turn(Phase::settling);
                }
                return;
            case Phase::settling: {
                constexpr double rate_hz = 2.0;  // slow beside the hand's own motion
                wanted_ += (middle_ - height) * rate_hz * period;
                steady_ = std::abs(height - middle_) < user_.steady_m ? steady_ + period : 0.0;
                if (steady_ >= user_.steady_s) turn(Phase::placed);
                return;
            }
            case Phase::placed:
            case Phase::lost: return;
        }
    }

private:
    enum class Phase { lowering, raising, settling, placed, lost };

    void turn(Phase phase) {
        phase_ = phase;
        best_.reset();
    }
    bool past_best(std::optional<double> cue, double change) {
        if (cue && (!best_ || *cue > *best_)) best_ = cue;
        return best_ && (!cue || *cue < *best_ - change);
    }

    PlacingUser user_;
    double lowest_;
    double wanted_, below_ = 0.0, middle_ = 0.0, steady_ = 0.0;
    std::optional<double> best_;
    Phase phase_ = Phase::lowering;
};

void require_sound(const PlaceOptions& options) {
    const auto positive = [](double value, const char* name) {
        if (!(value > 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("must be a positive number, found {:g}", value));
    };
    positive(options.target_m, "target");
    positive(options.weight_n, "weight");
    positive(options.range_m, "range");
    positive(options.longest_s, "longest");
    positive(options.user.speed_m_s, "speed");
    if (!(options.start_m > options.target_m))
        throw bad_argument("start", fmt::format("the cube starts above its target of {:g} mm, found {:g} mm",
                                                options.target_m / millimetre, options.start_m / millimetre));
}

/// What the tables do not know is said before the run, and not in the middle of it.
void require_known(const PlaceOptions& options, const perception::Tables& tables) {
    const auto require = [&](double magnitude, double frequency_hz) {
        static_cast<void>(perception::setting_for(tables, {.magnitude = magnitude, .frequency_hz = frequency_hz}));
    };
    if (options.mapping == Mapping::plane) {
        require(options.magnitude, options.plane_hz);
    } else if (options.mapping == Mapping::frequency) {
        require(options.magnitude, options.low_hz);
        require(options.magnitude, options.high_hz);
    } else {
        require(options.low_magnitude, options.magnitude_hz);
        require(options.high_magnitude, options.magnitude_hz);
    }
}

/// How far along the palm, towards the fingers, lines on it are, in the middle.
std::optional<double> place_on_palm(const std::vector<SkinLine>& lines, const std::vector<SkinRegion>& skin,
                                    const Hand& hand) {
    double sum = 0.0, length = 0.0;
    for (const SkinLine& line : lines) {
        if (skin[line.region].name != "palm") continue;
        const std::vector<SkinPoint> way = opened(line);
        for (std::size_t i = 1; i < way.size(); ++i) {
            const double part = distance(way[i - 1].position, way[i].position);
            const Vec3 middle = 0.5 * (way[i - 1].position + way[i].position);
            sum += part * dot(middle - hand.palm, hand.direction);
            length += part;
        }
    }
    if (!(length > 0.0)) return std::nullopt;
    return sum / length;
}

/// What the mapping makes of the cube's height.
struct Mapped {
    Stimulus stimulus;
    std::optional<double> line_m;
};
Mapped map(const PlaceOptions& options, Vec3 palm, const Together& together) {
    Mapped made;
    if (options.mapping == Mapping::plane) {
        const Hand hand = open_hand(palm, options.tilt_deg);
        const std::vector<SkinRegion> skin = palmar_surface(hand);
        const std::vector<SkinLine> lines = plane_lines(skin, options.target_m);
        made.line_m = place_on_palm(lines, skin, hand);
        made.stimulus.magnitude = options.magnitude;
        made.stimulus.frequency_hz = options.plane_hz;
        made.stimulus.points = spread(lines, together.places(options.plane_hz));
    } else {
        const bool by_frequency = options.mapping == Mapping::frequency;
        PalmPattern pattern;
        pattern.sign = by_frequency ? PalmSign::frequency : PalmSign::intensity;
        pattern.low = by_frequency ? options.low_hz : options.low_magnitude;
        pattern.high = by_frequency ? options.high_hz : options.high_magnitude;
        pattern.magnitude = options.magnitude;
        pattern.frequency_hz = options.magnitude_hz;
        made.stimulus = tell(pattern, nearness(palm.z - options.target_m, options.range_m), open_hand(palm, 0.0));
    }
    made.stimulus.wrench[2] = -options.weight_n;
    return made;
}

}  // namespace

Mapping mapping_of(const std::string& name) {
    for (const Mapping mapping : {Mapping::plane, Mapping::frequency, Mapping::magnitude})
        if (name == name_of(mapping)) return mapping;
    throw bad_argument("mapping", fmt::format("found \"{}\", expected G1, G2 or G3", name));
}

std::string name_of(Mapping mapping) {
    return mapping == Mapping::plane ? "G1" : mapping == Mapping::frequency ? "G2" : "G3";
}

Hand open_hand(Vec3 palm, double tilt_deg) {
    Hand hand = synthetic_hand(HandScript::press, 0.0);
    const double tilt = tilt_deg * std::numbers::pi / 180.0;
    const auto turned = [&](Vec3 v) {
        return Vec3{v.x, v.y * std::cos(tilt) + v.z * std::sin(tilt), v.z * std::cos(tilt) - v.y * std::sin(tilt)};
    };
    for (auto& finger : hand.fingers)
        for (Vec3& joint : finger->joints) joint = palm + turned(joint - hand.palm);
    hand.direction = turned(hand.direction);
    hand.normal = turned(hand.normal);
    hand.palm = palm;
    return hand;
}

Placed place_cube(const PlaceOptions& options, const Array& array, const perception::Tables& tables,
                  const SharedClock& clock, const Progress& progress) {
    require_sound(options);
    require_known(options, tables);
    // The hand holds the cube from the beginning on: it wants to be higher than the weight lets it be.
    const auto placer =
        std::make_shared<Placer>(options, options.start_m + options.weight_n / options.user.hand.stiffness_n_m);
    TogetherOptions beside;
    beside.robot_centre = options.robot_centre;
    beside.geometry = options.geometry;
    beside.plant = options.plant;
    beside.controller = options.controller;
    beside.start.z() = options.start_m - options.robot_centre.z;
    beside.user = robot::impedance_user(options.user.hand, [placer, &options](double) {
        return robot::Vector3(0.0, 0.0, placer->wanted() - options.robot_centre.z);
    });
    Together together(beside, array, tables, clock);
    const double period = clock.period_s();
    const auto periods = static_cast<long>(std::ceil(options.longest_s / period));
    Placed result;
    for (long n = 0; n < periods && !placer->done() && !placer->lost(); ++n) {
        const Mapped made = map(options, together.now().palm, together);
        Period played = together.play(made.stimulus);
        Frame& frame = played.frame;
        result.points += frame.points.size() + frame.silent;
        result.silent += frame.silent;
        if (result.why.empty()) result.why = frame.why;
        const bool felt = !frame.points.empty();
        const double height = played.palm.z;
        std::optional<double> cue;
        if (felt && options.mapping == Mapping::frequency) cue = frame.frequency_hz;
        if (felt && options.mapping == Mapping::magnitude) cue = frame.magnitude;
        if (felt && made.line_m) cue = -std::abs(*made.line_m);
        const double change = options.mapping == Mapping::plane ? options.user.least_shift_m
                                                                : options.user.least_change * cue.value_or(0.0);
        placer->feel(cue, change, height, period);
        result.rows.push_back({static_cast<double>(n + 1) * period, height, placer->wanted(),
                               felt ? frame.frequency_hz : 0.0, felt ? frame.magnitude : 0.0, made.line_m,
                               made.stimulus.wrench[2], played.user.z(), played.measured[2]});
        result.frames.push_back(std::move(frame));
        progress(static_cast<double>(n + 1) / static_cast<double>(periods), "placing");
    }
    result.events = together.events();
    result.least_tension_n = together.least_tension_n();
    result.time_s = result.rows.back().time_s;
    result.placed = placer->done() && result.events.empty();
    if (!result.placed) return result;
    result.error_m = result.rows.back().height_m - options.target_m;
    const auto held = std::min<std::size_t>(result.rows.size(),
                                            static_cast<std::size_t>(std::lround(options.user.steady_s / period)));
    for (std::size_t i = result.rows.size() - held; i < result.rows.size(); ++i) {
        result.weight_n += result.rows[i].user_n / static_cast<double>(held);
        result.measured_n += result.rows[i].measured_n / static_cast<double>(held);
    }
    return result;
}

std::string to_csv(const Placed& placed) {
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "time_s,height_mm,wanted_mm,frequency_hz,magnitude,line_mm,scene_n,user_n,measured_n\n");
    for (const PlaceRow& row : placed.rows)
        fmt::format_to(out, "{:.4f},{:.4f},{:.4f},{:.4f},{:.5f},{},{:.4f},{:.4f},{:.4f}\n", row.time_s,
                       row.height_m / millimetre, row.wanted_m / millimetre, row.frequency_hz, row.magnitude,
                       row.line_m ? fmt::format("{:.4f}", *row.line_m / millimetre) : "", row.scene_n, row.user_n,
                       row.measured_n);
    return fmt::to_string(text);
}

}  // namespace haptogram::fusion
