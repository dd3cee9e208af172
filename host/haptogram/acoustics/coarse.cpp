// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/coarse.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace haptogram {
namespace {

constexpr std::size_t taps = interpolation_taps;
constexpr std::size_t half = taps / 2;
constexpr std::size_t padding = 64;  ///< coordinates that vectors may reach beyond the last one; no vector has more

using Weights = std::array<double, taps>;

double sinc(double x) { return std::abs(x) < 1e-6 ? 1.0 : std::sin(x) / x; }

using Matrix = Eigen::Matrix<double, taps, taps>;
using Vector = Eigen::Matrix<double, taps, 1>;

/// Of the matrix sinc(κ₀(t − s)).
Eigen::LLT<Matrix> factors() {
    return Matrix::NullaryExpr([](Eigen::Index i, Eigen::Index j) {
               // On the diagonal more, by less than the error that is wanted and more than rounding: it keeps the roots
               // real.
               return sinc(widest_band * static_cast<double>(i - j)) + (i == j ? 1e-13 : 0.0);
           })
        .llt();
}

/// The weights that interpolate between tap half − 1 and tap half, at a fraction of a step behind the former, with the
/// least mean square error over all waves of up to widest_band. Wave e^{jκt} has the error e^{jκf} − Σ c_t·e^{jκt}. The
/// mean of its square over κ is least where Σ_s sinc(κ₀(t − s))·c_s = sinc(κ₀(t − f)) for every t, with κ₀ =
/// widest_band.
Weights weights_at(double fraction, const Eigen::LLT<Matrix>& factors) {
    const Vector c = factors.solve(Vector::NullaryExpr([fraction](Eigen::Index i) {
        return sinc(widest_band * (static_cast<double>(i) - static_cast<double>(half - 1) - fraction));
    }));
    Weights weights{};
    std::copy(c.begin(), c.end(), weights.begin());
    return weights;
}

/// The same, quickly: by straight lines between fractions so near to each other that they are off by 3e-7 at most.
class WeightTable {
public:
    WeightTable() {
        const Eigen::LLT<Matrix> of_taps = factors();
        for (std::size_t i = 0; i <= steps; ++i)
            at_.push_back(weights_at(static_cast<double>(i) / static_cast<double>(steps), of_taps));
    }

    [[nodiscard]] Weights operator()(double fraction) const {
        const double place = fraction * static_cast<double>(steps);
        const std::size_t low = std::min(steps - 1, static_cast<std::size_t>(place));
        const double part = place - static_cast<double>(low);
        Weights found;
        for (std::size_t t = 0; t < taps; ++t) found[t] = at_[low][t] + part * (at_[low + 1][t] - at_[low][t]);
        return found;
    }

private:
    static constexpr std::size_t steps = 2048;
    std::vector<Weights> at_;
};

CoarseAxis sized(std::size_t size, std::size_t taps_each) {
    CoarseAxis found;
    found.taps = taps_each;
    found.size = size;
    found.stride = size + padding;
    found.first.resize(found.stride);
    found.re.resize(taps_each * found.stride);
    found.im.resize(taps_each * found.stride);
    return found;
}

/// Whether coordinates rise by one and the same step, to a nanometre.
bool rises_evenly(const std::vector<double>& axis) {
    if (axis.size() < 2) return false;
    const double step = (axis.back() - axis.front()) / static_cast<double>(axis.size() - 1);
    for (std::size_t i = 0; i < axis.size(); ++i)
        if (!(std::abs(axis[i] - axis.front() - static_cast<double>(i) * step) <= 1e-9)) return false;
    return step > 1e-9;
}

struct Interval {
    double low, high;
    [[nodiscard]] double nearest_square() const {  // of the distance from 0
        const double d = std::max({0.0, low, -high});
        return d * d;
    }
    [[nodiscard]] double furthest_square() const { return std::max(low * low, high * high); }
};

/// The box around a grid, by axis.
using Box = std::array<Interval, 3>;

Box box_of(const Grid& grid) {
    const auto interval = [](const std::vector<double>& axis) {
        const auto [low, high] = std::minmax_element(axis.begin(), axis.end());
        return Interval{*low, *high};
    };
    return {interval(grid.x), interval(grid.y), interval(grid.z)};
}

Box seen_from(const Element& element, const Box& box) {
    const std::array<double, 3> at{element.position.x, element.position.y, element.position.z};
    Box seen = box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        seen[axis].low -= at[axis];
        seen[axis].high -= at[axis];
    }
    return seen;
}

/// Least distance of the box from any element.
double gap_of(const Array& array, const Box& box) {
    double least = std::numeric_limits<double>::infinity();
    for (const Element& element : array.elements) {
        const Box seen = seen_from(element, box);
        least = std::min(least, seen[0].nearest_square() + seen[1].nearest_square() + seen[2].nearest_square());
    }
    return std::sqrt(least);
}

/// The cosines of the angles between an axis and the waves from all elements to all points of the box.
Interval cosines(const Array& array, const Box& box, std::size_t axis) {
    Interval found{1.0, -1.0};
    for (const Element& element : array.elements) {
        const Box seen = seen_from(element, box);
        const Interval &along = seen[axis], &u = seen[(axis + 1) % 3], &v = seen[(axis + 2) % 3];
        const double near = u.nearest_square() + v.nearest_square(), far = u.furthest_square() + v.furthest_square();
        // The cosine a/√(a² + b²) grows with a; it grows with b where a is negative, and falls where it is positive.
        const auto cosine = [](double a, double square) { return a / std::sqrt(a * a + square); };
        found.low = std::min(found.low, cosine(along.low, along.low > 0.0 ? far : near));
        found.high = std::max(found.high, cosine(along.high, along.high > 0.0 ? near : far));
    }
    return found;
}

/// The waves are spherical, so along a few coarse steps their direction changes. This much more band leaves room for
/// it.
constexpr double margin = 0.05;
/// A step that is hardly wider than the grid's own saves nothing.
constexpr double least_gain = 1.25;

}  // namespace

CoarseAxis kept_axis(const std::vector<double>& axis) {
    CoarseAxis found = sized(axis.size(), 1);
    found.coarse = axis;
    for (std::size_t i = 0; i < found.stride; ++i)
        found.first[i] = static_cast<std::int32_t>(std::min(i, axis.empty() ? 0 : axis.size() - 1));
    std::fill_n(found.re.begin(), axis.size(), 1.0F);
    return found;
}

CoarseAxis part_of(const CoarseAxis& axis, std::size_t begin, std::size_t end) {
    CoarseAxis found = sized(end - begin, axis.taps);
    const std::int32_t low = axis.first[begin], high = axis.first[end - 1] + static_cast<std::int32_t>(axis.taps);
    found.coarse.assign(axis.coarse.begin() + low, axis.coarse.begin() + high);
    for (std::size_t i = 0; i < found.stride; ++i) found.first[i] = axis.first[std::min(begin + i, end - 1)] - low;
    for (std::size_t t = 0; t < axis.taps; ++t)
        for (std::size_t i = 0; i < found.size; ++i) {
            found.re[t * found.stride + i] = axis.re[t * axis.stride + begin + i];
            found.im[t * found.stride + i] = axis.im[t * axis.stride + begin + i];
        }
    return found;
}

CoarseAxis interpolated_axis(const std::vector<double>& axis, Band band, double step_m, double origin_m) {
    static const WeightTable table;
    CoarseAxis found = sized(axis.size(), taps);
    const auto steps = [&](double at) { return (at - origin_m) / step_m; };
    const double begin = std::floor(steps(axis.front())) - static_cast<double>(half - 1);
    const double end = std::floor(steps(axis.back())) + static_cast<double>(half) + 1.0;
    for (double i = begin; i < end; ++i) found.coarse.push_back(origin_m + i * step_m);

    // The taps are made for a band around 0, so the middle of the band is turned to 0 and back again.
    const double turn = -(band.low + band.high) / 2.0 * step_m;  // e^{−jκx} falls behind as x grows
    std::array<std::complex<double>, taps> turned;
    for (std::size_t t = 0; t < taps; ++t)
        turned[t] = std::polar(1.0, turn * (static_cast<double>(half - 1) - static_cast<double>(t)));
    for (std::size_t i = 0; i < axis.size(); ++i) {
        const double at = steps(axis[i]), whole = std::floor(at);
        found.first[i] = static_cast<std::int32_t>(whole - static_cast<double>(half - 1) - begin);
        const Weights weights = table(at - whole);
        if (turn == 0.0) {
            for (std::size_t t = 0; t < taps; ++t) found.re[t * found.stride + i] = static_cast<float>(weights[t]);
            continue;
        }
        const std::complex<double> back = std::polar(1.0, turn * (at - whole));
        for (std::size_t t = 0; t < taps; ++t) {
            const std::complex<double> weight = weights[t] * back * turned[t];
            found.re[t * found.stride + i] = static_cast<float>(weight.real());
            found.im[t * found.stride + i] = static_cast<float>(weight.imag());
        }
    }
    std::fill(found.first.begin() + static_cast<std::ptrdiff_t>(axis.size()), found.first.end(),
              found.first[axis.size() - 1]);
    return found;
}

std::optional<CoarseGrid> find_coarse_grid(const Array& array, const Grid& grid) {
    if (array.elements.empty() || grid.size() < 256) return {};
    const double wavelength = array.wavelength_m(), k = 2.0 * std::numbers::pi / wavelength;
    Box box = box_of(grid);
    // Nearer, there are parts of the field that do not travel and change faster. Negated, so that NaN ends here, too.
    if (!(gap_of(array, box) >= 2.5 * wavelength)) return {};

    const std::array<const std::vector<double>*, 3> axes{&grid.x, &grid.y, &grid.z};
    const Vec3 e = array.elements.front().position;
    const std::array<double, 3> origins{e.x, e.y, e.z};
    std::array<double, 3> pitches{};
    if (array.columns > 1 && array.elements.size() > 1) pitches[0] = array.elements[1].position.x - e.x;
    if (array.columns > 0 && array.elements.size() > array.columns)
        pitches[1] = array.elements[array.columns].position.y - e.y;

    std::array<CoarseAxis, 3> found;
    bool any = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::vector<double>& wanted = *axes[axis];
        found[axis] = kept_axis(wanted);
        if (!rises_evenly(wanted)) continue;
        const double own_step = (wanted.back() - wanted.front()) / static_cast<double>(wanted.size() - 1);
        // The coarse axis reaches beyond the grid. What it takes in there counts, too.
        const auto with_step = [&](double step) {
            Box wider = box;
            wider[axis].low -= static_cast<double>(half) * step;
            wider[axis].high += static_cast<double>(half) * step;
            return wider;
        };
        Band band;
        const auto step_in = [&](const Box& where) {
            const Interval cosine = cosines(array, where, axis);
            band = {k * std::max(cosine.low - margin, -1.0 - margin), k * std::min(cosine.high + margin, 1.0 + margin)};
            if (axis < 2) {  // real weights take half the time of complex ones; along z they are few
                const double most = std::max(std::abs(band.low), std::abs(band.high));
                band = {-most, most};
            }
            return 2.0 * widest_band / (band.high - band.low);
        };
        double step = step_in(with_step(step_in(box)));
        if (pitches[axis] > 0.0) step = pitches[axis] / std::ceil(pitches[axis] / step);
        while (step >= least_gain * own_step && !(gap_of(array, with_step(step)) >= wavelength)) step *= 0.8;
        if (step < least_gain * own_step) continue;
        CoarseAxis coarse = interpolated_axis(wanted, band, step, origins[axis]);
        if (coarse.coarse.size() >= wanted.size()) continue;
        found[axis] = std::move(coarse);
        box = with_step(step);
        any = true;
    }
    if (!any) return {};
    return CoarseGrid{std::move(found[0]), std::move(found[1]), std::move(found[2])};
}

}  // namespace haptogram
