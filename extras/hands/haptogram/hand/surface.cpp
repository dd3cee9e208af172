// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/surface.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

/// A direction at right angles to `axis`, as near to `wanted` as can be.
Vec3 across(Vec3 axis, Vec3 wanted) {
    const Vec3 rest = wanted - dot(wanted, axis) * axis;
    if (norm(rest) > 1e-9) return unit(rest);
    // The finger points along the palm's normal, so no side of it is more palmar than another.
    const Vec3 other = std::abs(axis.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    return unit(other - dot(other, axis) * axis);
}

/// Even steps from one end to the other, both included.
std::size_t steps_over(double length, double cell) { return static_cast<std::size_t>(std::ceil(length / cell)) + 1; }

/// The hemisphere that ends a finger's last segment: rows go on over its end, from the palmar side to the nail's.
/// @param around  cosine and sine of each column's angle from the middle
void add_tip(SkinRegion& region, const std::vector<std::array<double, 2>>& around, double cell) {
    SkinPatch& last = region.patches.back();
    const Vec3 centre = last.from + last.length * last.along;
    const std::size_t rows = steps_over(std::numbers::pi * last.radius, cell);
    for (std::size_t row = 1; row < rows; ++row) {
        const double over = std::numbers::pi * static_cast<double>(row) / static_cast<double>(rows - 1);
        const Vec3 out = std::cos(over) * last.out + std::sin(over) * last.along;
        for (const auto& [cosine, sine] : around) {
            const Vec3 normal = cosine * out + sine * last.side;
            region.points.push_back(centre + last.radius * normal);
            region.normals.push_back(normal);
        }
    }
    region.rows = last.end_row = region.points.size() / region.columns;
    last.tip = true;
}

SkinRegion finger_surface(std::string_view name, const Finger& finger, Vec3 palm_normal, std::array<double, 3> radii,
                          double cell) {
    if (finger.width_m)
        for (const double scale = 0.5 * *finger.width_m / radii[1]; double& radius : radii) radius *= scale;
    SkinRegion region;
    region.name = name;
    const double widest = std::numbers::pi * *std::max_element(radii.begin(), radii.end());
    region.columns = steps_over(widest, cell);
    std::vector<std::array<double, 2>> around;  // cosine and sine of each column's angle from the middle
    for (std::size_t column = 0; column < region.columns; ++column) {
        const double angle =
            std::numbers::pi * (static_cast<double>(column) / static_cast<double>(region.columns - 1) - 0.5);
        around.push_back({std::cos(angle), std::sin(angle)});
    }
    std::size_t most_rows = 0;
    for (std::size_t segment = 0; segment < 3; ++segment)
        most_rows += steps_over(distance(finger.joints.at(segment), finger.joints.at(segment + 1)), cell);
    region.points.reserve(most_rows * region.columns);
    region.normals.reserve(most_rows * region.columns);
    for (std::size_t segment = 0; segment < 3; ++segment) {
        const Vec3 from = finger.joints.at(segment), to = finger.joints.at(segment + 1);
        const double length = distance(from, to), radius = radii.at(segment);
        if (length == 0.0) continue;  // some trackers let two joints of a thumb coincide
        const Vec3 axis = (to - from) * (1.0 / length);
        const Vec3 palmar = across(axis, palm_normal);
        const Vec3 side = cross(axis, palmar);
        const std::size_t rows = steps_over(length, cell);
        for (std::size_t row = region.rows == 0 ? 0 : 1; row < rows; ++row) {
            const Vec3 centre = from + (static_cast<double>(row) / static_cast<double>(rows - 1)) * (to - from);
            for (const auto& [cosine, sine] : around) {
                const Vec3 normal = cosine * palmar + sine * side;
                region.points.push_back(centre + radius * normal);
                region.normals.push_back(normal);
            }
        }
        region.rows = region.points.size() / region.columns;
        region.patches.push_back({from, axis, side, palmar, length, radius, 0.0, 0.0, region.rows, false});
    }
    if (!region.patches.empty()) add_tip(region, around, cell);
    return region;
}

SkinRegion palm_surface(const Hand& hand, const SkinOptions& options) {
    SkinRegion region;
    region.name = "palm";
    region.rows = steps_over(options.palm_length_m, options.cell_m);
    region.columns = steps_over(options.palm_width_m, options.cell_m);
    const Vec3 side = unit(cross(hand.normal, hand.direction));
    region.points.reserve(region.rows * region.columns);
    region.normals.assign(region.rows * region.columns, hand.normal);
    const Vec3 wrist = hand.palm - 0.5 * options.palm_length_m * hand.direction;
    for (std::size_t row = 0; row < region.rows; ++row) {
        const double along = options.palm_length_m * (static_cast<double>(row) / static_cast<double>(region.rows - 1));
        for (std::size_t column = 0; column < region.columns; ++column) {
            const double beside =
                options.palm_width_m * (static_cast<double>(column) / static_cast<double>(region.columns - 1) - 0.5);
            region.points.push_back(wrist + along * hand.direction + beside * side);
        }
    }
    region.patches.push_back({wrist, hand.direction, side, hand.normal, options.palm_length_m, 0.0,
                              options.palm_width_m, options.palm_thickness_m, region.rows, false});
    return region;
}

void require_sound(const Hand& hand) {
    bool finite = is_finite(hand.palm) && is_finite(hand.normal) && is_finite(hand.direction);
    for (const auto& finger : hand.fingers)
        if (finger)
            for (const Vec3& joint : finger->joints) finite = finite && is_finite(joint);
    if (!finite) throw bad_argument("hand", "a coordinate is not finite; correct or leave out this hand");
    if (!(norm(cross(hand.normal, hand.direction)) > 1e-3))
        throw bad_argument("hand",
                           "the palm's normal and the hand's direction are parallel; expected about a right angle");
}

}  // namespace

SkinPoint SkinPatch::nearest(Vec3 point) const {
    const Vec3 way = point - from;
    const Vec3 foot = from + std::clamp(dot(way, along), 0.0, length) * along;
    const double beside = dot(way, side), before = dot(way, out);
    if (const Vec3 beyond = way - length * along; tip && dot(beyond, along) > 0.0) {
        const Vec3 normal = beyond * (1.0 / norm(beyond));
        return {from + length * along + radius * normal, normal};
    }
    if (radius == 0.0) return {foot + std::clamp(beside, -0.5 * width, 0.5 * width) * side, out};
    if (before < 0.0) {
        const Vec3 edge = beside < 0.0 ? -1.0 * side : side;
        return {foot + radius * edge, edge};
    }
    const double away = std::sqrt(beside * beside + before * before);
    const Vec3 normal = away > 0.0 ? (before / away) * out + (beside / away) * side : out;
    return {foot + radius * normal, normal};
}

std::optional<std::array<double, 2>> SkinPatch::clip(Vec3 a, Vec3 b) const {
    double enter = 0.0, leave = 1.0;
    const auto between = [&](Vec3 axis, double low, double high) {
        const double start = dot(a - from, axis), way = dot(b - a, axis);
        if (way == 0.0) {
            if (start < low || start > high) leave = -1.0;
            return;
        }
        const double one = (low - start) / way, other = (high - start) / way;
        enter = std::max(enter, std::min(one, other));
        leave = std::min(leave, std::max(one, other));
    };
    between(along, -radius, length + radius);
    const double half_width = radius > 0.0 ? radius : 0.5 * width;
    between(side, -half_width, half_width);
    const double half_thickness = radius > 0.0 ? radius : 0.5 * thickness;
    between(out, -half_thickness, half_thickness);
    if (enter > leave) return {};
    return std::array{enter, leave};
}

const SkinPatch& SkinRegion::patch(std::size_t row) const {
    return *std::find_if(patches.begin(), patches.end() - 1, [row](const SkinPatch& one) { return row < one.end_row; });
}

SkinPoint SkinRegion::nearest(Vec3 point) const {
    SkinPoint best = patches.front().nearest(point);
    for (const SkinPatch& one : patches)
        if (const SkinPoint found = one.nearest(point);
            distance(found.position, point) < distance(best.position, point))
            best = found;
    return best;
}

std::vector<SkinRegion> palmar_surface(const Hand& hand, const SkinOptions& options) {
    std::vector<double> measures{options.palm_width_m, options.palm_length_m, options.palm_thickness_m, options.cell_m};
    measures.insert(measures.end(), options.finger_radii_m.begin(), options.finger_radii_m.end());
    measures.insert(measures.end(), options.thumb_radii_m.begin(), options.thumb_radii_m.end());
    for (const double measure : measures)
        if (!(measure > 0.0) || !std::isfinite(measure))
            throw bad_argument("hand", fmt::format("a measure of {} m; expected a positive number", measure));
    require_sound(hand);
    constexpr std::array<std::string_view, 5> names{"thumb", "index", "middle", "ring", "pinkie"};
    std::vector<SkinRegion> regions;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!hand.fingers.at(i)) continue;
        SkinRegion region = finger_surface(names.at(i), *hand.fingers.at(i), hand.normal,
                                           i == 0 ? options.thumb_radii_m : options.finger_radii_m, options.cell_m);
        if (!region.points.empty()) regions.push_back(std::move(region));  // no length, no skin
    }
    regions.push_back(palm_surface(hand, options));
    return regions;
}

namespace {

using std::numbers::pi;

/// Where the points are, and how far they reach: what a fit is freed of first.
struct Frame {
    double x = 0.0, y = 0.0, scale = 0.0;
};

Frame frame_of(std::span<const PlanePoint> points) {
    Frame frame;
    for (const PlanePoint& p : points) {
        frame.x += p[0];
        frame.y += p[1];
    }
    frame.x /= static_cast<double>(points.size());
    frame.y /= static_cast<double>(points.size());
    for (const PlanePoint& p : points) frame.scale = std::max(frame.scale, std::hypot(p[0] - frame.x, p[1] - frame.y));
    return frame;
}

/// Centre, half axes and angle of the conic a·x² + b·xy + c·y² + d·x + e·y + f = 0; nothing when it is no ellipse.
std::optional<PlaneEllipse> ellipse_of(const Eigen::Matrix<double, 6, 1>& conic) {
    Eigen::Matrix2d form;
    form << conic[0], 0.5 * conic[1], 0.5 * conic[1], conic[2];
    const Eigen::Vector2d linear(conic[3], conic[4]);
    if (!(form.determinant() > 0.0)) return {};
    const Eigen::Vector2d centre = -0.5 * form.inverse() * linear;
    const double level = centre.dot(form * centre) - conic[5];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(form / level);
    if (!(axes.eigenvalues()[0] > 0.0)) return {};
    const Eigen::Vector2d major = axes.eigenvectors().col(0);
    return PlaneEllipse{centre[0], centre[1], 1.0 / std::sqrt(axes.eigenvalues()[0]),
                        1.0 / std::sqrt(axes.eigenvalues()[1]), std::atan2(major[1], major[0])};
}

struct Circle {
    double x, y, radius;
};

/// The circle of least radial distance, by Gauss and Newton from the algebraic one.
std::optional<Circle> fit_circle(const std::vector<PlanePoint>& points) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const PlanePoint& p : points) {
        const Eigen::Vector3d row(p[0], p[1], 1.0);
        normal += row * row.transpose();
        right += row * (p[0] * p[0] + p[1] * p[1]);
    }
    const Eigen::Vector3d start = normal.ldlt().solve(right);
    Eigen::Vector3d circle(0.5 * start[0], 0.5 * start[1], 0.0);
    circle[2] = std::sqrt(std::max(0.0, start[2] + circle[0] * circle[0] + circle[1] * circle[1]));
    for (int round = 0; round < 20; ++round) {
        normal.setZero();
        right.setZero();
        for (const PlanePoint& p : points) {
            const double dx = p[0] - circle[0], dy = p[1] - circle[1], r = std::hypot(dx, dy);
            if (r == 0.0) continue;
            const Eigen::Vector3d row(-dx / r, -dy / r, -1.0);
            normal += row * row.transpose();
            right -= row * (r - circle[2]);
        }
        const Eigen::Vector3d step = normal.ldlt().solve(right);
        circle += step;
        if (step.norm() < 1e-12) break;
    }
    if (!circle.allFinite() || !(circle[2] > 0.0)) return {};
    return Circle{circle[0], circle[1], circle[2]};
}

/// The ellipse whose longer axis is as wide as the points are, along x, and whose outline on the side of −y or +y they
/// are: what is left where noise hides the outline's bend.
/// @param behind  1: the centre is at higher y than the points, −1: at lower
PlaneEllipse fit_width(std::span<const PlanePoint> points, double ratio, double behind) {
    const auto [least, most] = std::minmax_element(points.begin(), points.end());
    const double x = 0.5 * ((*least)[0] + (*most)[0]), half = 0.5 * ((*most)[0] - (*least)[0]);
    double y = 0.0;
    for (const PlanePoint& p : points) {
        const double bend = std::sqrt(std::max(0.0, half * half - (p[0] - x) * (p[0] - x)));
        y += (p[1] + behind * ratio * bend) / static_cast<double>(points.size());
    }
    return {x, y, half, half * ratio, 0.0};
}

/// How much of a turn the points go around a centre: 360° less the largest gap.
double cover_deg(std::span<const PlanePoint> points, const PlaneEllipse& ellipse) {
    std::vector<double> angles;
    for (const PlanePoint& p : points) angles.push_back(std::atan2(p[1] - ellipse.y, p[0] - ellipse.x));
    std::sort(angles.begin(), angles.end());
    double gap = angles.front() + 2.0 * pi - angles.back();
    for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
    return 360.0 - gap * 180.0 / pi;
}

/// The direction in which points spread least: across the part of an outline that is seen.
PlanePoint across(std::span<const PlanePoint> points) {
    const Frame frame = frame_of(points);
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const PlanePoint& p : points) {
        const Eigen::Vector2d d(p[0] - frame.x, p[1] - frame.y);
        spread += d * d.transpose();
    }
    const Eigen::Vector2d least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(0);
    return {least[0], least[1]};
}

bool finger_like(const PlaneEllipse& e, const SectionOptions& options) {
    return e.half_major >= options.least_m && e.half_major <= options.most_m &&
           e.half_minor >= options.least_ratio * e.half_major;
}

}  // namespace

Vec3 Ellipse::at(double parameter) const {
    return centre + half_major * std::cos(parameter) * major + half_minor * std::sin(parameter) * minor;
}

double Ellipse::perimeter() const {
    const double ratio = half_minor / half_major;
    return 4.0 * half_major * std::comp_ellint_2(std::sqrt(std::max(0.0, 1.0 - ratio * ratio)));
}

std::optional<PlaneEllipse> fit_ellipse(std::span<const PlanePoint> points) {
    if (points.size() < 5) return {};
    const Frame frame = frame_of(points);
    if (!(frame.scale > 0.0)) return {};
    Eigen::Matrix3d s1 = Eigen::Matrix3d::Zero(), s2 = s1, s3 = s1;
    for (const PlanePoint& p : points) {
        const double x = (p[0] - frame.x) / frame.scale, y = (p[1] - frame.y) / frame.scale;
        const Eigen::Vector3d quadratic(x * x, x * y, y * y), linear(x, y, 1.0);
        s1 += quadratic * quadratic.transpose();
        s2 += quadratic * linear.transpose();
        s3 += linear * linear.transpose();
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> s3_lu(s3);
    if (!s3_lu.isInvertible()) return {};
    const Eigen::Matrix3d t = -s3_lu.solve(s2.transpose());
    const Eigen::Matrix3d reduced = s1 + s2 * t;
    Eigen::Matrix3d m;  // the constraint's inverse times the reduced scatter
    m << 0.5 * reduced.row(2), -reduced.row(1), 0.5 * reduced.row(0);
    const Eigen::EigenSolver<Eigen::Matrix3d> solver(m);
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d quadratic = solver.eigenvectors().col(i).real();
        if (!(4.0 * quadratic[0] * quadratic[2] - quadratic[1] * quadratic[1] > 0.0)) continue;
        Eigen::Matrix<double, 6, 1> conic;
        conic << quadratic, t * quadratic;
        auto found = ellipse_of(conic);
        if (!found) continue;
        return PlaneEllipse{frame.x + frame.scale * found->x, frame.y + frame.scale * found->y,
                            frame.scale * found->half_major, frame.scale * found->half_minor, found->angle};
    }
    return {};
}

std::optional<PlaneEllipse> fit_constrained(std::span<const PlanePoint> points, double ratio) {
    if (points.size() < 5) return {};
    const Frame frame = frame_of(points);
    if (!(frame.scale > 0.0)) return {};
    std::vector<PlanePoint> round;  // with the shorter axis stretched, the outline is a circle
    for (const PlanePoint& p : points)
        round.push_back({(p[0] - frame.x) / frame.scale, (p[1] - frame.y) / frame.scale / ratio});
    const std::optional<Circle> circle = fit_circle(round);
    if (!circle) return {};
    return PlaneEllipse{frame.x + frame.scale * circle->x, frame.y + frame.scale * circle->y * ratio,
                        frame.scale * circle->radius, frame.scale * circle->radius * ratio, 0.0};
}

std::optional<FingerSection> section_of(std::span<const Vec3> points, Vec3 surface, Vec3 inward,
                                        const std::optional<Vec3>& sight, const SectionOptions& options) {
    if (points.size() < 5) return {};
    const Vec3 level = std::abs(inward.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    Vec3 x = level - dot(level, inward) * inward;
    x = x * (1.0 / norm(x));
    Vec3 y = cross(inward, x);
    const auto flat = [&] {
        std::vector<PlanePoint> projected;
        for (const Vec3& p : points) projected.push_back({dot(p - surface, x), dot(p - surface, y)});
        return projected;
    };
    std::vector<PlanePoint> projected = flat();
    std::optional<PlaneEllipse> fitted = fit_ellipse(projected);
    const bool trusted =
        fitted && finger_like(*fitted, options) && cover_deg(projected, *fitted) >= options.least_cover_deg;
    if (!trusted) {
        PlanePoint axis = across(projected);
        const PlanePoint seen = sight ? PlanePoint{dot(*sight, x), dot(*sight, y)} : PlanePoint{};
        const bool sighted = sight && std::hypot(seen[0], seen[1]) > 1e-3 * norm(*sight);
        if (sighted) axis = seen;
        y = axis[0] * x + axis[1] * y;
        y = y * (1.0 / norm(y));
        x = cross(y, inward);
        projected = flat();
        fitted = fit_constrained(projected, options.usual_ratio);
        if (!fitted) return {};
        if (!finger_like(*fitted, options))
            fitted =
                fit_width(projected, options.usual_ratio, sighted || fitted->y > frame_of(projected).y ? 1.0 : -1.0);
        if (!finger_like(*fitted, options)) return {};
    }
    FingerSection section;
    section.constrained = !trusted;
    Ellipse& e = section.ellipse;
    e.centre = surface + fitted->x * x + fitted->y * y;
    e.major = std::cos(fitted->angle) * x + std::sin(fitted->angle) * y;
    e.normal = inward;
    e.minor = cross(inward, e.major);
    e.half_major = fitted->half_major;
    e.half_minor = fitted->half_minor;
    return section;
}

}  // namespace haptogram
