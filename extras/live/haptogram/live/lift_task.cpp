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
    [[nodiscard]] FingerForm form(std::size_t side) const {
        return {middle + (out_m.at(side) + lifted_radius_m) * way(side), way(side), lifted_radius_m};
    }
    [[nodiscard]] std::vector<RoundedBody> bodies() const {
        std::vector<RoundedBody> fingers;
        for (const std::size_t side : {0U, 1U}) {
            const FingerForm finger = form(side);
            const Vec3 half = 0.5 * lifted_length_m * finger.to_hand;
            fingers.push_back({finger.tip + half, half, {}, lifted_radius_m});
        }
        return fingers;
    }
};

/// What one finger gets to know.
struct Touched {
    bool seen = false;         ///< that it is in the cube
    std::optional<Vec3> felt;  ///< where on it something is felt
};
using Touches = std::array<Touched, 2>;

/// What the hand does next, shot by shot.
class Lifter {
public:
    Lifter(const LiftOptions& options, Vec3 cube) : options_(options) {
        start_.middle = cube + Vec3{0, 0, above_middle_m};
        if (options.seen)
            start_.angle = std::remainder(options.turn_deg * std::numbers::pi / 180.0, 0.5 * std::numbers::pi);
        else
            start_.middle.x = start_.middle.y = 0.0;
        start_.out_m = {options.guess_m, options.guess_m};
        pinch_ = start_;
    }
    [[nodiscard]] const Pinch& pinch() const { return pinch_; }
    [[nodiscard]] std::size_t tries() const { return tries_; }

    /// @param lifted_m  of the cube, which is seen as soon as it is above the wall
    void step(double seconds, const Touches& touches, double lifted_m) {
        for (const std::size_t side : {0U, 1U})
            if ((touches.at(side).felt || touches.at(side).seen) && !met_.at(side)) meet(side);
        if (looking_) {
            look(touches.at(*looking_).felt);
        } else if (!(met_[0] && met_[1])) {
            for (const std::size_t side : {0U, 1U})
                if (!met_.at(side)) close(side, seconds);
            if (pinch_.out_m[0] + pinch_.out_m[1] <= 0.0) again();
        } else if (squeezed_m_ < options_.squeeze_m) {
            const double more = std::min(options_.closing_m_s * seconds, options_.squeeze_m - squeezed_m_);
            squeezed_m_ += more;
            for (double& out : pinch_.out_m) out -= more;
        } else if (risen_m_ < rise_m) {
            const double more = std::min(options_.lifting_m_s * seconds, rise_m - risen_m_);
            risen_m_ += more;
            pinch_.middle.z += more;
        } else if (lifted_m < options_.lift_m) {
            again();
        }
    }

private:
    [[nodiscard]] bool blind() const { return options_.felt == Felt::nothing && !options_.seen; }

    void close(std::size_t side, double seconds) {
        double& out = pinch_.out_m.at(side);
        out -= options_.closing_m_s * seconds;
        if (blind() && out <= blind_width_m) met_.at(side) = true;
    }

    void meet(std::size_t side) {
        met_.at(side) = true;
        if (options_.seen || met_.at(1 - side)) return;
        looking_ = side;
        looks_ = felts_ = 0;
        across_m_ = 0.0;
    }

    /// Feels once more how the face lies.
    void look(const std::optional<Vec3>& felt) {
        const std::size_t side = *looking_;
        if (felt) {
            const FingerForm finger = pinch_.form(side);
            across_m_ += dot(*felt - finger.tip, cross({0, 0, 1}, finger.to_hand));
            ++felts_;
        }
        if (++looks_ < options_.looks) return;
        looking_.reset();
        // The sound wraps the finger, so that how far to the front something is felt tells little: across it, it lies
        // on the skin.
        const FingerForm finger = pinch_.form(side);
        const double sine = felts_ > 0 ? across_m_ / static_cast<double>(felts_) / finger.radius : 0.0;
        if (!(std::abs(sine) < 1.0)) return;
        pinch_.angle -= std::asin(sine);
        pinch_.middle = finger.tip - (pinch_.out_m.at(side) + finger.radius) * pinch_.way(side);
    }

    /// Begins anew.
    void again() {
        ++tries_;
        pinch_ = start_;
        met_ = {};
        looking_.reset();
        squeezed_m_ = risen_m_ = 0.0;
    }

    LiftOptions options_;
    Pinch start_, pinch_;
    std::array<bool, 2> met_{};
    std::optional<std::size_t> looking_;  ///< the finger that stays to feel how the face lies
    std::size_t looks_ = 0, felts_ = 0, tries_ = 1;
    double across_m_ = 0.0;  ///< the sum of where it feels, across the finger
    double squeezed_m_ = 0.0, risen_m_ = 0.0;
};

LiftOptions placed(LiftOptions options) {
    const auto positive = [](const char* name, double value) {
        if (!(value > 0.0)) throw bad_argument(name, fmt::format("found {}, expected more than 0", value));
    };
    positive("edge", options.edge_m);
    positive("lift", options.lift_m);
    positive("hold", options.hold_s);
    positive("looks", static_cast<double>(options.looks));
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

/// What each finger feels of what is played, and what is seen of it.
class Person {
public:
    Person(const Array& array, const LiftOptions& options)
        : options_(options), sense_(array, options.sense), random_(options.person_seed) {}
    [[nodiscard]] Touches touches_of(const Pinch& pinch, const std::optional<Path>& path, const TouchScene& scene) {
        Touches touches;
        if (options_.seen)
            for (const SceneFinger& finger : scene.fingers())
                touches.at(dot(finger.surface - pinch.middle, pinch.way(1)) < 0.0 ? 0 : 1).seen = true;
        if (options_.felt != Felt::nothing && path)
            for (const std::size_t side : {0U, 1U})
                if (const auto sensed = sense_.feel(*path, pinch.form(side), random_))
                    touches.at(side).felt = sensed->place;
        return touches;
    }

private:
    LiftOptions options_;
    SkinSense sense_;
    std::mt19937_64 random_;
};

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
    Person person(array, options);
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
        const std::optional<Path> path = rings.take(cameras, shot, now);
        if (told) told(now);
        if (now.fingers > 0) {
            if (!touched) touched = time_s;
            ++report.touched_shots;
        }
        const Touches touches = person.touches_of(hand.pinch(), path, rings.scene());
        if (now.fingers > 0 && (touches[0].felt || touches[1].felt)) ++report.felt_shots;
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
        hand.step(step_s, touches, lifted);
    }
    report.first_touch_s = touched.value_or(0.0);
    report.mean_force_n = held > 0 ? force_sum / static_cast<double>(held) : 0.0;
    report.tries = hand.tries();
    report.counts = rings.counts();
    return report;
}

}  // namespace haptogram::live
