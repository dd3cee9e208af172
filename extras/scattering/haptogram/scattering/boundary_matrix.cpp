// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/boundary_matrix.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace haptogram::scattering {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;
using Corners = std::array<Vec3, 3>;

/// A panel is integrated in parts so small that a point's distance is at least this many of their longest edges.
constexpr double clear_edges = 3.0;
/// Beyond this many of its longest edges, a panel counts as one point.
constexpr double near_edges = 4.0;
constexpr unsigned finest = 6;  ///< times that a panel is halved; at the centre of a regular neighbour it takes 3

/// Seven points of degree 5 (Radon 1948): barycentric coordinates and weights.
struct QuadraturePoint {
    double a, b, c, weight;
};
std::array<QuadraturePoint, 7> radon() {
    const double root = std::sqrt(15.0);
    std::array<QuadraturePoint, 7> points{{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 9.0 / 40.0}}};
    std::size_t next = 1;
    for (const double sign : {-1.0, 1.0}) {
        const double one = (6.0 + sign * root) / 21.0, two = 1.0 - 2.0 * one, weight = (155.0 + sign * root) / 1200.0;
        points[next++] = {two, one, one, weight};
        points[next++] = {one, two, one, weight};
        points[next++] = {one, one, two, weight};
    }
    return points;
}

/// The points of a triangle that is halved `level` times along each edge.
void add_points(KernelPoints& points, const Corners& at, Vec3 origin, const Panel& panel, unsigned level) {
    static const std::array<QuadraturePoint, 7> rule = radon();
    const unsigned parts = 1U << level;
    const double share = 1.0 / parts, weight = panel.area * share * share;
    const Vec3 u = (at[1] - at[0]) * share, v = (at[2] - at[0]) * share;
    const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
        for (const QuadraturePoint& q : rule)
            points.add(q.a * a + q.b * b + q.c * c - origin, panel.normal, q.weight * weight);
    };
    for (unsigned i = 0; i < parts; ++i)
        for (unsigned j = 0; i + j < parts; ++j) {
            const Vec3 a = at[0] + u * i + v * j;
            add(a, a + u, a + v);
            if (i + j + 1 < parts) add(a + u, a + u + v, a + v);
        }
    points.pad();
}

/// A panel's points, each level made when it is first asked for.
class PanelPoints {
public:
    PanelPoints(const Corners& corners, Vec3 origin, const Panel& panel)
        : corners_(corners), origin_(origin), panel_(panel) {}
    /// Fine enough for a point at this distance from the centre.
    const KernelPoints& at(double distance) {
        unsigned level = 0;
        for (double edge = panel_.longest_edge; distance < clear_edges * edge && level < finest; edge /= 2.0) ++level;
        if (!levels_.at(level)) add_points(levels_.at(level).emplace(), corners_, origin_, panel_, level);
        return *levels_.at(level);
    }

private:
    Corners corners_;
    Vec3 origin_;
    const Panel& panel_;
    std::array<std::optional<KernelPoints>, finest + 1> levels_;
};

/// Nodes and weights of Gauss and Legendre on [−1, 1], eight of them: what an edge is integrated with.
struct Gauss {
    std::array<double, 8> node{}, weight{};
    Gauss() {
        constexpr int count = 8;
        for (int i = 0; i < count; ++i) {
            double x = std::cos(pi * (i + 0.75) / (count + 0.5)), slope = 0.0;
            for (int round = 0; round < 20; ++round) {
                const double value = std::legendre(count, x);
                slope = count * (x * value - std::legendre(count - 1, x)) / (x * x - 1.0);
                x -= value / slope;
            }
            const auto at = static_cast<std::size_t>(i);
            node.at(at) = x;
            weight.at(at) = 2.0 / ((1.0 - x * x) * slope * slope);
        }
    }
};

/// The finite part of the integral of H over a flat panel at its own centre: −jk/2 − ∮e^{−jkR(θ)}/(4πR(θ))dθ, where
/// R(θ) is the distance to the edge. K is 0 there.
Complex own_panel(const Corners& at, Vec3 centre, double k) {
    static const Gauss gauss;
    Complex sum;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 from = at.at(i) - centre, to = at.at((i + 1) % 3) - centre, edge = to - from;
        const double length = norm(edge), height = norm(cross(from, to)) / length;
        const double first = std::atan2(dot(from, edge) / length, height),
                     last = std::atan2(dot(to, edge) / length, height);
        for (std::size_t q = 0; q < gauss.node.size(); ++q) {
            const double angle = (first + last) / 2.0 + (last - first) / 2.0 * gauss.node.at(q);
            const double range = height / std::cos(angle);
            sum += gauss.weight.at(q) * (last - first) / 2.0 * std::polar(1.0 / (4.0 * pi * range), -k * range);
        }
    }
    return Complex(0.0, -k / 2.0) - sum;
}

/// Panels by cubes of space, so that a panel's neighbours are found without asking all.
class Neighbours {
public:
    Neighbours(const std::vector<Panel>& panels, double reach) : panels_(panels), reach_(reach) {
        order_.resize(panels.size());
        for (std::uint32_t i = 0; i < panels.size(); ++i) order_[i] = {cube(panels[i].centre), i};
        std::sort(order_.begin(), order_.end());
    }
    /// All within a distance that is at most the reach.
    template <class Call>
    void each(Vec3 centre, double within, Call call) const {
        const auto [x, y, z] = cube(centre);
        for (long i = x - 1; i <= x + 1; ++i)
            for (long j = y - 1; j <= y + 1; ++j) {
                const Cube from{i, j, z - 1}, to{i, j, z + 1};
                auto at = std::lower_bound(order_.begin(), order_.end(), Place{from, 0U});
                for (; at != order_.end() && at->first <= to; ++at)
                    if (const double apart = distance(centre, panels_[at->second].centre); apart < within)
                        call(at->second, apart);
            }
    }

private:
    using Cube = std::array<long, 3>;
    using Place = std::pair<Cube, std::uint32_t>;
    [[nodiscard]] Cube cube(Vec3 p) const {
        return {std::lround(p.x / reach_), std::lround(p.y / reach_), std::lround(p.z / reach_)};
    }
    const std::vector<Panel>& panels_;
    double reach_;
    std::vector<Place> order_;
};

}  // namespace

DenseMatrix boundary_matrix(const Body& body, const Kernel& kernel) {
    const std::vector<Panel>& panels = body.panels;
    Vec3 origin;
    for (const Panel& panel : panels) origin = origin + panel.centre * (1.0 / static_cast<double>(panels.size()));
    KernelPoints centres;
    for (const Panel& panel : panels) centres.add(panel.centre - origin, panel.normal, panel.area);
    centres.pad();
    const Neighbours neighbours(panels, near_edges * body.longest_edge());
    DenseMatrix matrix(panels.size(), panels.size(), centres.x.size());
    for (std::uint32_t j = 0; j < panels.size(); ++j) {
        const Panel& panel = panels[j];
        std::complex<float>* const column = matrix.column(j);
        kernel_column(kernel, centres, panel.centre - origin, panel.normal, panel.area, column);
        const auto& [a, b, c] = body.mesh.triangles[j];
        const Corners corners{body.mesh.vertices[a], body.mesh.vertices[b], body.mesh.vertices[c]};
        PanelPoints points(corners, origin, panel);
        neighbours.each(panel.centre, near_edges * panel.longest_edge, [&](std::uint32_t i, double apart) {
            if (i != j) column[i] = -kernel_sum(kernel, points.at(apart), panels[i].centre - origin, panels[i].normal);
        });
        const Complex own = Complex(0.0, -kernel.coupling_m) * own_panel(corners, panel.centre, kernel.wave_number);
        column[j] = std::complex<float>(0.5 - own);
    }
    return matrix;
}

}  // namespace haptogram::scattering
