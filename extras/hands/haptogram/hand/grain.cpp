// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/grain.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "haptogram/hand/random.hpp"

namespace haptogram {
namespace {

/// A place of the raster between its points.
SkinPoint at(const SkinRegion& region, double row, double column) {
    const auto r = std::min(static_cast<std::size_t>(row), region.rows - 2);
    const auto c = std::min(static_cast<std::size_t>(column), region.columns - 2);
    const auto point = [&](std::size_t i, std::size_t j) {
        return SkinPoint{region.point(i, j), region.normals[i * region.columns + j]};
    };
    const double down = row - static_cast<double>(r), right = column - static_cast<double>(c);
    return between(between(point(r, c), point(r, c + 1), right), between(point(r + 1, c), point(r + 1, c + 1), right),
                   down);
}

/// What std::floor gives, without a call.
std::int64_t whole_below(double value) {
    const auto cut = static_cast<std::int64_t>(value);
    return static_cast<double>(cut) > value ? cut - 1 : cut;
}

/// Directions that turn by at most a right angle from step to step.
double turned(KeyedRandom& random, double angle) {
    return angle + random.uniform(-0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
}

}  // namespace

std::vector<SkinLine> random_grain(const SkinRegion& region, const DepthMap& map, double time_s, std::size_t number,
                                   const GrainOptions& options) {
    std::vector<SkinLine> lines;
    if (!map.touched) return lines;
    // How far neighbours are apart, so that squares and steps have their size on the skin.
    const double row_m = distance(region.point(0, 0), region.point(1, 0));
    const double column_m = distance(region.point(0, 0), region.point(0, 1));
    const double rows = options.spacing_m / row_m, columns = options.spacing_m / column_m;
    const double last_row = static_cast<double>(region.rows - 1), last_column = static_cast<double>(region.columns - 1);
    bool back = false;  // every other row of squares the other way, which keeps the jumps short
    for (double row = 0.0; row + 0.5 * rows <= last_row; row += rows, back = !back) {
        std::vector<SkinLine> along;
        for (double column = 0.0; column + 0.5 * columns <= last_column; column += columns) {
            const auto middle = static_cast<std::size_t>(std::lround(row + 0.5 * rows)) * region.columns +
                                static_cast<std::size_t>(std::lround(column + 0.5 * columns));
            if (!(map.depth[middle] > 0.0)) continue;
            KeyedRandom random{std::bit_cast<std::int64_t>(options.seed), std::bit_cast<std::int64_t>(time_s),
                               static_cast<std::int64_t>(number), static_cast<std::int64_t>(middle)};
            double r = std::min(last_row, row + random.uniform(0.0, rows));
            double c = std::min(last_column, column + random.uniform(0.0, columns));
            double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
            const double step = options.length_m / static_cast<double>(options.points - 1);
            SkinLine line{{at(region, r, c)}, false, LineKind::grain, number};
            while (line.points.size() < options.points) {
                angle = turned(random, angle);
                const double to_r = r + step / row_m * std::cos(angle), to_c = c + step / column_m * std::sin(angle);
                if (to_r < 0.0 || to_r > last_row || to_c < 0.0 || to_c > last_column) {
                    angle += std::numbers::pi;  // back from the raster's border
                    continue;
                }
                r = to_r;
                c = to_c;
                line.points.push_back(at(region, r, c));
            }
            along.push_back(std::move(line));
        }
        if (back) std::reverse(along.begin(), along.end());
        lines.insert(lines.end(), along.begin(), along.end());
    }
    return lines;
}

std::vector<SkinLine> fixed_grain(const SkinRegion& region, const DepthMap& map, std::size_t number,
                                  const GrainOptions& options) {
    using Cube = std::array<std::int64_t, 3>;
    std::vector<SkinLine> lines;
    if (!map.touched) return lines;
    std::vector<Cube> cubes;  // in which the skin is inside
    for (std::size_t i = 0; i < region.points.size(); ++i) {
        if (!(map.depth[i] > 0.0)) continue;
        const Vec3 p = region.points[i] * (1.0 / options.spacing_m);
        const Cube cube{whole_below(p.x), whole_below(p.y), whole_below(p.z)};
        if (cubes.empty() || cubes.back() != cube) cubes.push_back(cube);
    }
    std::sort(cubes.begin(), cubes.end());
    cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
    for (const Cube& cube : cubes) {
        KeyedRandom random{std::bit_cast<std::int64_t>(options.seed), cube[0], cube[1], cube[2]};
        const Vec3 low =
            Vec3{static_cast<double>(cube[0]), static_cast<double>(cube[1]), static_cast<double>(cube[2])} *
            options.spacing_m;
        const double step = options.length_m / static_cast<double>(options.points - 1);
        const auto somewhere = [&] { return random.uniform(0.0, options.spacing_m); };
        Vec3 p = low + Vec3{somewhere(), somewhere(), somewhere()};
        double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
        SkinLine line{{}, false, LineKind::grain, number};
        // Steps in the plane that the skin faces most; there the line keeps its length when it is laid onto the skin.
        const Vec3 normal = region.nearest(low + 0.5 * options.spacing_m * Vec3{1, 1, 1}).normal;
        const bool along_x = std::abs(normal.x) >= std::max(std::abs(normal.y), std::abs(normal.z));
        const bool along_y = !along_x && std::abs(normal.y) >= std::abs(normal.z);
        while (true) {
            line.points.push_back(region.nearest(p));
            if (line.points.size() == options.points) break;
            angle = turned(random, angle);
            const double u = step * std::cos(angle), v = step * std::sin(angle);
            p = p + (along_x ? Vec3{0, u, v} : along_y ? Vec3{u, 0, v} : Vec3{u, v, 0});
        }
        lines.push_back(std::move(line));
    }
    return lines;
}

}  // namespace haptogram
