// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/sample.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/farthest.hpp"

namespace haptogram {
namespace {

/// In [0, 1), equal on every platform, which std::uniform_real_distribution does not promise.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

template <class Kind>
std::vector<const Kind*> pieces_of(const Shape& shape) {
    std::vector<const Kind*> found;
    for (const Piece& piece : shape.pieces)
        if (const Kind* const one = std::get_if<Kind>(&piece)) found.push_back(one);
    return found;
}

void along(const Curve& curve, std::size_t count, std::vector<Vec3>& out) {
    if (count == 1 && !curve.closed) {
        out.push_back(curve.at(0.5 * curve.length));
        return;
    }
    const auto steps = static_cast<double>(curve.closed ? count : count - 1);
    for (std::size_t i = 0; i < count; ++i)
        out.push_back(curve.at(std::min(curve.length, curve.length * (static_cast<double>(i) / steps))));
}

void along(const std::vector<const Curve*>& curves, std::size_t count, std::vector<Vec3>& out) {
    if (curves.empty()) return;
    std::vector<double> lengths;
    lengths.reserve(curves.size());
    for (const Curve* curve : curves) lengths.push_back(curve->length);
    const std::vector<std::size_t> shares = share(count, lengths);
    for (std::size_t i = 0; i < curves.size(); ++i)
        if (shares[i] > 0) along(*curves[i], shares[i], out);
}

/// Random points, equally dense everywhere on the surface. The triangles are laid out in a row by their areas; even
/// steps along the row, from a random start, choose the triangle of each point.
void over(const std::vector<const Mesh*>& meshes, std::size_t count, std::mt19937_64& random, std::vector<Vec3>& out) {
    struct Triangle {
        Vec3 corner, side, other_side;
        double area_until;
    };
    std::vector<Triangle> strip;
    double area = 0.0;
    for (const Mesh* mesh : meshes) {
        for (const auto& [a, b, c] : mesh->triangles) {
            const Vec3 corner = mesh->vertices[a];
            const Vec3 side = mesh->vertices[b] - corner;
            const Vec3 other_side = mesh->vertices[c] - corner;
            area += 0.5 * norm(cross(side, other_side));
            strip.push_back({corner, side, other_side, area});
        }
    }
    if (area == 0.0) return;
    const double start = uniform(random);
    auto triangle = strip.begin();
    for (std::size_t i = 0; i < count; ++i) {
        const double at = area * (static_cast<double>(i) + start) / static_cast<double>(count);
        while (triangle->area_until < at && triangle + 1 != strip.end()) ++triangle;
        const double root = std::sqrt(uniform(random));  // evenly over a triangle: Osada et al. 2002, eq. 1
        const double part = uniform(random);
        out.push_back(triangle->corner + root * (1.0 - part) * triangle->side + root * part * triangle->other_side);
    }
}

}  // namespace

std::vector<std::size_t> share(std::size_t count, const std::vector<double>& weights) {
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    std::vector<std::size_t> shares(weights.size());
    std::vector<double> remainders(weights.size());
    std::size_t given = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const double exact = total > 0.0 ? static_cast<double>(count) * weights[i] / total : 0.0;
        shares[i] = std::min(static_cast<std::size_t>(exact), count - given);
        remainders[i] = exact - std::floor(exact);
        given += shares[i];
    }
    std::vector<std::size_t> order(weights.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return remainders[a] > remainders[b]; });
    for (std::size_t k = 0; given < count; ++k, ++given) ++shares[order[k % order.size()]];
    return shares;
}

Sampled sample(const Shape& shape, std::size_t count, std::uint64_t seed) {
    if (count == 0)
        throw bad_argument("points", "found 0, expected at least 1; ask for as many points as the hand shall feel",
                           {"points"});
    const auto curves = pieces_of<Curve>(shape);
    const auto meshes = pieces_of<Mesh>(shape);
    const auto clouds = pieces_of<Cloud>(shape);
    constexpr std::size_t least_candidates = 10'000;
    constexpr std::size_t candidates_per_point = 20;
    const std::size_t dense = std::max(candidates_per_point * count, least_candidates);
    const bool only_curves = meshes.empty() && clouds.empty();

    std::mt19937_64 random(seed);
    std::vector<Vec3> candidates;
    along(curves, only_curves ? count : dense, candidates);
    over(meshes, dense, random, candidates);
    for (const Cloud* cloud : clouds) candidates.insert(candidates.end(), cloud->points.begin(), cloud->points.end());
    if (candidates.empty())
        throw bad_argument("shape", "found nothing, expected a curve, a surface or points; name a shape", {"shape"});

    const auto first = static_cast<std::size_t>(uniform(random) * static_cast<double>(candidates.size()));
    std::vector<std::size_t> chosen = farthest_points(candidates, count, first);
    std::sort(chosen.begin(), chosen.end());
    Sampled sampled;
    for (const std::size_t index : chosen) sampled.points.push_back(candidates[index]);
    if (chosen.size() < count) sampled.duplicates_removed = candidates.size() - chosen.size();
    return sampled;
}

}  // namespace haptogram
