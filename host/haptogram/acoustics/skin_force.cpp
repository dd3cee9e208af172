// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/skin_force.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

std::vector<DiscNode> disc_nodes(double diameter_m, double wavelength_m) {
    const unsigned rings = 3 + static_cast<unsigned>(std::ceil(1.2 * diameter_m / wavelength_m));
    const unsigned around = 4 * (rings - 1);
    std::vector<DiscNode> nodes;
    for (unsigned i = 0; i < rings; ++i) {
        // Newton's method finds the roots of the Legendre polynomial P; P' = n·(x·P − P₋₁)/(x² − 1).
        double root = std::cos(std::numbers::pi * (i + 0.75) / (rings + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; ++step) {
            const double value = std::legendre(rings, root);
            slope = rings * (root * value - std::legendre(rings - 1, root)) / (root * root - 1.0);
            root -= value / slope;
        }
        const double part = (1.0 + root) / 2.0;  // of the radius; the area grows with 2·part
        const double weight = 2.0 * part / ((1.0 - root * root) * slope * slope) / around;
        for (unsigned j = 0; j < around; ++j) {
            const double angle = 2.0 * std::numbers::pi * (j + 0.5 * (i % 2)) / around, r = diameter_m / 2.0 * part;
            nodes.push_back({r * std::cos(angle), r * std::sin(angle), weight});
        }
    }
    return nodes;
}

double radiation_pressure(const PatchSound& sound, const Medium& medium) {
    return (std::norm(sound.pressure) - std::norm(sound.along) - std::norm(sound.across)) /
           (medium.density_kg_m3 * medium.speed_m_s * medium.speed_m_s);
}

std::vector<PatchSound> waves_at_patch(const Array& array, Vec3 point, Vec3 normal) {
    const double length = norm(normal);
    if (!(length > 0.0 && std::isfinite(length)))
        throw bad_argument("normal", fmt::format("({:g}, {:g}, {:g}) is no direction; expected three numbers of which "
                                                 "one is not 0, such as 0,0,-1 for skin that faces the array",
                                                 normal.x, normal.y, normal.z));
    const Vec3 out = normal * (1.0 / length);
    // Any direction that is not nearly the normal's leads to two directions along the skin.
    const Vec3 other = std::abs(out.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    Vec3 along = other - out * dot(other, out);
    along = along * (1.0 / norm(along));
    const Vec3 across = cross(out, along);
    std::vector<PatchSound> waves;
    waves.reserve(array.elements.size());
    for (const Element& element : array.elements) {
        const std::complex<double> wave = propagation(array, element, point);
        const Vec3 way = (point - element.position) * (1.0 / distance(element, point));
        if (dot(way, out) < 0.0)
            waves.push_back({wave, dot(way, along) * wave, dot(way, across) * wave});
        else
            waves.emplace_back();
    }
    return waves;
}

PatchSound sound_at_patch(std::span<const PatchSound> waves, std::span<const std::complex<double>> drives) {
    PatchSound sum;
    for (std::size_t m = 0; m < waves.size(); ++m)
        sum += {drives[m] * waves[m].pressure, drives[m] * waves[m].along, drives[m] * waves[m].across};
    return sum;
}

namespace {

using Matrix = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Row = Eigen::RowVectorXcd;

/// Calls visit(weight, waves) for the nodes of a disc on the skin; the weights sum to its area.
template <class Visit>
void at_nodes(const Array& array, const SkinPlace& place, double diameter_m, Visit visit) {
    const Vec3 out = place.normal * (1.0 / norm(place.normal));
    const Vec3 other = std::abs(out.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    Vec3 along = other - out * dot(other, out);
    along = along * (1.0 / norm(along));
    const Vec3 across = cross(out, along);
    const double area = std::numbers::pi * diameter_m * diameter_m / 4.0;
    for (const DiscNode& node : disc_nodes(diameter_m, array.wavelength_m()))
        visit(area * node.weight, waves_at_patch(array, place.position + along * node.x + across * node.y, out));
}

/// The force on a disc as Σ sign·|row·drives|²: a few rows say what hundreds of sounds at the disc's nodes do, because
/// neighbouring places of a sound field depend on each other.
struct ForceRows {
    Eigen::VectorXd factors;  ///< N/(Pa·m)²
    Matrix rows;
};

/// An orthonormal basis of some rows, but for parts below 1e-9 of the largest: Gram and Schmidt's method, which takes
/// the row next of which most is left.
Matrix basis_of(Matrix left) {
    Matrix basis(std::min(left.rows(), left.cols()), left.cols());
    const double largest = left.rowwise().squaredNorm().maxCoeff();
    Eigen::Index count = 0;
    for (; count < basis.rows(); ++count) {
        Eigen::Index at = 0;
        if (!(left.rowwise().squaredNorm().maxCoeff(&at) > 1e-18 * largest)) break;
        Row next = left.row(at);
        // Once more against all before, as rounding leaves some of them.
        next -= (next * basis.topRows(count).adjoint()) * basis.topRows(count);
        basis.row(count) = next.normalized();
        const Eigen::VectorXcd parts = left * basis.row(count).adjoint();
        left.noalias() -= parts * basis.row(count);
    }
    return basis.topRows(count);
}

ForceRows force_rows(const Array& array, const SkinPlace& place, double diameter_m) {
    std::vector<Row> sounds, grazing;
    const auto count = static_cast<Eigen::Index>(array.elements.size());
    at_nodes(array, place, diameter_m, [&](double weight, const std::vector<PatchSound>& waves) {
        Row pressure(count), along(count), across(count);
        for (Eigen::Index m = 0; m < count; ++m) {
            const PatchSound& wave = waves[static_cast<std::size_t>(m)];
            pressure[m] = std::sqrt(weight) * wave.pressure;
            along[m] = std::sqrt(weight) * wave.along;
            across[m] = std::sqrt(weight) * wave.across;
        }
        sounds.push_back(std::move(pressure));
        grazing.push_back(std::move(along));
        grazing.push_back(std::move(across));
    });
    const auto stacked = [count](const std::vector<Row>& rows) {
        Matrix all(static_cast<Eigen::Index>(rows.size()), count);
        for (std::size_t i = 0; i < rows.size(); ++i) all.row(static_cast<Eigen::Index>(i)) = rows[i];
        return all;
    };
    const Matrix plus = stacked(sounds), minus = stacked(grazing);
    Matrix all(plus.rows() + minus.rows(), count);
    all << plus, minus;
    const Matrix basis = basis_of(std::move(all));
    if (basis.rows() == 0) return {};  // the skin faces away from every element
    // In the basis the force is a Hermitian form; its eigenvectors make it a sum of squares.
    const Matrix of_plus = plus * basis.adjoint(), of_minus = minus * basis.adjoint();
    const Eigen::MatrixXcd form = of_plus.adjoint() * of_plus - of_minus.adjoint() * of_minus;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> parts(form);
    // What is left out is below 1e-10 of the largest force that drives of one power can make.
    const Eigen::VectorXd& sizes = parts.eigenvalues();
    const double least = 1e-10 * sizes.cwiseAbs().maxCoeff();
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < sizes.size(); ++i)
        if (std::abs(sizes[i]) > least) kept.push_back(i);
    const PatchSound one{1.0, 0.0, 0.0};
    return {radiation_pressure(one, array.medium) * sizes(kept),
            parts.eigenvectors()(Eigen::all, kept).adjoint() * basis};
}

}  // namespace

SkinForce force_on_skin(const Array& array, const DriveSequence& sequence, const SkinPlace& place, double diameter_m) {
    if (!is_finite(place.position)) throw bad_argument("at", "a coordinate is not finite");
    if (!(diameter_m > 0.0 && diameter_m <= widest_contact_m))
        throw bad_argument("contact", fmt::format("must be above 0 and no more than the {:g} mm of a hand, found {:g}",
                                                  widest_contact_m / millimetre, diameter_m / millimetre));
    const std::uint64_t periods = sequence.periods();
    if (periods == 0) throw bad_input("sequence", "nothing is played; there is nothing to feel");
    const double bandwidth_hz = array.transducer.bandwidth_hz;
    SkinForce felt;
    felt.pressure_pa.resize(periods);
    felt.force_n.resize(periods);
    const std::vector<PatchSound> waves = waves_at_patch(array, place.position, place.normal);
    std::vector<PatchSound> sounds;
    for (const auto& drives : sequence.drives) sounds.push_back(sound_at_patch(waves, drives));
    follow(sequence, bandwidth_hz, sounds, [&](std::uint64_t period, const PatchSound& sound) {
        felt.pressure_pa[period] = radiation_pressure(sound, array.medium);
    });
    const Vec3 out = place.normal * (1.0 / norm(place.normal));
    const double range = norm(place.position);
    const double cosine = range > 0.0 ? -dot(place.position, out) / range : 0.0;
    felt.tilt = cosine > 0.0 ? cosine * cosine : 0.0;

    const ForceRows form = force_rows(array, place, diameter_m);
    // Several rows at a time, their real and imaginary parts apart: the processor adds such numbers in pairs.
    constexpr Eigen::Index at_once = 8;
    using Some = Eigen::Array<double, 2 * at_once, 1>;
    for (Eigen::Index first = 0; first < form.rows.rows(); first += at_once) {
        const Eigen::Index count = std::min(at_once, form.rows.rows() - first);
        Some factors = Some::Zero();
        factors.segment(0, count) = factors.segment(at_once, count) = form.factors.segment(first, count).array();
        std::vector<Some> wanted(sequence.drives.size(), Some::Zero());
        for (std::size_t set = 0; set < wanted.size(); ++set) {
            const auto& drives = sequence.drives[set];
            const Eigen::Map<const Eigen::VectorXcd> of_set(drives.data(), static_cast<Eigen::Index>(drives.size()));
            const Eigen::VectorXcd values = form.rows.middleRows(first, count) * of_set;
            wanted[set].segment(0, count) = values.real().array();
            wanted[set].segment(at_once, count) = values.imag().array();
        }
        follow(sequence, bandwidth_hz, wanted, [&](std::uint64_t period, const Some& value) {
            felt.force_n[period] += (factors * value * value).sum();
        });
    }
    return felt;
}

double steady_force(const Array& array, std::span<const std::complex<double>> drives, Vec3 place) {
    double force = 0.0;
    at_nodes(array, {place}, default_contact_m, [&](double weight, const std::vector<PatchSound>& waves) {
        force += weight * radiation_pressure(sound_at_patch(waves, drives), array.medium);
    });
    return force;
}

double full_force(const Array& array, Vec3 focus) {
    if (const std::string why = array.unreachable(focus); !why.empty()) throw impossible("focus", why);
    return steady_force(array, ideal_drives(array, focus), focus);
}

double modulation_depth(const std::vector<double>& signal) {
    if (signal.empty()) return 0.0;
    const auto [least, largest] = std::minmax_element(signal.begin(), signal.end());
    return *largest + *least > 0.0 ? (*largest - *least) / (*largest + *least) : 0.0;
}

}  // namespace haptogram
