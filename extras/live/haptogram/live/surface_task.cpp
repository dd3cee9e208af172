// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/surface_task.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "haptogram/base/error.hpp"

namespace haptogram::live {
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
