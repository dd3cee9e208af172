// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/tasks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/perception/felt.hpp"

namespace haptogram::live {
namespace {

using std::numbers::pi;

constexpr double patch_m = 2.5e-3;    ///< of the patches
constexpr double behind_m = 12.5e-3;  ///< of the finger behind its round end

Vec3 beside(Vec3 a) { return unit(cross(a, std::abs(a.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})); }

}  // namespace

SkinSense::SkinSense(const Array& array, const SenseOptions& options)
    : carrier_hz_(array.carrier_hz), options_(options), weigher_(array), tables_(perception::find_tables()) {
    (void)perception::threshold_interval(tables_, perception::Region::finger, options.grip_n);
}

/// All around the round end and the first of the cylinder.
std::vector<SkinSense::Patch> SkinSense::skin_of(const FingerForm& finger) {
    const Vec3 x = beside(finger.to_hand), y = cross(finger.to_hand, x);
    std::vector<Patch> skin;
    const double round_m = 0.5 * pi * finger.radius;
    for (double way = 0.5 * patch_m; way < round_m + behind_m; way += patch_m) {
        const double angle = std::min(way / finger.radius, 0.5 * pi);
        const double radius = finger.radius * std::sin(angle);
        const double along = way < round_m ? -finger.radius * std::cos(angle) : way - round_m;
        const auto count = std::max(3, static_cast<int>(std::lround(2.0 * pi * radius / patch_m)));
        for (int i = 0; i < count; ++i) {
            const double turn = 2.0 * pi * i / count;
            skin.push_back(
                {finger.tip + along * finger.to_hand + (radius * std::cos(turn)) * x + (radius * std::sin(turn)) * y,
                 patch_m * 2.0 * pi * radius / count});
        }
    }
    return skin;
}

/// Radiation pressure of each patch, in each step.
std::vector<std::vector<double>> SkinSense::pressures(const Path& path, const std::vector<Patch>& skin,
                                                      const FingerForm& finger) {
    std::vector<Vec3> foci, places;
    for (const PathStep& step : path.steps)
        for (const Focus& focus : step.foci)
            if (std::find(foci.begin(), foci.end(), focus.position) == foci.end()) foci.push_back(focus.position);
    for (const Patch& patch : skin) places.push_back(patch.place);
    const auto full = weigher_.radiation_pa(places, foci, finger);
    if (!full) return {};
    std::vector<std::vector<double>> found(skin.size(), std::vector<double>(path.steps.size()));
    for (std::size_t j = 0; j < path.steps.size(); ++j)
        for (const Focus& focus : path.steps[j].foci) {
            const auto which =
                static_cast<std::size_t>(std::find(foci.begin(), foci.end(), focus.position) - foci.begin());
            for (std::size_t i = 0; i < skin.size(); ++i)
                found[i][j] += focus.amplitude * focus.amplitude * (*full)[which * skin.size() + i];
        }
    return found;
}

std::optional<Sensed> SkinSense::feel(const Path& path, const FingerForm& finger, std::mt19937_64& random) {
    const std::vector<Patch> skin = skin_of(finger);
    const std::vector<std::vector<double>> pressure = pressures(path, skin, finger);
    if (pressure.empty()) return {};
    const double rate_hz = carrier_hz_ / path.steps.front().periods;
    Sensed sensed{.place = {}, .over_db = -HUGE_VAL};
    Vec3 sum;
    double weights = 0.0;
    for (const Patch& here : skin) {
        std::vector<double> force(path.steps.size());
        for (std::size_t i = 0; i < skin.size(); ++i)
            if (distance(skin[i].place, here.place) < 0.5 * options_.contact_m)
                for (std::size_t j = 0; j < force.size(); ++j) force[j] += skin[i].area * pressure[i][j];
        const perception::Felt felt = perception::felt_of(perception::lines_of(force, rate_hz), tables_,
                                                          perception::Region::finger, options_.grip_n, 1);
        if (felt.lines.empty()) continue;
        const double over_db = felt.lines.front().over_db;
        sensed.over_db = std::max(sensed.over_db, over_db);
        if (over_db <= 0.0) continue;
        const double weight = here.area * (std::pow(10.0, over_db / 20.0) - 1.0);
        sum = sum + weight * here.place;
        weights += weight;
    }
    std::normal_distribution<double> normal;
    const bool is_felt = sensed.over_db + options_.threshold_sd_db * normal(random) > 0.0 && weights > 0.0;
    const double x = normal(random), y = normal(random), z = normal(random);
    if (!is_felt) return {};
    sensed.place = sum * (1.0 / weights) + options_.place_sd_m * Vec3{x, y, z};
    return sensed;
}

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

namespace {

constexpr double pointing_radius_m = 8e-3, pointing_length_m = 50e-3;  ///< of the finger
constexpr double above_m = 25e-3;    ///< the middle, from which the fingertip comes down
constexpr double deepest_m = 35e-3;  ///< below the middle, where it gives up a place
constexpr double degree = std::numbers::pi / 180.0;

SurfaceOptions placed(SurfaceOptions options) {
    if (!(std::abs(options.angle_deg) <= 60.0))
        throw bad_argument("angle", fmt::format("found {} degrees, expected -60 to 60", options.angle_deg));
    if (!(std::abs(options.height_m) <= 20e-3))
        throw bad_argument("height", fmt::format("found {} mm, expected -20 to 20", 1e3 * options.height_m));
    if (options.places < 2 || options.places > 100)
        throw bad_argument("places", fmt::format("found {}, expected 2 to 100", options.places));
    if (!(options.disc_m > 0.0 && options.lowering_m_s > 0.0 && options.press_m > 0.0 && options.key_deg > 0.0 &&
          options.key_m > 0.0 && options.at_most_s > 0.0))
        throw bad_argument("surface", "its disc, speeds, keys and limit of time must be positive");
    SceneOptions& scene = options.fingers.scene;
    scene.kind = "half-space";
    scene.mass_kg = 0.0;
    scene.pose = pose_of(options.middle + Vec3{0, 0, options.height_m}, {0, options.angle_deg, 0});
    options.fingers.rate_hz = options.cameras.rate_hz;
    options.cameras.target = options.middle;
    return options;
}

/// The finger: where it comes down, and how far its tip is.
class Explorer {
public:
    Explorer(const SurfaceOptions& options, Vec3 middle) : options_(options), middle_(middle) { begin(); }

    [[nodiscard]] std::vector<RoundedBody> bodies() const {
        const Vec3 tip{x_m_, middle_.y, middle_.z + height_m_};
        return {{tip + Vec3{0, 0, pointing_radius_m + 0.5 * pointing_length_m},
                 {0, 0, 0.5 * pointing_length_m},
                 {},
                 pointing_radius_m}};
    }
    [[nodiscard]] bool ended() const { return place_ == options_.places; }

    /// @param felt  the middle of what the finger feels
    void step(double seconds, const std::optional<Vec3>& felt) {
        if (felt) felt_now_ = true;
        if (!felt_now_) {
            height_m_ -= options_.lowering_m_s * seconds;
            if (height_m_ < -deepest_m) next();
            return;
        }
        if (pressed_m_ < options_.press_m) {
            const double more = std::min(options_.lowering_m_s * seconds, options_.press_m - pressed_m_);
            pressed_m_ += more;
            height_m_ -= more;
            return;
        }
        if (felt) felt_.push_back(*felt);
        if (++stayed_ >= options_.stay) next();
    }
    [[nodiscard]] const std::vector<Vec3>& felt() const { return felt_; }
    [[nodiscard]] std::size_t felt_places() const { return felt_places_; }

private:
    void begin() {
        const double part = static_cast<double>(place_) / static_cast<double>(options_.places - 1);
        // The outermost ring's middle must lie in the disc, too, however the surface is turned.
        x_m_ = middle_.x + 0.6 * options_.disc_m * (2.0 * part - 1.0);
        height_m_ = above_m;
        pressed_m_ = 0.0;
        stayed_ = 0;
        felt_now_ = false;
        felt_before_ = felt_.size();
    }
    void next() {
        if (felt_.size() > felt_before_) ++felt_places_;
        ++place_;
        if (!ended()) begin();
    }

    SurfaceOptions options_;
    Vec3 middle_;
    std::size_t place_ = 0, stayed_ = 0, felt_before_ = 0, felt_places_ = 0;
    double x_m_ = 0.0, height_m_ = 0.0, pressed_m_ = 0.0;
    bool felt_now_ = false;
    std::vector<Vec3> felt_;
};

/// The finger that bodies() shows.
FingerForm finger_in(const std::vector<RoundedBody>& bodies) {
    const RoundedBody& body = bodies.front();
    return {body.middle - body.half_a, unit(body.half_a), body.radius};
}

/// Where something is felt, if it is and within the disc.
class Feeling {
public:
    Feeling(const Array& array, const SurfaceOptions& options) : random_(options.person_seed), disc_m_(options.disc_m) {
        if (options.sense) sense_.emplace(array, *options.sense);
        if (options.sense) off_m_ = options.hand_sd_m * std::normal_distribution<double>()(random_);
    }
    [[nodiscard]] std::optional<Vec3> at(const ShotReport& shot, const std::optional<Path>& path, Vec3 disc,
                                         const FingerForm& finger) {
        std::optional<Vec3> felt;
        for (const Vec3& centre : shot.centres)
            if (distance(centre, disc) < disc_m_) felt = centre;
        if (!sense_ || !felt || !path) return felt;
        const std::optional<Sensed> sensed = sense_->feel(*path, finger, random_);
        if (!sensed) return {};
        return sensed->place + Vec3{0, 0, off_m_};
    }
    [[nodiscard]] std::mt19937_64& random() { return random_; }

private:
    std::mt19937_64 random_;
    double disc_m_, off_m_ = 0.0;
    std::optional<SkinSense> sense_;
};

double to_keys(double value, double key) { return key * std::round(value / key); }

/// The line z = height + slope·x of least squares.
std::optional<std::pair<double, double>> line_through(const std::vector<Vec3>& places, Vec3 middle) {
    double x = 0, z = 0, xx = 0, xz = 0;
    for (const Vec3& p : places) {
        x += p.x - middle.x;
        z += p.z - middle.z;
        xx += (p.x - middle.x) * (p.x - middle.x);
        xz += (p.x - middle.x) * (p.z - middle.z);
    }
    const auto n = static_cast<double>(places.size());
    const double spread = xx - x * x / n;
    constexpr double least_spread = 1e-6;  // m²: places 1 mm apart
    if (!(n >= 2 && spread > least_spread)) return {};
    const double slope = (xz - x * z / n) / spread;
    return std::pair((z - slope * x) / n, slope);
}

}  // namespace

void draw_surface(SurfaceOptions& options, std::mt19937_64& random) {
    const auto keys = [&](double most, double key) {
        const auto steps = static_cast<std::int64_t>(std::llround(most / key));
        return key * static_cast<double>(
                         static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * steps + 1)) - steps);
    };
    options.angle_deg = keys(45.0, options.key_deg);
    options.height_m = keys(10e-3, options.key_m);
}

SurfaceReport find_surface(const Array& array, const SurfaceOptions& given,
                           const std::function<void(const ShotReport&)>& told) {
    const SurfaceOptions options = placed(given);
    ShotRings rings(array, array.carrier_hz, options.fingers);
    const std::vector<DepthCamera> cameras = cameras_of(options.cameras);
    const Vec3 disc = options.fingers.scene.pose.origin;
    Explorer finger(options, options.middle);
    Feeling feeling(array, options);
    const double step_s = 1.0 / options.cameras.rate_hz;
    SurfaceReport report;
    std::optional<double> touched;
    for (; static_cast<double>(report.shots) * step_s < options.at_most_s && !finger.ended(); ++report.shots) {
        const double time_s = static_cast<double>(report.shots) * step_s;
        const std::vector<RoundedBody> bodies = finger.bodies();
        const DepthShot shot = render_shot(bodies, cameras, options.cameras.noise, report.shots, time_s);
        ShotReport now;
        now.number = report.shots;
        now.time_s = time_s;
        const std::optional<Path> path = rings.take(cameras, shot, now);
        if (told) told(now);
        const std::optional<Vec3> felt =
            options.nothing ? std::nullopt : feeling.at(now, path, disc, finger_in(bodies));
        if (felt && !touched) touched = time_s;
        if (touched) report.time_s = time_s - *touched;
        finger.step(step_s, felt);
    }
    report.counts = rings.counts();
    report.felt_places = finger.felt_places();
    const auto line = line_through(finger.felt(), options.middle);
    report.done = finger.ended() && report.felt_places >= 2 && line.has_value();
    if (!report.done && !options.sense) return report;
    if (!report.done) {
        SurfaceOptions guess = given;
        draw_surface(guess, feeling.random());
        report.guessed = true;
        report.angle_deg = guess.angle_deg;
        report.height_m = guess.height_m;
        report.angle_error_deg = report.angle_deg - options.angle_deg;
        report.height_error_m = report.height_m - options.height_m;
        return report;
    }
    // A turn about y by the right hand lowers the side of positive x.
    report.angle_deg = to_keys(-std::atan(line->second) / degree, options.key_deg);
    report.height_m = to_keys(line->first, options.key_m);
    report.angle_error_deg = report.angle_deg - options.angle_deg;
    report.height_error_m = report.height_m - options.height_m;
    return report;
}

}  // namespace haptogram::live
