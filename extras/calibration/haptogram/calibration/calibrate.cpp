// SPDX-License-Identifier: Apache-2.0
#include "haptogram/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <numeric>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// What transducers of one kind differ by, which is what the fit expects; and what no model has: the rms of a room's
/// echoes, over the direct sound, where one place alone cannot tell it.
constexpr double gain_spread = 0.15, phase_spread = 0.3, unmodelled = 0.07;
constexpr double loud_echo = 0.15;  ///< what is named, of the direct sound
constexpr double surely = 20.0;     ///< how much better the logarithm of a likelihood is when there is no doubt
constexpr double unlikely = 1e-5;   ///< of a test: what it calls wrong is right so often

/// What a sum of squares over their errors reaches so rarely, of so many free numbers.
double most_of(std::size_t free, double chance = unlikely) {
    const boost::math::chi_squared squares(static_cast<double>(free));
    return boost::math::quantile(boost::math::complement(squares, chance));
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * pi); }

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The fit's state. Channel j is driven as channel j; `wired[j]` is the element that hangs on it.
class Fit {
public:
    Fit(const Array& array, std::span<const HeardAt> heard, const CalibrateOptions& options)
        : array_(array),
          heard_(heard.begin(), heard.end()),
          options_(options),
          channels_(array.elements.size()),
          wired_(channels_),
          alive_(channels_, true),
          trusted_(channels_, true),
          weak_(channels_, false),
          reversed_(channels_, false),
          gain_(channels_, 0.0),
          phase_(channels_, 0.0),
          mic_gain_(heard.size()),
          mic_phase_(heard.size()),
          agreement_(heard.size()) {
        std::iota(wired_.begin(), wired_.end(), std::size_t{0});
        for (const HeardAt& one : heard) places_.push_back(one.place);
    }

    Calibrated run() {
        const double fits = begin();
        for (std::size_t k = 0; k < heard_.size(); ++k)
            if (!(agreement_[k] > 0.5))
                throw bad_input(
                    fmt::format("recording {}", k + 1),
                    fmt::format(
                        "its phases fit no place within {:g} mm of the one that was named; see that the place is "
                        "right, that the array file is this array's, and that nothing stood in the way",
                        2.5 * options_.place_error_m / millimetre));
        find_dead();
        find_weak();
        begin_elements();
        refine();
        if (heard_.size() >= 3) exchange_channels();
        Calibrated found = result();
        found.fits = fits;
        return found;
    }

    /// Places near those that were named. A cable that was put on the other way round turns or mirrors the whole array,
    /// so all such ways are tried where three places can tell them apart.
    /// @return how well they fit, as the logarithm of a likelihood
    double begin() {
        const std::vector<std::size_t> straight = wired_;
        double best = fit_of_places() + surely;
        if (heard_.size() >= 3)
            for (int way = 1; way < 8; ++way) {
                const auto turned = turned_wires(way);
                if (!turned) continue;
                wired_ = *turned;
                const double fits = fit_of_places();
                if (fits <= best) continue;
                best = fits;
                mirrored_ = turned;
            }
        wired_ = mirrored_.value_or(straight);
        return fit_of_places();
    }

    /// The least of the places' agreements of phases.
    [[nodiscard]] double agreement() const { return *std::ranges::min_element(agreement_); }

private:
    [[nodiscard]] Complex sound(std::size_t k, std::size_t j) const { return heard_[k].heard.sounds[j]; }
    [[nodiscard]] double wave_number() const {
        return 2.0 * pi * array_.carrier_hz / (array_.medium.speed_m_s * (1.0 + speed_));
    }
    /// What the element makes at a place, and the microphone hears of it.
    [[nodiscard]] Complex wave(std::size_t element, Vec3 place) const {
        const Element& e = array_.elements[element];
        const double range = distance(e, place);
        // The array's own wave number is in propagation(); the rest is that of another speed.
        Complex found =
            propagation(array_, e, place) * std::polar(1.0, (2.0 * pi / array_.wavelength_m() - wave_number()) * range);
        if (options_.microphone)
            found *= directivity(*options_.microphone, wave_number(), (place - e.position).z / range);
        return found;
    }

    /// The square of a channel's sound over what its element would make as its kind, rms of the places, and the noise's
    /// share of it.
    [[nodiscard]] std::pair<double, double> loudness(std::size_t j) const {
        double square = 0.0, weight = 0.0;
        for (std::size_t k = 0; k < heard_.size(); ++k) {
            const double expected = scale_[k] * std::abs(wave(wired_[j], places_[k]));
            const double noise = std::max(heard_[k].heard.noise, 1e-9 * expected);
            weight += expected * expected / (noise * noise);
            square += std::norm(sound(k, j)) / (noise * noise);
        }
        return {square / weight, static_cast<double>(heard_.size()) / weight};
    }

    /// An element is dead when its sound is nearer to none than to that of its kind, both in their own spread, and
    /// could be noise.
    void find_dead() {
        find_scales();
        constexpr double crosstalk = 0.03;
        const double most = most_of(2 * heard_.size()) / (2.0 * static_cast<double>(heard_.size()));
        for (std::size_t j = 0; j < channels_; ++j) {
            const auto [square, noise] = loudness(j);
            const double ratio = std::sqrt(square), error = std::sqrt(noise);
            alive_[j] = ratio / std::hypot(error, crosstalk) > (1.0 - ratio) / std::hypot(error, gain_spread) ||
                        square > most * noise + crosstalk * crosstalk;
        }
        const auto count = static_cast<std::size_t>(std::ranges::count(alive_, true));
        if (2 * count <= channels_)
            throw bad_input("calibration", fmt::format("only {} of {} elements are heard; see that the array file is "
                                                       "this array's and the place where the microphone was right",
                                                       count, channels_));
    }

    /// An element is weak when it makes less than the most that a weak one may, and stands out of the others' spread.
    void find_weak() {
        find_scales();
        constexpr double weakest = 0.6, stands_out = 4.2;  // of the median; of standard deviations
        constexpr double outlier = 4.5;                    // of median deviations, three standard ones
        std::vector<double> gains, errors, living, off;
        for (std::size_t j = 0; j < channels_; ++j) {
            const auto [square, noise] = loudness(j);
            gains.push_back(std::sqrt(std::max(0.0, square - noise)));
            errors.push_back(std::sqrt(noise / (2.0 * static_cast<double>(heard_.size()))));
            if (alive_[j] && trusted_[j]) living.push_back(gains.back());
        }
        const double usual = median(living);
        for (const double gain : living) off.push_back(std::abs(gain - usual));
        const double most = outlier * median(off);
        double squares = 0.0, count = 0.0;
        for (const double one : off)
            if (one < most) {
                squares += one * one;
                count += 1.0;
            }
        spread_ = count > 0.0 ? std::sqrt(squares / count) / usual : 0.0;
        for (std::size_t j = 0; j < channels_; ++j)
            weak_[j] = alive_[j] && gains[j] < weakest * usual &&
                       usual - gains[j] > stands_out * std::hypot(errors[j], spread_ * usual);
    }

    void find_scales() {
        scale_.clear();
        for (std::size_t k = 0; k < heard_.size(); ++k) scale_.push_back(scale_at(k));
    }

    /// The microphone's gain at a place: what most elements agree on.
    [[nodiscard]] double scale_at(std::size_t k) const {
        std::vector<double> ratios;
        for (std::size_t j = 0; j < channels_; ++j)
            ratios.push_back(std::abs(sound(k, j)) / std::abs(wave(wired_[j], places_[k])));
        return median(std::move(ratios));
    }

    double fit_of_places() {
        double sum = 0.0;
        for (std::size_t k = 0; k < heard_.size(); ++k) sum += begin_at(k);
        return sum;
    }

    /// The element that is where each one comes to lie when the array is mirrored (bits 0 and 1: in x and in y) and its
    /// axes are exchanged (bit 2); none when there is none.
    [[nodiscard]] std::optional<std::vector<std::size_t>> turned_wires(int way) const {
        constexpr double same_m = 1e-6;
        std::vector<std::size_t> wires;
        for (const Element& e : array_.elements) {
            Vec3 to = e.position;
            if ((way & 4) != 0) std::swap(to.x, to.y);
            if ((way & 1) != 0) to.x = -to.x;
            if ((way & 2) != 0) to.y = -to.y;
            const auto there = std::ranges::find_if(array_.elements,
                                                    [&](const Element& other) { return distance(other, to) < same_m; });
            if (there == array_.elements.end()) return {};
            wires.push_back(static_cast<std::size_t>(there - array_.elements.begin()));
        }
        return wires;
    }

    /// A place near the given one from which the phases agree best but for half turns, which are reversed elements.
    /// @return how well it fits, as the logarithm of a likelihood
    double begin_at(std::size_t k) {
        const double k_m = wave_number(), error = options_.place_error_m;
        struct Turned {
            Vec3 from;
            Complex squared;  // as long as the sound
        };
        std::vector<Turned> living;
        double weight = 0.0;
        for (std::size_t j = 0; j < channels_; ++j)
            if (const double loud = std::abs(sound(k, j)); alive_[j] && loud > 0.0) {
                living.push_back({array_.elements[wired_[j]].position, sound(k, j) * sound(k, j) / loud});
                weight += loud;
            }
        const auto agreement = [&](Vec3 place) {
            Complex sum = 0.0;
            for (const Turned& one : living)
                sum += one.squared * std::polar(1.0, 2.0 * k_m * distance(one.from, place));
            return sum / weight;
        };
        const Vec3 given = heard_[k].place;
        constexpr double across_m = 1.2e-3, along_m = 4e-3, reach = 2.5;
        const int steps = static_cast<int>(std::ceil(reach * error / across_m)),
                  up = static_cast<int>(std::ceil(reach * error / along_m));
        double best = -1e300;
        for (int x = -steps; x <= steps; ++x)
            for (int y = -steps; y <= steps; ++y)
                for (int z = -up; z <= up; ++z) {
                    const Vec3 off{x * across_m, y * across_m, z * along_m};
                    const double fits = 2.0 * static_cast<double>(channels_) * std::abs(agreement(given + off)) -
                                        0.5 * dot(off, off) / (error * error);
                    if (fits <= best) continue;
                    best = fits;
                    places_[k] = given + off;
                }
        mic_phase_[k] = 0.5 * std::arg(agreement(places_[k]));
        mic_gain_[k] = std::log(scale_at(k));
        agreement_[k] = std::abs(agreement(places_[k]));
        if (k == 0) return best;
        double same = 0.0;  // the phase is known but for half a turn, which the first place decides
        for (std::size_t j = 0; j < channels_; ++j)
            if (alive_[j]) same += std::cos(phase_off(k, j) - phase_off(0, j));
        if (same < 0.0) mic_phase_[k] += pi;
        return best;
    }

    /// Phase of a channel's sound over what its element, as its kind, would make.
    [[nodiscard]] double phase_off(std::size_t k, std::size_t j) const {
        return std::arg(sound(k, j) / wave(wired_[j], places_[k])) - mic_phase_[k];
    }

    void begin_elements() {
        std::size_t turned = 0, count = 0;
        for (std::size_t j = 0; j < channels_; ++j) {
            if (!alive_[j]) continue;
            Complex sum = 0.0;
            for (std::size_t k = 0; k < heard_.size(); ++k) sum += std::polar(std::abs(sound(k, j)), phase_off(k, j));
            phase_[j] = std::arg(sum);
            reversed_[j] = std::abs(phase_[j]) > pi / 2.0;
            turned += reversed_[j] ? 1 : 0;
            ++count;
        }
        if (2 * turned > count) {  // which of the two ways is right is not to be heard; that of most is
            for (double& phase : mic_phase_) phase += pi;
            for (std::size_t j = 0; j < channels_; ++j) {
                phase_[j] = wrapped(phase_[j] + pi);
                reversed_[j] = !reversed_[j];
            }
        }
        for (std::size_t j = 0; j < channels_; ++j)
            if (reversed_[j]) phase_[j] = wrapped(phase_[j] - pi);
    }

    /// Standard deviation of the logarithm of a sound, in each of its parts.
    [[nodiscard]] double error_of(std::size_t k, std::size_t j) const {
        return std::hypot(heard_[k].heard.noise / std::abs(sound(k, j)), model_error_) / std::sqrt(2.0);
    }

    /// What is left of a sound's logarithm: of its gain, and of its phase.
    [[nodiscard]] Complex left(std::size_t k, std::size_t j) const {
        const Complex ratio = sound(k, j) / wave(wired_[j], places_[k]);
        return {std::log(std::abs(ratio)) - mic_gain_[k] - gain_[j],
                wrapped(std::arg(ratio) - mic_phase_[k] - phase_[j] - (reversed_[j] ? pi : 0.0))};
    }

    void refine() {
        converge();
        if (heard_.size() < 2) return;
        // What the places contradict each other by is the model's error; a median, so that exchanged channels do not
        // count.
        std::vector<double> squares;
        for (std::size_t j = 0; j < channels_; ++j)
            if (alive_[j] && trusted_[j]) squares.push_back(contradiction(j, wired_[j]));
        const double free = 2.0 * static_cast<double>(heard_.size() - 1);
        const double factor = median(std::move(squares)) / boost::math::quantile(boost::math::chi_squared(free), 0.5);
        model_error_ *= std::clamp(std::sqrt(factor), 0.1, 10.0);
        converge();
    }

    /// The order of the unknowns: three of each place, the speed, gain and phase of each place, gain and phase of each
    /// channel.
    [[nodiscard]] Eigen::Index of_place(std::size_t k) const { return static_cast<Eigen::Index>(3 * k); }
    [[nodiscard]] Eigen::Index of_speed() const { return static_cast<Eigen::Index>(3 * heard_.size()); }
    [[nodiscard]] Eigen::Index of_microphone(std::size_t k) const {
        return of_speed() + 1 + static_cast<Eigen::Index>(2 * k);
    }
    [[nodiscard]] Eigen::Index of_channel(std::size_t j) const {
        return of_microphone(heard_.size()) + static_cast<Eigen::Index>(2 * j);
    }

    void converge() {
        constexpr int rounds = 12;
        constexpr double enough = 1e-7;
        for (int round = 0; round < rounds && step() > enough; ++round) {
        }
    }

    /// One step of Gauss and Newton's method; `normal_` is kept for the errors.
    /// @return the most that it changed, m, rad or of a logarithm
    double step() {
        const Eigen::Index unknowns = of_channel(channels_);
        normal_ = Eigen::MatrixXd::Zero(unknowns, unknowns);
        Eigen::VectorXd pull = Eigen::VectorXd::Zero(unknowns);
        const auto expect = [&](Eigen::Index at, double is, double error) {
            normal_(at, at) += 1.0 / (error * error);
            pull[at] -= is / (error * error);
        };
        for (std::size_t k = 0; k < heard_.size(); ++k) {
            const Vec3 off = places_[k] - heard_[k].place;
            expect(of_place(k), off.x, options_.place_error_m);
            expect(of_place(k) + 1, off.y, options_.place_error_m);
            expect(of_place(k) + 2, off.z, options_.place_error_m);
        }
        expect(of_speed(), speed_, options_.speed_error);
        for (std::size_t j = 0; j < channels_; ++j) {
            expect(of_channel(j), gain_[j], weak_[j] ? 1.0 : gain_spread);
            expect(of_channel(j) + 1, phase_[j], phase_spread);
        }
        for (std::size_t k = 0; k < heard_.size(); ++k)
            for (std::size_t j = 0; j < channels_; ++j)
                if (alive_[j] && trusted_[j]) add_sound(k, j, pull);
        const Eigen::VectorXd by = normal_.ldlt().solve(pull);
        for (std::size_t k = 0; k < heard_.size(); ++k) {
            places_[k] = places_[k] + Vec3{by[of_place(k)], by[of_place(k) + 1], by[of_place(k) + 2]};
            mic_gain_[k] += by[of_microphone(k)];
            mic_phase_[k] += by[of_microphone(k) + 1];
        }
        speed_ += by[of_speed()];
        for (std::size_t j = 0; j < channels_; ++j) {
            gain_[j] += by[of_channel(j)];
            phase_[j] += by[of_channel(j) + 1];
        }
        return by.cwiseAbs().maxCoeff();
    }

    void add_sound(std::size_t k, std::size_t j, Eigen::VectorXd& pull) {
        const double weight = 1.0 / (error_of(k, j) * error_of(k, j));
        const Complex rest = left(k, j);
        const Element& e = array_.elements[wired_[j]];
        const Vec3 ray = places_[k] - e.position;
        const double range = norm(ray);
        constexpr double step_m = 1e-5;
        const double here = std::log(std::abs(wave(wired_[j], places_[k])));
        const auto slope = [&](Vec3 off) {
            return (std::log(std::abs(wave(wired_[j], places_[k] + off))) - here) / step_m;
        };
        const std::array<double, 3> along{ray.x / range, ray.y / range, ray.z / range};
        const std::array<double, 3> slopes{slope({step_m, 0, 0}), slope({0, step_m, 0}), slope({0, 0, step_m})};
        for (const bool phase : {false, true}) {
            std::array<std::pair<Eigen::Index, double>, 6> row;
            for (std::size_t axis = 0; axis < 3; ++axis)
                row[axis] = {of_place(k) + static_cast<Eigen::Index>(axis),
                             phase ? -wave_number() * along[axis] : slopes[axis]};
            row[3] = {of_speed(), phase ? wave_number() * range : 0.0};
            row[4] = {of_microphone(k) + (phase ? 1 : 0), 1.0};
            row[5] = {of_channel(j) + (phase ? 1 : 0), 1.0};
            for (const auto& [a, at_a] : row) {
                pull[a] += weight * at_a * (phase ? rest.imag() : rest.real());
                for (const auto& [b, at_b] : row) normal_(a, b) += weight * at_a * at_b;
            }
        }
    }

    /// What a channel's sounds at the places say of an element, if it makes them.
    struct AsElement {
        double contradiction = 0.0;  ///< a sum of squares over their errors: 2 (places − 1) when nothing is wrong
        Complex made;                ///< of what the element makes as its kind
        double weight = 0.0;         ///< of that logarithm's parts, one over the squares of their errors
    };
    [[nodiscard]] AsElement as_element(std::size_t channel, std::size_t element) const {
        AsElement found;
        std::vector<Complex> turns;
        for (std::size_t k = 0; k < heard_.size(); ++k) {
            const double weight = 1.0 / std::pow(error_of(k, channel), 2.0);
            turns.push_back(sound(k, channel) / wave(element, places_[k]) *
                            std::polar(std::exp(-mic_gain_[k]), -mic_phase_[k]));
            found.made += weight * turns.back();
            found.weight += weight;
        }
        found.made /= found.weight;
        for (std::size_t k = 0; k < heard_.size(); ++k)
            found.contradiction += std::norm(turns[k] / found.made - 1.0) / std::pow(error_of(k, channel), 2.0);
        return found;
    }
    [[nodiscard]] double contradiction(std::size_t channel, std::size_t element) const {
        return as_element(channel, element).contradiction;
    }

    /// How unlikely it is that a channel plays an element, as a sum of squares: its contradiction, and how far the
    /// element then is from its kind, which it may be with half a turn.
    [[nodiscard]] double unlikelihood(std::size_t channel, std::size_t element) const {
        const AsElement as = as_element(channel, element);
        const double gain = std::log(std::abs(as.made)), phase = std::arg(as.made);
        const bool turned = std::abs(phase) > pi / 2.0;
        const auto squared = [&](double off, double spread) { return off * off / (spread * spread + 1.0 / as.weight); };
        return as.contradiction + squared(gain, gain_spread) +
               squared(turned ? wrapped(phase - pi) : phase, phase_spread);
    }

    [[nodiscard]] std::vector<std::size_t> contradicting(double chance = unlikely) const {
        const double most = most_of(2 * (heard_.size() - 1), chance);
        std::vector<std::size_t> found;
        for (std::size_t j = 0; j < channels_; ++j)
            if (alive_[j] && contradiction(j, wired_[j]) > most) found.push_back(j);
        return found;
    }

    /// Channels that contradict their elements are left out, the rest is fitted again, and each of them takes the
    /// element, of those that are free, that it contradicts least.
    void exchange_channels() {
        std::vector<std::size_t> wrong = contradicting();
        for (int round = 0; round < 3 && !wrong.empty(); ++round) {
            for (std::size_t j = 0; j < channels_; ++j) trusted_[j] = std::ranges::find(wrong, j) == wrong.end();
            refine();
            wrong = contradicting();
        }
        if (model_error_ < loud_echo) exchange_pairs();  // an echo makes likely what is not
        wrong = contradicting();
        std::vector<std::size_t> open, free;  // channels, and their elements
        for (std::size_t j = 0; j < channels_; ++j)
            if (!alive_[j] || std::ranges::find(wrong, j) != wrong.end()) {
                open.push_back(j);
                free.push_back(wired_[j]);
            }
        const double most = most_of(2 * (heard_.size() - 1));
        std::map<std::size_t, std::size_t> element_of;
        std::vector<std::size_t> taken;
        for (const std::size_t j : wrong) {
            const auto best = std::ranges::min_element(free, {}, [&](std::size_t e) { return contradiction(j, e); });
            if (best == free.end() || contradiction(j, *best) > most) continue;
            if (std::ranges::find(taken, *best) != taken.end()) continue;
            element_of[j] = *best;
            taken.push_back(*best);
        }
        // Channels that are left, dead ones among them, keep their element, or take one that is left.
        std::vector<std::size_t> rest;
        for (const std::size_t e : free)
            if (std::ranges::find(taken, e) == taken.end()) rest.push_back(e);
        for (const std::size_t j : open) {
            if (element_of.contains(j)) continue;
            auto at = std::ranges::find(rest, wired_[j]);
            if (at == rest.end()) at = rest.begin();
            element_of[j] = *at;
            rest.erase(at);
        }
        for (const auto& [j, e] : element_of) wired_[j] = e;
        find_floating();
        // What is named must be so rare among all channels together.
        doubtful_ = contradicting(unlikely / static_cast<double>(channels_));
        for (std::size_t j = 0; j < channels_; ++j) trusted_[j] = std::ranges::find(doubtful_, j) == doubtful_.end();
        find_weak();
        begin_elements();
        refine();
    }

    /// Few places may fit a wrong element well enough, with phases that are unlikely. Two channels that fit each
    /// other's elements, and surely better than their own, are exchanged.
    void exchange_pairs() {
        constexpr double better_by = 20.0;  // of two that are not, three places make 13 in 200 arrays
        const double most = most_of(2 * (heard_.size() - 1));
        std::vector<double> own(channels_);
        for (std::size_t j = 0; j < channels_; ++j)
            if (alive_[j]) own[j] = unlikelihood(j, wired_[j]);
        struct Pair {
            double better;
            std::size_t a, b;
        };
        std::vector<Pair> pairs;
        for (std::size_t a = 0; a < channels_; ++a)
            for (std::size_t b = a + 1; b < channels_; ++b) {
                if (!alive_[a] || !alive_[b] || own[a] + own[b] < better_by) continue;
                if (contradiction(a, wired_[b]) > most || contradiction(b, wired_[a]) > most) continue;
                const double better = own[a] + own[b] - unlikelihood(a, wired_[b]) - unlikelihood(b, wired_[a]);
                if (better > better_by) pairs.push_back({better, a, b});
            }
        std::ranges::sort(pairs, std::ranges::greater{}, &Pair::better);
        std::vector<bool> taken(channels_, false);
        for (const auto& [better, a, b] : pairs) {
            if (taken[a] || taken[b]) continue;
            taken[a] = taken[b] = true;
            std::swap(wired_[a], wired_[b]);
        }
    }

    /// An input that nothing drives or pulls down follows its neighbours' wires: their channels then sound as two
    /// elements, of which one is heard on no channel of its own. What it adds is taken away.
    void find_floating() {
        if (heard_.size() < 4) return;  // three places fit two elements too easily
        for (std::size_t j = 0; j < channels_; ++j) {
            if (!alive_[j]) continue;
            std::vector<std::pair<std::size_t, Complex>> with;  // silent elements, and how loud they are
            for (std::size_t other = 0; other < channels_; ++other)
                if (!alive_[other])
                    if (const auto part = part_of(j, wired_[other])) with.emplace_back(wired_[other], *part);
            if (with.size() != 1) continue;  // none, or it cannot be told which
            const auto& [element, part] = with.front();
            floating_[element].push_back(j);
            for (std::size_t k = 0; k < heard_.size(); ++k)
                heard_[k].heard.sounds[j] -= part * wave(element, places_[k]) * microphone(k);
        }
    }

    [[nodiscard]] Complex microphone(std::size_t k) const { return std::polar(std::exp(mic_gain_[k]), mic_phase_[k]); }

    /// How loud another element must be, over its kind, so that it and the channel's own make the channel's sounds;
    /// none if it cannot be so, or the own makes them as well alone.
    [[nodiscard]] std::optional<Complex> part_of(std::size_t channel, std::size_t other) const {
        const auto count = static_cast<Eigen::Index>(heard_.size());
        Eigen::MatrixXcd waves(count, 2);
        Eigen::VectorXcd sounds(count);
        Eigen::VectorXd errors(count);
        for (Eigen::Index i = 0; i < count; ++i) {
            const auto k = static_cast<std::size_t>(i);
            sounds[i] = sound(k, channel) / microphone(k);
            errors[i] = error_of(k, channel) * std::abs(sounds[i]);
            waves(i, 0) = wave(wired_[channel], places_[k]);
            waves(i, 1) = wave(other, places_[k]);
        }
        Eigen::Vector2cd parts;
        double rest = 0.0;
        for (int round = 0; round < 2; ++round) {
            const Eigen::VectorXcd weight = errors.cwiseInverse().cast<Complex>();
            const auto weights = weight.asDiagonal();
            parts = (weights * waves).colPivHouseholderQr().solve(weights * sounds);
            rest = (weights * (sounds - waves * parts)).squaredNorm();
            // Each of the two has its own echoes, which a sum of them that is faint has, too.
            for (Eigen::Index i = 0; i < count; ++i) {
                const auto k = static_cast<std::size_t>(i);
                const double both = (waves.row(i).transpose().cwiseProduct(parts)).norm();
                errors[i] = std::hypot(heard_[k].heard.noise / std::abs(microphone(k)), model_error_ * both) /
                            std::numbers::sqrt2;
            }
        }
        constexpr double least = 0.2, most = 2.0;  // a half of one's kind where it follows two
        if (std::abs(parts[1]) < least || std::abs(parts[1]) > most) return {};
        if (rest > most_of(2 * (heard_.size() - 2))) return {};
        // What a further element takes away by chance, on any of an array's channels, is less.
        if (contradiction(channel, wired_[channel]) - rest < most_of(2, unlikely / static_cast<double>(channels_)))
            return {};
        return parts[1];
    }

    [[nodiscard]] double residual() const {
        double rest = 0.0, all = 0.0;
        for (std::size_t k = 0; k < heard_.size(); ++k)
            for (std::size_t j = 0; j < channels_; ++j) {
                if (!alive_[j] || !trusted_[j]) continue;
                const Complex of_log = left(k, j);
                const Complex model = sound(k, j) * std::polar(std::exp(-of_log.real()), -of_log.imag());
                rest += std::norm(sound(k, j) - model);
                all += std::norm(sound(k, j));
            }
        return std::sqrt(rest / all);
    }

    [[nodiscard]] Calibrated result() const {
        const Eigen::MatrixXd covariance =
            normal_.ldlt().solve(Eigen::MatrixXd::Identity(normal_.rows(), normal_.cols()));
        const auto error = [&](Eigen::Index at) { return std::sqrt(covariance(at, at)); };
        double mean = 0.0, count = 0.0;
        for (std::size_t j = 0; j < channels_; ++j)
            if (alive_[j]) {
                mean += std::exp(gain_[j]);
                count += 1.0;
            }
        mean /= count;
        Calibrated found;
        Calibration& calibration = found.calibration;
        calibration.speed_m_s = array_.medium.speed_m_s * (1.0 + speed_);
        calibration.residual = residual();
        calibration.elements.resize(channels_);
        Complex before = 0.0;
        double ideal = 0.0;
        for (std::size_t j = 0; j < channels_; ++j) {
            MeasuredElement& element = calibration.elements[wired_[j]];
            element.channel = static_cast<std::uint32_t>(j);
            element.dead = !alive_[j];
            if (element.dead) continue;
            element.gain = std::exp(gain_[j]) / mean;
            element.phase_rad = wrapped(phase_[j]);
            element.reversed = reversed_[j];
            element.gain_error = element.gain * error(of_channel(j));
            element.phase_error_rad = error(of_channel(j) + 1);
            const Complex made = wave(wired_[j], places_[0]);
            before += std::polar(std::abs(made) * element.gain,
                                 std::arg(made) + element.phase_rad + (element.reversed ? pi : 0.0) +
                                     wave_number() * distance(array_.elements[j], places_[0]));
            ideal += std::abs(made) * element.gain;
            const double own = normal_(of_channel(j) + 1, of_channel(j) + 1);  // its error once the places are known
            found.focus_after += std::abs(made) * element.gain * std::exp(-0.5 / own);
        }
        found.focus_before = std::abs(before) / ideal;
        found.focus_after /= ideal;
        found.places = places_;
        found.speed_error_m_s = array_.medium.speed_m_s * error(of_speed());
        for (std::size_t k = 0; k < heard_.size(); ++k)
            found.place_errors_m.push_back(
                std::max({error(of_place(k)), error(of_place(k) + 1), error(of_place(k) + 2)}));
        found.faults = faults(calibration.elements);
        return found;
    }

    [[nodiscard]] std::vector<CalibrationFault> faults(const std::vector<MeasuredElement>& elements) const {
        std::vector<std::size_t> dead, weak, reversed, exchanged, contradicting;
        std::string wires, gains;
        std::vector<CalibrationFault> found;
        for (std::size_t m = 0; m < elements.size(); ++m) {
            const MeasuredElement& e = elements[m];
            if (e.dead && !floating_.contains(m)) dead.push_back(m);
            if (weak_[e.channel]) {
                weak.push_back(m);
                gains += fmt::format("{}{} at {:.2f}", gains.empty() ? "" : ", ", m, e.gain);
            }
            if (e.reversed) reversed.push_back(m);
            if (mirrored_ ? (*mirrored_)[e.channel] == m : e.channel == m) continue;
            exchanged.push_back(m);
            wires += fmt::format("{}{} on channel {}", wires.empty() ? "" : ", ", m, e.channel);
        }
        for (const auto& [element, channels] : floating_)
            found.push_back({"floating",
                             {element},
                             fmt::format("{} plays what channels {} play: its driver's input is open, and floats",
                                         element, fmt::join(channels, ", ")),
                             "fit the pull-down that is missing at that input, and mend its wire"});
        for (const std::size_t j : doubtful_) contradicting.push_back(wired_[j]);
        std::ranges::sort(contradicting);
        const auto add = [&](const char* cause, const std::vector<std::size_t>& which, const std::string& what,
                             const char* advice) {
            if (!which.empty()) found.push_back({cause, which, what, advice});
        };
        const auto list = [](const char* what, const std::vector<std::size_t>& which) {
            return fmt::format("{}: {}", what, fmt::join(which, ", "));
        };
        add("dead", dead, list("dead", dead),
            "see its solder joints, its driver's output, and that the driver's input is not open; exchange it with a "
            "neighbour to tell which");
        add("weak", weak, fmt::format("weak: {} of the mean, where others differ by ± {:.2f}", gains, spread_),
            "see that nothing covers it, its joints, and its driver's supply");
        add("reversed", reversed, list("reversed", reversed),
            "exchange its legs, or leave it: the calibration turns it");
        add("exchanged", exchanged, "on another channel: " + wires,
            "exchange the wires or connectors, or leave them: the calibration does");
        add("contradicting", contradicting, list("heard otherwise from place to place than any element", contradicting),
            "see that nothing stood between it and the microphone, and record again");
        if (mirrored_)
            found.push_back({"mirrored",
                             {},
                             "the array is mirrored or turned: its cable is the other way round",
                             "turn the connector, or leave it: the calibration does"});
        if (heard_.size() >= 2 && model_error_ > loud_echo)
            found.push_back(
                {"echo",
                 {},
                 fmt::format("the places disagree by {:.0f} % of the sound: something reflects it",
                             100.0 * model_error_),
                 "move the array away from walls and the table's edge, or hang cloth there, and record again"});
        return found;
    }

    const Array& array_;
    std::vector<HeardAt> heard_;
    const CalibrateOptions& options_;
    std::size_t channels_;
    std::vector<std::size_t> wired_;
    std::vector<bool> alive_, trusted_, weak_, reversed_;
    std::vector<double> gain_, phase_;  ///< the gain's logarithm; the phase without a reversed one's half turn
    std::vector<double> mic_gain_, mic_phase_;
    std::vector<double> scale_;  ///< of what is heard at each place, over what elements make there
    double spread_ = 0.0;        ///< of the gains of those alive
    std::map<std::size_t, std::vector<std::size_t>> floating_;  ///< elements, and the channels that they follow
    std::vector<double> agreement_;  ///< of the phases at each place, 1 when all are as their kind's
    std::optional<std::vector<std::size_t>> mirrored_;
    std::vector<Vec3> places_;
    double speed_ = 0.0;  ///< over the array file's, less 1
    double model_error_ = unmodelled;
    Eigen::MatrixXd normal_;
    std::vector<std::size_t> doubtful_;
};

}  // namespace

Calibrated calibrate(const Array& array, std::span<const HeardAt> heard, const CalibrateOptions& options) {
    if (heard.empty()) throw bad_argument("recordings", "there is none; give at least one");
    for (const HeardAt& one : heard)
        if (one.heard.sounds.size() != array.elements.size())
            throw bad_argument(
                "recordings", fmt::format("{} sounds for {} elements", one.heard.sounds.size(), array.elements.size()));
    return Fit(array, heard, options).run();
}

std::optional<std::string> other_array(const Array& named, std::optional<double> fits,
                                       const std::function<std::vector<HeardAt>(const Array&)>& hear,
                                       const CalibrateOptions& options) {
    constexpr double alike = 0.7;  // of phases: of elements as they are bought 0.85
    std::optional<std::string> found;
    for (const std::string& name : shipped_arrays()) {
        Array other = find_array(name);
        other.medium = named.medium;
        if (other.elements == named.elements || (fits && other.elements.size() != named.elements.size())) continue;
        std::vector<HeardAt> heard;
        try {
            heard = hear(other);
        } catch (const Error&) {  // it is not this one's code
            continue;
        }
        Fit fit(other, heard, options);
        const double better = fit.begin();
        if (fit.agreement() < alike || (fits && better < *fits + surely)) continue;
        fits = better;
        found = name;
    }
    return found;
}

std::optional<CalibrationFault> supply_fault(const Transducer& before, const MeasuredLevel& now) {
    constexpr double alike = 0.15;  // a balance's and a focus's errors are a few hundredths
    const double ratio = now.source_pa_m / before.source_pa_m;
    if (before.measured.empty() || std::abs(ratio - 1.0) < alike) return {};
    return CalibrationFault{
        "supply",
        {},
        fmt::format("all elements alike make {:.2f} of the pressure that was measured before", ratio),
        fmt::format("measure the drivers' supply, which goes with it: {:.2f} of what it was", ratio)};
}

}  // namespace haptogram
