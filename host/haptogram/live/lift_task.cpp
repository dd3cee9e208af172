// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/lift_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "haptogram/base/error.hpp"

namespace haptogram::live {
namespace {

constexpr double lifted_radius_m = 8e-3, lifted_length_m = 60e-3;  ///< of a finger
constexpr double floor_m = 0.1, room_m = 0.1;                      ///< half of the room's width
constexpr double above_middle_m = 3e-3;  ///< so high it is grasped, so that it hangs from the fingers
constexpr double blind_width_m = 15e-3;  ///< from the middle, of half of the smallest cube
constexpr double rise_m = 65e-3;         ///< higher than asked for, as a person would

/// The hand: two fingers that point at each other.
struct Pinch {
    Vec3 middle;                    ///< between the fingertips, when both are equally far out
    double angle = 0.0;             ///< of the way from the left finger to the right one, about z, from x
    std::array<double, 2> out_m{};  ///< of each fingertip from the middle
    [[nodiscard]] Vec3 way(std::size_t side) const {
        const double sign = side == 0 ? -1.0 : 1.0;
        return sign * Vec3{std::cos(angle), std::sin(angle), 0.0};
    }
    [[nodiscard]] std::vector<RoundedBody> bodies() const {
        std::vector<RoundedBody> fingers;
        for (const std::size_t side : {0U, 1U}) {
            const Vec3 along = way(side);
            fingers.push_back({middle + (out_m.at(side) + lifted_radius_m + 0.5 * lifted_length_m) * along,
                               0.5 * lifted_length_m * along,
                               {},
                               lifted_radius_m});
        }
        return fingers;
    }
};

/// What the hand does next, shot by shot.
class Lifter {
public:
    Lifter(const LiftOptions& options, Vec3 cube) : options_(options) {
        pinch_.middle = cube + Vec3{0, 0, above_middle_m};
        if (options.seen)
            pinch_.angle = std::remainder(options.turn_deg * std::numbers::pi / 180.0, 0.5 * std::numbers::pi);
        else
            pinch_.middle.x = pinch_.middle.y = 0.0;
        pinch_.out_m = {options.guess_m, options.guess_m};
    }
    [[nodiscard]] const Pinch& pinch() const { return pinch_; }

    /// @param touches  normals into the faces that each finger feels, or sees that it touches
    void step(double seconds, const std::array<std::optional<Vec3>, 2>& touches) {
        for (const std::size_t side : {0U, 1U})
            if (touches.at(side) && !met_.at(side)) meet(side, *touches.at(side));
        if (!(met_[0] && met_[1])) {
            for (const std::size_t side : {0U, 1U})
                if (!met_.at(side)) close(side, seconds);
        } else if (squeezed_m_ < options_.squeeze_m) {
            const double more = std::min(options_.closing_m_s * seconds, options_.squeeze_m - squeezed_m_);
            squeezed_m_ += more;
            for (double& out : pinch_.out_m) out -= more;
        } else if (risen_m_ < rise_m) {
            const double more = std::min(options_.lifting_m_s * seconds, rise_m - risen_m_);
            risen_m_ += more;
            pinch_.middle.z += more;
        }
    }
    [[nodiscard]] bool risen() const { return risen_m_ >= rise_m; }

private:
    [[nodiscard]] bool blind() const { return options_.felt == Felt::nothing && !options_.seen; }

    void close(std::size_t side, double seconds) {
        double& out = pinch_.out_m.at(side);
        out -= options_.closing_m_s * seconds;
        if (blind() && out <= blind_width_m) met_.at(side) = true;
    }

    void meet(std::size_t side, Vec3 inward) {
        if (blind()) return;
        met_.at(side) = true;
        if (options_.seen || options_.felt != Felt::dynamic || met_.at(1 - side)) return;
        // The hand turns about the fingertip that touches, until its fingers are square to the face.
        const Vec3 tip = pinch_.middle + pinch_.out_m.at(side) * pinch_.way(side);
        const Vec3 towards = side == 0 ? inward : -1.0 * inward;
        pinch_.angle = std::atan2(towards.y, towards.x);
        pinch_.middle = tip - pinch_.out_m.at(side) * pinch_.way(side);
    }

    LiftOptions options_;
    Pinch pinch_;
    std::array<bool, 2> met_{};
    double squeezed_m_ = 0.0, risen_m_ = 0.0;
};

LiftOptions placed(LiftOptions options) {
    const auto positive = [](const char* name, double value) {
        if (!(value > 0.0)) throw bad_argument(name, fmt::format("found {}, expected more than 0", value));
    };
    positive("edge", options.edge_m);
    positive("lift", options.lift_m);
    positive("hold", options.hold_s);
    positive("limit of time", options.at_most_s);
    positive("speed", std::min(options.closing_m_s, options.lifting_m_s));
    SceneOptions& scene = options.fingers.scene;
    scene.kind = "cube";
    scene.size_m = scene.height_m = options.edge_m;
    scene.pose = pose_of({options.x_m, options.y_m, floor_m + 0.5 * options.edge_m}, {0, 0, options.turn_deg});
    if (!(scene.mass_kg > 0.0)) throw bad_argument("mass", "a cube that stays where it is cannot be lifted");
    scene.world.low = {-room_m, -room_m, floor_m};
    scene.world.high = {room_m, room_m, floor_m + 0.2};
    options.fingers.ring.motion = options.felt == Felt::still ? FocusMotion::still : FocusMotion::revolving;
    options.fingers.rate_hz = options.cameras.rate_hz;
    options.cameras.target = {0, 0, floor_m + 0.5 * options.edge_m + 0.5 * rise_m};
    return options;
}

/// Which faces the fingers feel by rings, or, when they feel nothing, are seen to touch.
std::array<std::optional<Vec3>, 2> touches_of(const LiftOptions& options, const Pinch& pinch, const ShotReport& report,
                                              const TouchScene& scene) {
    std::array<std::optional<Vec3>, 2> touches;
    const auto note = [&](Vec3 place, Vec3 normal) {  // of either sign; a finger comes from outside
        const std::size_t side = dot(place - pinch.middle, pinch.way(1)) < 0.0 ? 0 : 1;
        touches.at(side) = dot(normal, pinch.way(side)) < 0.0 ? normal : -1.0 * normal;
    };
    if (options.felt == Felt::nothing) {
        if (options.seen)
            for (const SceneFinger& finger : scene.fingers()) note(finger.surface, finger.inward);
    } else {
        for (const Ellipse& section : report.sections) note(section.centre, section.normal);
    }
    return touches;
}

}  // namespace

void draw_cube(LiftOptions& options, std::mt19937_64& random) {
    const auto whole = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    const bool seen = options.seen;
    options.edge_m = 1e-3 * whole(30, 50);
    options.x_m = 1e-3 * (seen ? whole(-30, 30) : whole(-15, 15));
    options.y_m = 1e-3 * (seen ? whole(-30, 30) : whole(-5, 5));
    options.turn_deg = seen ? whole(-45, 45) : whole(-20, 20);
}

LiftReport lift(const Array& array, const LiftOptions& given, const std::function<void(const ShotReport&)>& told) {
    const LiftOptions options = placed(given);
    ShotRings rings(array, array.carrier_hz, options.fingers);
    const std::vector<DepthCamera> cameras = cameras_of(options.cameras);
    const Vec3 begin = rings.scene().object().origin;
    Lifter hand(options, begin);
    const double step_s = 1.0 / options.cameras.rate_hz;
    LiftReport report;
    double lowest = HUGE_VAL, up_since = -1.0, force_sum = 0.0;
    std::uint64_t held = 0;
    std::optional<double> touched;
    for (; static_cast<double>(report.shots) * step_s < options.at_most_s && !report.done; ++report.shots) {
        const double time_s = static_cast<double>(report.shots) * step_s;
        const DepthShot shot = render_shot(hand.pinch().bodies(), cameras, options.cameras.noise, report.shots, time_s);
        ShotReport now;
        now.number = report.shots;
        now.time_s = time_s;
        (void)rings.take(cameras, shot, now);
        if (told) told(now);
        if (now.fingers > 0) {
            if (!touched) touched = time_s;
            ++report.touched_shots;
            if (options.felt != Felt::nothing && !now.sections.empty()) ++report.felt_shots;
        }
        const double balance = rings.scene().energy() - rings.scene().work();
        lowest = std::min(lowest, balance);
        report.energy_made_j = std::max(report.energy_made_j, balance - lowest);
        report.most_force_n = std::max(report.most_force_n, now.force_n);
        const double lifted = rings.scene().object().origin.z - begin.z;
        report.lifted_m = std::max(report.lifted_m, lifted);
        if (lifted < options.lift_m) {
            up_since = -1.0;
        } else {
            if (up_since < 0.0) up_since = time_s;
            force_sum += now.force_n;
            ++held;
            report.done = time_s - up_since >= options.hold_s;
        }
        if (touched) report.time_s = time_s - *touched;
        hand.step(step_s, touches_of(options, hand.pinch(), now, rings.scene()));
    }
    report.first_touch_s = touched.value_or(0.0);
    report.mean_force_n = held > 0 ? force_sum / static_cast<double>(held) : 0.0;
    report.counts = rings.counts();
    return report;
}

}  // namespace haptogram::live
