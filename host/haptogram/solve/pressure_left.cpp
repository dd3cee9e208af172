// SPDX-License-Identifier: Apache-2.0
#include "haptogram/solve/pressure_left.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/solve/drives.hpp"

namespace haptogram {
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
