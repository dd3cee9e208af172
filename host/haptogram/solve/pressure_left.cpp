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

/// The carriers' complex amplitudes of all elements over a path that repeats. Within a step an element's drive is
/// constant, so its carrier approaches it exponentially. A step begins for an element with its first pulse: half a
/// period before the pulse's middle, which is anywhere in the carrier period.
class Carriers {
public:
    Carriers(const Array& array, const Path& path)
        : elements_(array.elements.size()), rate_hz_(std::numbers::pi * array.transducer.bandwidth_hz) {
        const double period_s = 1.0 / array.carrier_hz;
        double begin_s = 0.0;
        std::vector<double> last(elements_, 0.0);  // when in its period each element's pulse comes
        for (const PathStep& step : path.steps) {
            const std::vector<Complex> drives =
                step.foci.empty() ? std::vector<Complex>(elements_) : superposed_drives(array, step.foci);
            for (std::size_t m = 0; m < elements_; ++m) {
                if (drives[m] != 0.0) {
                    const double turns = -std::arg(drives[m]) / (2.0 * std::numbers::pi);
                    last[m] = (turns - std::floor(turns) - 0.25) * period_s;
                }
                begins_.push_back(begin_s + last[m]);
            }
            drives_.insert(drives_.end(), drives.begin(), drives.end());
            begin_s += step.periods * period_s;
            ends_.push_back(begin_s);
        }
        // The first step of the next pass.
        for (std::size_t m = 0; m < elements_; ++m) begins_.push_back(begins_[m] + begin_s);
        // From rest, a pass ends with `state`; when the pass repeats for ever, it begins with state/(1 − fall).
        states_.assign(drives_.size(), 0.0);
        std::vector<Complex> state(elements_);
        run(state);
        const double fall = std::exp(-rate_hz_ * begin_s);
        for (Complex& each : state) each /= 1.0 - fall;
        run(state);
    }

    /// Of the carrier period in which the step ends.
    [[nodiscard]] double end_s(std::size_t step) const { return ends_[step]; }
    [[nodiscard]] const Complex* drives(std::size_t step) const { return drives_.data() + step * elements_; }

    [[nodiscard]] Complex at(std::size_t element, double time_s) const {
        const double pass_s = ends_.back();
        const double first_s = begins_[element];
        time_s -= pass_s * std::floor((time_s - first_s) / pass_s);
        std::size_t low = 0, high = ends_.size();  // the last step that has begun is in [low, high)
        while (high - low > 1) {
            const std::size_t middle = (low + high) / 2;
            (begins_[middle * elements_ + element] <= time_s ? low : high) = middle;
        }
        const std::size_t i = low * elements_ + element;
        return drives_[i] + (states_[i] - drives_[i]) * std::exp(-rate_hz_ * (time_s - begins_[i]));
    }

private:
    /// One pass from `state` on, which becomes the state at its end.
    void run(std::vector<Complex>& state) {
        for (std::size_t i = 0; i < drives_.size(); ++i) {
            Complex& now = state[i % elements_];
            states_[i] = now;
            const double lasts_s = begins_[i + elements_] - begins_[i];
            now = drives_[i] + (now - drives_[i]) * std::exp(-rate_hz_ * lasts_s);
            // A step's pulses are as many as its periods. What the next step begins later or earlier than that is
            // time without a pulse, or with two.
            const std::size_t step = i / elements_;
            const double pulses_s = ends_[step] - (step == 0 ? 0.0 : ends_[step - 1]);
            now -= drives_[i] * (rate_hz_ * (lasts_s - pulses_s));
        }
    }

    std::size_t elements_;
    double rate_hz_;                        ///< 1/τ
    std::vector<double> ends_;              ///< of the steps, s
    std::vector<double> begins_;            ///< of all elements in each step, and in the first of the next pass, s
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
            const double from = carriers.end_s(step) + *nearest - 4.0 * half_period_s;
            const auto times =
                static_cast<std::size_t>((*farthest - *nearest + 6.0 * half_period_s) / half_period_s) + 1;
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
