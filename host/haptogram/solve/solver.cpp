// SPDX-License-Identifier: Apache-2.0
#include "haptogram/solve/solver.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/solve/drives.hpp"

namespace haptogram {
namespace {

using Complex = std::complex<double>;
using Vector = std::vector<Complex>;

double wave_number(const Array& array) { return 2.0 * std::numbers::pi / array.wavelength_m(); }

Error bad_focus(std::size_t i, Vec3 at, const std::string& what) {
    return bad_input(fmt::format("focus {}", i + 1), fmt::format("({:g}, {:g}, {:g}) mm {}", at.x / millimetre,
                                                                 at.y / millimetre, at.z / millimetre, what));
}

Error unreachable(std::size_t i, Vec3 at) {
    return bad_focus(i, at, "cannot be reached by any element: it is behind all of them");
}

/// The foci that ask for something, after all have been checked. The others are nulls.
std::vector<Focus> checked(const Array& array, std::span<const Focus> foci) {
    constexpr double same_place_wavelengths = 1e-3;
    std::vector<Focus> asked;
    for (std::size_t i = 0; i < foci.size(); ++i) {
        const auto [at, amplitude] = foci[i];
        if (!is_finite(at)) throw bad_focus(i, at, "is not finite; every coordinate must be a number");
        if (!(amplitude >= 0.0 && amplitude <= 1.0))
            throw bad_focus(i, at, fmt::format("has the amplitude {}; expected 0 to 1", amplitude));
        for (std::size_t m = 0; m < array.elements.size(); ++m)
            if (distance(array.elements[m], at) == 0.0)
                throw bad_focus(i, at, fmt::format("coincides with element {}; move it", m + 1));
        for (std::size_t j = 0; j < i; ++j)
            if (distance(foci[j].position, at) < same_place_wavelengths * array.wavelength_m())
                throw bad_focus(i, at, fmt::format("is where focus {} is; leave one of them out", j + 1));
        if (amplitude > 0.0) asked.push_back(foci[i]);
    }
    if (asked.empty()) throw bad_argument("foci", "there is none with an amplitude above 0; expected at least one");
    if (foci.size() > array.elements.size())
        throw bad_input("foci", fmt::format("{} foci for {} elements; expected at most as many foci as elements",
                                            foci.size(), array.elements.size()));
    return asked;
}

/// Those of amplitude 0, where pressure is held down.
std::vector<Focus> nulls_among(std::span<const Focus> foci) {
    std::vector<Focus> nulls;
    std::copy_if(foci.begin(), foci.end(), std::back_inserter(nulls),
                 [](const Focus& f) { return f.amplitude == 0.0; });
    return nulls;
}

double largest_amplitude(std::span<const Focus> foci) {
    return std::max_element(foci.begin(), foci.end(),
                            [](const Focus& a, const Focus& b) { return a.amplitude < b.amplitude; })
        ->amplitude;
}

/// a·conj(b) and a·b, without the C++ library's care for infinities, which costs most of the time.
Complex times_conj(Complex a, Complex b) {
    return {a.real() * b.real() + a.imag() * b.imag(), a.imag() * b.real() - a.real() * b.imag()};
}
Complex times(Complex a, Complex b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.imag() * b.real() + a.real() * b.imag()};
}
Complex direction(Complex a) {
    const double length = std::sqrt(a.real() * a.real() + a.imag() * a.imag());
    return length > 0.0 ? a / length : Complex(0.0);
}
double size(Complex a) { return std::sqrt(a.real() * a.real() + a.imag() * a.imag()); }

/// The positive definite system G·y = b; G is K × K, row by row, Hermitian.
Vector solve_positive(const Vector& g, Vector b) {
    using Matrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto n = static_cast<Eigen::Index>(b.size());
    Eigen::Map<Eigen::VectorXcd> unknown(b.data(), n);
    Eigen::Map<const Matrix>(g.data(), n, n).llt().solveInPlace(unknown);
    return b;
}

/// The foci as equal ones: propagation over each focus' target, so that all are to have the same |p|.
class Problem {
public:
    Problem(const Array& array, std::span<const Focus> foci, std::span<const Focus> nulls, Level level, bool amplitudes)
        : foci_(foci.size()), nulls_(nulls.size()), elements_(array.elements.size()), amplitudes_(amplitudes) {
        a_.reserve((foci_ + nulls_) * elements_);
        const auto add_row = [&](Vec3 position) {
            double reach = 0.0;
            for (const Element& element : array.elements) {
                a_.push_back(propagation(array, element, position));
                reach += size(a_.back());
            }
            return reach;
        };
        const auto divide_row = [&](double by) {
            for (std::size_t m = a_.size() - elements_; m < a_.size(); ++m) a_[m] /= by;
        };
        for (const Focus& focus : foci) {
            const double reach = add_row(focus.position);
            if (reach == 0.0) throw unreachable(static_cast<std::size_t>(&focus - foci.data()), focus.position);
            const double target = focus.amplitude * (level == Level::reachable ? reach : 1.0);
            reaches_.push_back(reach);
            targets_.push_back(target);
            divide_row(target);
            // Without weights every method drives a focus in proportion to its target: t for the target, and t for the
            // row that has been divided by it.
            weights_.push_back(target * target);
        }
        const double mean = mean_of(weights_);
        for (double& weight : weights_) weight /= mean;
        // Pressure at a null counts as much as that at the strongest focus. Where no element reaches, it is 0 anyway.
        const double strongest = largest_amplitude(foci);
        for (const Focus& null : nulls) {
            const double reach = add_row(null.position);
            if (reach > 0.0) divide_row(strongest * (level == Level::reachable ? reach : 1.0));
        }
    }

    /// Drives from coefficients of the foci: Aᴴ·(weight·c), to phases or as it is.
    void back(const Vector& c) {
        x_.assign(elements_, 0.0);
        for (std::size_t k = 0; k < foci_; ++k) {
            const Complex factor = weights_[k] * c[k];
            for (std::size_t m = 0; m < elements_; ++m) x_[m] += times_conj(factor, at(k, m));
        }
        if (!amplitudes_)
            for (Complex& drive : x_) drive = direction(drive);
    }
    void begin(std::span<const Complex> drives) { x_.assign(drives.begin(), drives.end()); }

    /// Pressures over targets.
    [[nodiscard]] Vector forth() const {
        Vector p(foci_);
        for (std::size_t k = 0; k < foci_; ++k)
            for (std::size_t m = 0; m < elements_; ++m) p[k] += times(at(k, m), x_[m]);
        return p;
    }

    /// Weights grow where |p| is below its mean. A focus that nearly vanished does not grow more than a thousandfold.
    /// With two or three foci the drives answer to weights so strongly that |p| would swing from one side to the other,
    /// so there they grow with half the power.
    void reweigh(const Vector& p) {
        double mean = 0.0;
        for (const Complex& one : p) mean += size(one) / static_cast<double>(foci_);
        for (std::size_t k = 0; k < foci_; ++k) {
            const double growth = mean / std::max(size(p[k]), 1e-3 * mean);
            weights_[k] *= foci_ > 3 ? growth : std::sqrt(growth);
        }
        const double level = mean_of(weights_);
        for (double& weight : weights_) weight /= level;
    }

    /// A step of Gauss and Newton to equal |p|, with the least change of phases, or of drives where amplitudes are
    /// free. All |p| go to their mean, weighted by what the foci cost, and p at the nulls to 0.
    void equalise() {
        const Vector p = forth();
        double level = 0.0, sum = 0.0;
        for (std::size_t k = 0; k < foci_; ++k) {
            level += weights_[k] * size(p[k]);
            sum += weights_[k];
        }
        level /= sum;
        // Row k of J: what changes p_k along its own direction. For phases θ it is d|p_k|/dθ = Im(conj(u_k·…)), real.
        // A null has no direction: both parts of its p are to go, which are two rows for real phases.
        const std::size_t rows = foci_ + (amplitudes_ ? nulls_ : 2 * nulls_);
        Vector j(rows * elements_), wanted(rows);
        for (std::size_t k = 0; k < foci_; ++k) {
            const Complex u = direction(p[k]);
            for (std::size_t m = 0; m < elements_; ++m)
                j[k * elements_ + m] =
                    amplitudes_ ? times_conj(at(k, m), u) : Complex(-times_conj(times(at(k, m), x_[m]), u).imag());
        }
        for (std::size_t k = 0; k < foci_; ++k) wanted[k] = level - size(p[k]);
        for (std::size_t n = 0; n < nulls_; ++n) {
            Complex there = 0.0;
            const std::size_t row = foci_ + (amplitudes_ ? n : 2 * n);
            for (std::size_t m = 0; m < elements_; ++m) {
                const Complex part = times(at(foci_ + n, m), x_[m]);
                there += part;
                j[row * elements_ + m] = amplitudes_ ? at(foci_ + n, m) : Complex(-part.imag());
                if (!amplitudes_) j[(row + 1) * elements_ + m] = part.real();
            }
            wanted[row] = amplitudes_ ? -there : Complex(-there.real());
            if (!amplitudes_) wanted[row + 1] = -there.imag();
        }
        Vector g(rows * rows);
        double trace = 0.0;
        for (std::size_t k = 0; k < rows; ++k) {
            for (std::size_t l = 0; l <= k; ++l) {
                Complex sum_of_row = 0.0;
                for (std::size_t m = 0; m < elements_; ++m)
                    sum_of_row += times_conj(j[k * elements_ + m], j[l * elements_ + m]);
                g[k * rows + l] = sum_of_row;
            }
            trace += g[k * rows + k].real();
        }
        // A little damping: two foci within a wavelength have nearly the same rows. Where all phases are the best for
        // each focus already, as for a lone one, the rows are nothing but rounding, and damping that follows them would
        // be, too. So it does not fall below a part of the sum of squares that pressures of this size need at least.
        constexpr double damping = 1e-4, least_damping = 1e-8;
        double squares = 0.0;
        for (const Complex& one : p) squares += times_conj(one, one).real();
        const double damped = std::max(damping * trace, least_damping * squares / static_cast<double>(elements_)) /
                              static_cast<double>(rows);
        for (std::size_t k = 0; k < rows; ++k) g[k * rows + k] += damped;
        const Vector y = solve_positive(g, std::move(wanted));
        for (std::size_t m = 0; m < elements_; ++m) {
            Complex change = 0.0;
            for (std::size_t k = 0; k < rows; ++k) change += times_conj(y[k], j[k * elements_ + m]);
            if (amplitudes_) {
                x_[m] += change;
            } else {
                const double half =
                    0.5 * change.real();  // (1 + jh)/(1 − jh) turns without changing the length (Cayley)
                x_[m] = times(x_[m], Complex(1.0 - half * half, 2.0 * half) / (1.0 + half * half));
            }
        }
    }

    /// A·Aᴴ, K × K.
    [[nodiscard]] Vector gram() const {
        Vector g(foci_ * foci_);
        for (std::size_t k = 0; k < foci_; ++k)
            for (std::size_t l = 0; l < foci_; ++l)
                for (std::size_t m = 0; m < elements_; ++m) g[k * foci_ + l] += times_conj(at(k, m), at(l, m));
        return g;
    }

    /// That `drives` make some pressure at each focus, and not nothing or what is no number.
    void require_pressure(std::span<const Focus> foci, std::span<const Complex> drives) {
        constexpr double least = 1e-6;  // of what the focus asks for
        begin(drives);
        const Vector p = forth();
        for (std::size_t k = 0; k < foci_; ++k)
            if (!(size(p[k]) > least * foci[k].amplitude * reaches_[k] / targets_[k]))
                throw Error(ErrorCode::failed, "solver",
                            fmt::format("the drives that were found make no pressure at the focus ({:g}, {:g}, {:g}) "
                                        "mm, where some was asked for; move it, or take another solver",
                                        foci[k].position.x / millimetre, foci[k].position.y / millimetre,
                                        foci[k].position.z / millimetre),
                            {"solver"});
    }

    [[nodiscard]] const std::vector<double>& weights() const { return weights_; }
    [[nodiscard]] Vector&& take() { return std::move(x_); }

private:
    [[nodiscard]] Complex at(std::size_t k, std::size_t m) const { return a_[k * elements_ + m]; }
    static double mean_of(const std::vector<double>& values) {
        double sum = 0.0;
        for (const double value : values) sum += value;
        return sum / static_cast<double>(values.size());
    }

    std::size_t foci_, nulls_, elements_;
    bool amplitudes_;
    Vector a_, x_;  ///< propagation over targets, row by row, those of the nulls last, and the drives
    std::vector<double> weights_, reaches_, targets_;
};

Vector directions(const Vector& p) {
    Vector u;
    for (const Complex& one : p) u.push_back(direction(one));
    return u;
}

Vector iterated(Problem& problem, std::span<const Focus> foci, bool nulls, const SolveOptions& options,
                std::span<const Complex> start) {
    const unsigned rounds = options.rounds.value_or(options.method == Method::gauss_newton ? 10 : 100);
    Vector c(foci.size(), 1.0);
    if (!start.empty()) {
        problem.begin(start);
        const Vector p = problem.forth();
        c = directions(p);
    }
    if (options.method == Method::gs_pat) {
        const Vector gram = problem.gram();
        Vector y(c.size());
        for (unsigned round = 0; round < rounds; ++round) {
            for (std::size_t k = 0; k < c.size(); ++k) {
                y[k] = 0.0;
                for (std::size_t l = 0; l < c.size(); ++l)
                    y[k] += times(gram[k * c.size() + l], problem.weights()[l] * c[l]);
            }
            c = directions(y);
        }
        // The last step also scales: what came out too strong is driven less.
        if (rounds > 0)
            for (std::size_t k = 0; k < c.size(); ++k) c[k] = c[k] / size(y[k]);
        problem.back(c);
        return problem.take();
    }
    problem.back(c);
    for (unsigned round = 0; round < rounds; ++round) {
        const Vector p = problem.forth();
        if (options.method != Method::gs) problem.reweigh(p);
        problem.back(directions(p));
    }
    // Two or three foci may not be even yet after the rounds, and a step costs little then. A null a quarter of a
    // wavelength from a focus needs eight.
    const int steps = nulls ? 8 : foci.size() > 3 ? 1 : 3;
    if (options.method == Method::gauss_newton)
        for (int step = 0; step < steps; ++step) problem.equalise();
    return problem.take();
}

/// Fingers: Σ over the foci of distance · e^{jk·distance}.
Vector distance_weighted(const Array& array, std::span<const Focus> foci) {
    const double k = wave_number(array);
    Vector drives(array.elements.size());
    for (const Focus& focus : foci)
        for (std::size_t m = 0; m < drives.size(); ++m) {
            const double range = distance(array.elements[m], focus.position);
            drives[m] += array.elements[m].aligning() * std::polar(focus.amplitude * range, k * range);
        }
    return drives;
}

/// Hoshi: the foci lie at (x, y) around a point on the array's axis, at their mean height r. Drives for that point
/// alone are multiplied by the inverse transform of the foci, Σ amplitude · e^{−jk(x·X + y·Y)/r} at the element (X, Y).
Vector inverse_transform(const Array& array, std::span<const Focus> foci) {
    const double plane = array.elements.front().position.z;
    Vec3 middle{};
    for (const Element& element : array.elements) {
        if (element.position.z != plane)
            throw bad_argument("solver", "inverse-transform needs an array whose elements have one z; take another");
        middle = middle + element.position * (1.0 / static_cast<double>(array.elements.size()));
    }
    middle.z = 0.0;
    for (const Focus& focus : foci) middle.z += focus.position.z / static_cast<double>(foci.size());
    const double k = wave_number(array), r = middle.z - plane;
    if (!(r > 0.0)) throw bad_argument("solver", "inverse-transform needs foci in front of the array; take another");
    Vector drives(array.elements.size());
    for (std::size_t m = 0; m < drives.size(); ++m) {
        const Vec3 from_middle = array.elements[m].position - middle;
        for (const Focus& focus : foci) {
            const Vec3 aside = focus.position - middle;
            drives[m] += std::polar(focus.amplitude, -k * (aside.x * from_middle.x + aside.y * from_middle.y) / r);
        }
        drives[m] *= array.elements[m].aligning() * std::polar(1.0, k * distance(array.elements[m], middle));
    }
    return drives;
}

}  // namespace

std::vector<Complex> solve(const Array& array, std::span<const Focus> foci, const SolveOptions& options,
                           std::span<const Complex> start) {
    const std::vector<Focus> asked = checked(array, foci);
    if (!start.empty() && start.size() != array.elements.size())
        throw bad_argument("start", fmt::format("{} drives to begin with, expected {}: one an element", start.size(),
                                                array.elements.size()));
    const std::vector<Focus> nulls = nulls_among(foci);
    if (!nulls.empty() && options.method != Method::gauss_newton)
        throw bad_argument("solver",
                           fmt::format("a focus of amplitude 0 is a place where pressure is held down, and {} drives "
                                       "foci only; take {}, or leave that focus out",
                                       name_of(options.method), name_of(Method::gauss_newton)),
                           {"solver"});
    Problem problem(array, asked, nulls, options.level, options.amplitudes);
    Vector drives;
    switch (options.method) {
        case Method::superposition: drives = superposed_drives(array, asked); break;
        case Method::distance_weighted: drives = distance_weighted(array, asked); break;
        case Method::inverse_transform: drives = inverse_transform(array, asked); break;
        default: drives = iterated(problem, asked, !nulls.empty(), options, start); break;
    }
    const double wanted = largest_amplitude(asked);
    double strongest = 0.0;
    for (const Complex& drive : drives) strongest = std::max(strongest, size(drive));
    for (Complex& drive : drives) {
        if (options.amplitudes)
            drive *= wanted / strongest;
        else
            drive = direction(drive) * wanted;
    }
    problem.require_pressure(asked, drives);
    return drives;
}

Quality quality_of(const Array& array, std::span<const Focus> foci, std::span<const Complex> drives, Level level) {
    const std::vector<Focus> asked = checked(array, foci);
    if (drives.size() != array.elements.size())
        throw bad_argument("drives",
                           fmt::format("{} drives, expected {}: one an element", drives.size(), array.elements.size()));
    Quality quality;
    std::vector<double> ratios;
    double mean = 0.0, squares = 0.0;
    for (const Focus& focus : foci) {
        const double made = std::abs(pressure(array, drives, focus.position)) * array.transducer.source_pa_m;
        quality.pressure_pa.push_back(made);
        const double alone = std::abs(pressure(array, ideal_drives(array, focus.position), focus.position));
        if (focus.amplitude == 0.0) {
            if (alone > 0.0) quality.null_share = std::max(quality.null_share.value_or(0.0), made / alone);
            continue;
        }
        if (alone == 0.0) throw unreachable(static_cast<std::size_t>(&focus - foci.data()), focus.position);
        squares += made * made / (alone * alone);
        ratios.push_back(made / (level == Level::reachable ? focus.amplitude * alone : focus.amplitude));
        mean += ratios.back() / static_cast<double>(asked.size());
    }
    if (!(mean > 0.0)) throw Error(ErrorCode::failed, "drives", "they make no pressure at any of the foci");
    double variance = 0.0;
    for (const double ratio : ratios) variance += (ratio - mean) * (ratio - mean) / static_cast<double>(ratios.size());
    quality.spread = std::sqrt(variance) / mean;
    quality.least_over_mean = *std::min_element(ratios.begin(), ratios.end()) / mean;
    quality.efficiency = std::sqrt(squares);
    return quality;
}

namespace {

using Complex = std::complex<double>;

/// The carriers' complex amplitudes of all elements over a path that repeats. Within a step the drive is constant, so a
/// carrier approaches it exponentially.
class Carriers {
public:
    Carriers(const Array& array, const Path& path)
        : elements_(array.elements.size()), rate_hz_(std::numbers::pi * array.transducer.bandwidth_hz), begins_{0.0} {
        for (const PathStep& step : path.steps) {
            std::vector<Complex> drives =
                step.foci.empty() ? std::vector<Complex>(elements_) : superposed_drives(array, step.foci);
            drives_.insert(drives_.end(), drives.begin(), drives.end());
            begins_.push_back(begins_.back() + step.periods / array.carrier_hz);
        }
        // From rest, a pass ends with `end`; when the pass repeats for ever, it begins with end/(1 − fall).
        states_.assign(drives_.size(), 0.0);
        std::vector<Complex> state(elements_);
        run(state);
        const double fall = std::exp(-rate_hz_ * begins_.back());
        for (Complex& each : state) each /= 1.0 - fall;
        run(state);
    }

    [[nodiscard]] double begin_s(std::size_t step) const { return begins_[step]; }
    [[nodiscard]] const Complex* drives(std::size_t step) const { return drives_.data() + step * elements_; }

    [[nodiscard]] Complex at(std::size_t element, double time_s) const {
        const double pass_s = begins_.back();
        time_s -= pass_s * std::floor(time_s / pass_s);
        const auto next = std::upper_bound(begins_.begin() + 1, begins_.end() - 1, time_s);
        const auto step = static_cast<std::size_t>(next - begins_.begin()) - 1;
        const Complex wanted = drives_[step * elements_ + element];
        return wanted + (states_[step * elements_ + element] - wanted) * std::exp(-rate_hz_ * (time_s - begins_[step]));
    }

private:
    /// One pass from `state` on, which becomes the state at its end.
    void run(std::vector<Complex>& state) {
        for (std::size_t step = 0; step + 1 < begins_.size(); ++step) {
            std::copy(state.begin(), state.end(), states_.begin() + static_cast<std::ptrdiff_t>(step * elements_));
            const double fall = std::exp(-rate_hz_ * (begins_[step + 1] - begins_[step]));
            for (std::size_t m = 0; m < elements_; ++m) {
                const Complex wanted = drives_[step * elements_ + m];
                state[m] = wanted + (state[m] - wanted) * fall;
            }
        }
    }

    std::size_t elements_;
    double rate_hz_;                        ///< 1/τ
    std::vector<double> begins_;            ///< of the steps, s, and the end of the last
    std::vector<Complex> drives_, states_;  ///< of all elements in each step, and their carriers when it begins
};

}  // namespace

std::vector<double> pressure_left(const Array& array, const Path& path) {
    require_sound(path);
    const Carriers carriers(array, path);
    const std::size_t elements = array.elements.size();
    const double half_period_s = 0.5 / array.carrier_hz;
    std::vector<double> left;
    for (std::size_t step = 0; step < path.steps.size(); ++step) {
        double steady = 0.0;
        std::vector<double> arrived;  // sum over the foci at each time that is looked at
        for (const Focus& focus : path.steps[step].foci) {
            if (focus.amplitude == 0.0) continue;  // a null
            std::vector<Complex> waves;
            std::vector<double> flights_s;
            for (const Element& element : array.elements) {
                waves.push_back(propagation(array, element, focus.position));
                flights_s.push_back(distance(element, focus.position) / array.medium.speed_m_s);
            }
            Complex alone = 0.0;
            for (std::size_t m = 0; m < elements; ++m) alone += carriers.drives(step)[m] * waves[m];
            steady += std::abs(alone);
            // The pressure is largest from just before the nearest element's wave of the next step comes until the
            // farthest element's does.
            const auto [nearest, farthest] = std::minmax_element(flights_s.begin(), flights_s.end());
            const double from = carriers.begin_s(step + 1) + *nearest - 4.0 * half_period_s;
            const auto times =
                static_cast<std::size_t>((*farthest - *nearest + 4.0 * half_period_s) / half_period_s) + 1;
            arrived.resize(std::max(arrived.size(), times));
            for (std::size_t t = 0; t < times; ++t) {
                Complex sum = 0.0;
                for (std::size_t m = 0; m < elements; ++m)
                    sum += waves[m] * carriers.at(m, from + static_cast<double>(t) * half_period_s - flights_s[m]);
                arrived[t] += std::abs(sum);
            }
        }
        left.push_back(steady > 0.0 ? *std::max_element(arrived.begin(), arrived.end()) / steady : 1.0);
    }
    return left;
}

PressureLeft summary_of(const Path& path, const std::vector<double>& left) {
    PressureLeft summary;
    double sum = 0.0, time = 0.0;
    for (std::size_t step = 0; step < path.steps.size(); ++step) {
        if (path.steps[step].foci.empty()) continue;
        if (time == 0.0 || left[step] < summary.least) summary.least = left[step];
        sum += left[step] * path.steps[step].periods;
        time += path.steps[step].periods;
    }
    if (time > 0.0) summary.mean = sum / time;
    return summary;
}

}  // namespace haptogram
