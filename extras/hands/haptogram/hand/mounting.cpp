// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/mounting.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram {
namespace {

using Points = Eigen::Matrix3Xd;

Eigen::Vector3d eigen_of(Vec3 p) { return {p.x, p.y, p.z}; }
Vec3 vec3_of(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

Vec3 vector_of(const section::Section& file, const char* key, const char* what) {
    const auto numbers = file.required(file.numbers(key, 3), key, what);
    return {numbers[0], numbers[1], numbers[2]};
}

/// Calls `take` with the numbers of each line.
template <std::size_t Count, class Take>
void for_each_row(std::string_view text, const std::string& where, const Take& take) {
    for (Lines lines(without_byte_order_mark(text)); lines.next();) {
        std::string row(lines.line().substr(0, lines.line().find('#')));
        std::ranges::replace(row, ',', ' ');
        std::array<double, Count> numbers{};
        std::size_t count = 0;
        std::string_view rest = row;
        for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++count) {
            const std::optional<double> number = parse_number(word);
            if (!number || !is_coordinate(*number)) throw bad_coordinate(at_line(where, lines.number()), word);
            if (count < Count) numbers[count] = *number;
        }
        if (count != 0 && count != Count)
            throw bad_input(at_line(where, lines.number()), fmt::format("found {} numbers, expected {}", count, Count));
        if (count != 0) take(numbers);
    }
}

/// From the tracker's frame to the array's.
Eigen::Isometry3d fitted(const Points& seen, const Points& known) {
    return Eigen::Isometry3d(Eigen::umeyama(seen, known, false));
}

Points without(const Points& points, Eigen::Index place) {
    Points rest(3, points.cols() - 1);
    rest << points.leftCols(place), points.rightCols(points.cols() - place - 1);
    return rest;
}

/// Whether points leave the turn about a line open.
bool on_a_line(const Points& points) {
    constexpr double thin = 0.05;
    const Points spread = points.colwise() - points.rowwise().mean().eval();
    const Eigen::Vector3d sizes = Eigen::JacobiSVD<Eigen::MatrixXd>(spread).singularValues();
    return !(sizes(1) > thin * sizes(0));
}

/// Of points of weight 1 about their middle.
Eigen::Matrix3d inertia_of(std::span<const Vec3> points) {
    Points spread(3, static_cast<Eigen::Index>(points.size()));
    for (Eigen::Index i = 0; i < spread.cols(); ++i) spread.col(i) = eigen_of(points[static_cast<std::size_t>(i)]);
    spread = spread.colwise() - spread.rowwise().mean().eval();
    return spread.squaredNorm() * Eigen::Matrix3d::Identity() - spread * spread.transpose();
}

/// What a weighted sum of three squared normal errors stays below in 95 of 100 cases.
/// @param freedom  with how many degrees of freedom their variance was estimated; infinite: it is known
double quantile_95(const Eigen::Vector3d& weights, double freedom) {
    constexpr double z = 1.6449;
    const double mean = weights.sum(), of_sum = mean * mean / weights.squaredNorm();
    // By a chi-square of equal mean and variance (Satterthwaite 1946), over the estimate's; their ratio's cube root is
    // about normal (Wilson and Hilferty 1931; Paulson 1942).
    const double a = 2.0 / (9.0 * of_sum), b = std::isfinite(freedom) ? 2.0 / (9.0 * freedom) : 0.0;
    const double low = (1.0 - b) * (1.0 - b) - z * z * b, middle = (1.0 - a) * (1.0 - b),
                 high = (1.0 - a) * (1.0 - a) - z * z * a;
    return mean * std::pow((middle + std::sqrt(middle * middle - low * high)) / low, 3);
}

}  // namespace

Pose mounting_from_toml(std::string_view text, const std::string& where) {
    const toml::table table = section::parse_text(text, where);
    const section::Section file(where, table);
    file.only({"position_mm", "right", "forward"});
    const Vec3 at = vector_of(file, "position_mm", "where it is: [x, y, z]");
    const Vec3 right = vector_of(file, "right", "its x axis in the array's frame, of length 1");
    const Vec3 forward = vector_of(file, "forward", "its z axis in the array's frame, of length 1");
    constexpr double near = 1e-3;
    if (std::abs(norm(right) - 1.0) > near || std::abs(norm(forward) - 1.0) > near ||
        std::abs(dot(right, forward)) > near)
        throw bad_input(file.at("right"), "right and forward must have length 1 and be at right angles");
    const Vec3 z = unit(forward), x = unit(right - dot(right, z) * z);
    return {from_mm(at.x, at.y, at.z), x, cross(z, x), z};
}

std::string mounting_to_toml(const Pose& pose, const std::vector<std::string>& about) {
    std::string text;
    for (const std::string& line : about) text += "# " + line + "\n";
    const auto row = [](const char* key, Vec3 v) { return fmt::format("{} = [{}, {}, {}]\n", key, v.x, v.y, v.z); };
    return text + row("position_mm", (1.0 / millimetre) * pose.origin) + row("right", pose.x) + row("forward", pose.z);
}

HandFrame mounted(HandFrame frame, const Pose& pose) {
    for (Hand& hand : frame.hands) {
        hand.palm = pose.outwards(hand.palm);
        hand.normal = pose.turned(hand.normal);
        hand.direction = pose.turned(hand.direction);
        hand.velocity = pose.turned(hand.velocity);
        for (std::optional<Finger>& finger : hand.fingers)
            if (finger)
                for (Vec3& joint : finger->joints) joint = pose.outwards(joint);
    }
    return frame;
}

std::vector<Vec3> known_points_from(std::string_view text, const std::string& where) {
    std::vector<Vec3> points;
    for_each_row<3>(text, where, [&](const auto& row) { points.push_back(from_mm(row[0], row[1], row[2])); });
    return points;
}

std::vector<SeenPoint> seen_points_from(std::string_view text, const std::string& where) {
    std::vector<SeenPoint> points;
    for_each_row<6>(text, where, [&](const auto& row) {
        points.push_back({from_mm(row[0], row[1], row[2]), from_mm(row[3], row[4], row[5])});
    });
    return points;
}

Alignment align(std::span<const SeenPoint> points, const std::string& where) {
    const auto count = static_cast<Eigen::Index>(points.size());
    constexpr Eigen::Index least = 3;
    if (count < least) throw bad_input(where, fmt::format("found {} points, expected at least {}", count, least));
    Points known(3, count), seen(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
        known.col(i) = eigen_of(points[static_cast<std::size_t>(i)].known);
        seen.col(i) = eigen_of(points[static_cast<std::size_t>(i)].seen);
    }
    if (on_a_line(known) || on_a_line(seen))
        throw bad_input(where, "the points lie on a line, so the turn about it stays open; add one far from that line");
    const Eigen::Isometry3d frame = fitted(seen, known);
    Alignment found;
    found.pose = {vec3_of(frame.translation()), vec3_of(frame.linear().col(0)), vec3_of(frame.linear().col(1)),
                  vec3_of(frame.linear().col(2))};
    const Points left = known - frame * seen;
    for (Eigen::Index i = 0; i < count; ++i) {
        found.residuals_m.push_back(left.col(i).norm());
        if (count == least || on_a_line(without(known, i))) {
            found.residuals_without_m.push_back(found.residuals_m.back());
            continue;
        }
        const Eigen::Isometry3d rest = fitted(without(seen, i), without(known, i));
        found.residuals_without_m.push_back((known.col(i) - rest * seen.col(i)).norm());
    }
    found.rms_m = std::sqrt(left.squaredNorm() / static_cast<double>(count));
    // Three numbers a point, less the six of the pose.
    if (count > least) found.noise_m = std::sqrt(left.squaredNorm() / static_cast<double>(3 * count - 6));
    return found;
}

Sureness sureness_of(std::span<const Vec3> known, double noise_m, bool learned) {
    const auto count = static_cast<double>(known.size());
    const double freedom = learned ? 3.0 * count - 6.0 : HUGE_VAL;
    const Eigen::Vector3d shares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia_of(known)).eigenvalues();
    return {noise_m * std::sqrt(quantile_95(Eigen::Vector3d::Constant(1.0 / count), freedom)),
            noise_m * std::sqrt(quantile_95(shares.cwiseInverse(), freedom))};
}

Vec3 next_touch(std::span<const Vec3> touched, std::span<const Vec3> places) {
    constexpr double spread = 1e-3;  // decides while two points, or none, leave a turn open
    std::vector<Vec3> with(touched.begin(), touched.end());
    Vec3 middle;
    for (const Vec3 place : places) middle = middle + (1.0 / static_cast<double>(places.size())) * place;
    if (with.empty()) return *std::ranges::max_element(places, {}, [&](Vec3 p) { return distance(p, middle); });
    with.emplace_back();
    double most = -1.0;
    Vec3 best;
    for (const Vec3 place : places) {
        if (std::ranges::find(touched, place) != touched.end()) continue;
        with.back() = place;
        const Eigen::Matrix3d inertia = inertia_of(with);
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
        axes.computeDirect(inertia, Eigen::EigenvaluesOnly);
        if (const double gain = axes.eigenvalues()(0) + spread * inertia.trace(); gain > most) {
            most = gain;
            best = place;
        }
    }
    return best;
}

std::vector<Vec3> touches_in(const HandRecording& recording, std::size_t finger, double still_s, double still_m) {
    std::vector<Vec3> touches, stay;
    double since_s = 0.0, last_s = 0.0;
    Vec3 sum;
    const auto end = [&] {
        if (!stay.empty() && last_s - since_s >= still_s)
            touches.push_back((1.0 / static_cast<double>(stay.size())) * sum);
        stay.clear();
        sum = {};
    };
    for (const HandFrame& frame : recording.frames) {
        const auto hand =
            std::ranges::find_if(frame.hands, [&](const Hand& one) { return one.fingers.at(finger).has_value(); });
        if (hand == frame.hands.end()) continue;  // a frame in which it was not seen ends nothing
        const Vec3 tip = hand->fingers[finger]->joints.back();
        if (!stay.empty() && norm(tip - (1.0 / static_cast<double>(stay.size())) * sum) > still_m) end();
        if (stay.empty()) since_s = frame.time_s;
        stay.push_back(tip);
        sum = sum + tip;
        last_s = frame.time_s;
    }
    end();
    return touches;
}

}  // namespace haptogram
