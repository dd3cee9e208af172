// SPDX-License-Identifier: Apache-2.0
#include "haptogram/calibration/code.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/solve/focal_law.hpp"

namespace haptogram {
namespace {

using Complex = std::complex<double>;
using Complexes = std::vector<Complex>;

constexpr double turn = 2.0 * std::numbers::pi;
/// Of a pattern, what is not listened to: transducers and the nearest echoes settle in its beginning, and its end may
/// come early by the clock.
constexpr double settling = 0.25, margin = 0.05;
/// Of the power that silent columns have by chance: with less, it is the code. Sixteen of them have so little in one of
/// three million trials, and thousands are made.
constexpr double recognised = 0.2;

/// Any part of the recording at the carrier, as a mean: sums from the beginning make that two look-ups.
class Baseband {
public:
    Baseband(const Recording& recording, double carrier_hz) : rate_hz_(recording.rate_hz), sums_{Complex(0.0)} {
        const double mean = std::accumulate(recording.samples.begin(), recording.samples.end(), 0.0) /
                            static_cast<double>(recording.samples.size());
        sums_.reserve(recording.samples.size() + 1);
        // A product is quicker than an angle; what it loses in this many is no more than what a sum does.
        constexpr std::size_t steps = 256;
        const Complex step = std::polar(1.0, -turn * carrier_hz / rate_hz_);
        Complex phasor;
        for (std::size_t i = 0; i < recording.samples.size(); ++i) {
            if (i % steps == 0)
                phasor = std::polar(2.0, -turn * std::fmod(static_cast<double>(i) * carrier_hz / rate_hz_, 1.0));
            sums_.push_back(sums_.back() + (recording.samples[i] - mean) * phasor);
            phasor *= step;
        }
    }
    [[nodiscard]] double seconds() const { return static_cast<double>(sums_.size() - 1) / rate_hz_; }
    [[nodiscard]] Complex mean(double begin_s, double end_s) const {
        const std::size_t begin = at(begin_s), end = std::max(at(end_s), begin + 1);
        return (sums_[end] - sums_[begin]) / static_cast<double>(end - begin);
    }

private:
    [[nodiscard]] std::size_t at(double time_s) const {
        return static_cast<std::size_t>(
            std::clamp(std::lround(time_s * rate_hz_), 0L, static_cast<long>(sums_.size()) - 2L));
    }
    double rate_hz_;
    Complexes sums_;
};

/// Where patterns change, as a time after the beginning that is less than a pattern long: where the sound jumps most.
double first_change_s(const Baseband& sound, double pattern_s) {
    constexpr std::size_t steps = 64;
    const double step_s = pattern_s / steps;
    std::vector<double> jumps(steps);
    for (std::size_t i = 2; static_cast<double>(i + 2) * step_s < sound.seconds(); ++i) {
        const double at_s = static_cast<double>(i) * step_s;
        jumps[i % steps] += std::norm(sound.mean(at_s, at_s + 2.0 * step_s) - sound.mean(at_s - 2.0 * step_s, at_s));
    }
    return static_cast<double>(std::ranges::max_element(jumps) - jumps.begin()) * step_s;
}

/// The carrier's error from how phases move within patterns, Hz.
double rough_error_hz(const Baseband& sound, double first_s, double pattern_s) {
    const double half_s = 0.5 * (1.0 - settling - margin) * pattern_s;
    Complex sum = 0.0;
    for (double begin_s = first_s; begin_s + pattern_s < sound.seconds(); begin_s += pattern_s) {
        const double from_s = begin_s + settling * pattern_s;
        sum += sound.mean(from_s + half_s, from_s + 2.0 * half_s) * std::conj(sound.mean(from_s, from_s + half_s));
    }
    return std::arg(sum) / (turn * half_s);
}

/// One pass of the code, as it would be heard from a time on with the carrier off by a frequency.
struct Pass {
    Complexes columns;
    double silent_share = 1.0;  ///< of the power, in columns that have no element; by chance their share of the columns
};

Pass pass_at(const CalibrationCode& code, std::size_t elements, const Baseband& sound, double begin_s, double error_hz,
             double carrier_hz) {
    const double pattern_s = CalibrationCode::periods / (carrier_hz + error_hz);
    Complexes sounds;
    const double middle_s = begin_s + 0.5 * (1.0 + settling - margin) * pattern_s;
    Complex back = std::polar(1.0, -turn * error_hz * middle_s);
    const Complex step = std::polar(1.0, -turn * error_hz * pattern_s);
    for (std::size_t i = 0; i < code.patterns(); ++i) {
        const double at_s = begin_s + static_cast<double>(i) * pattern_s;
        const double from_s = at_s + settling * pattern_s, to_s = at_s + (1.0 - margin) * pattern_s;
        sounds.push_back(sound.mean(from_s, to_s) * back);
        back *= step;
    }
    Pass pass{code.columns(sounds)};
    double all = 0.0, silent = 0.0;
    for (std::size_t j = 0; j < pass.columns.size(); ++j) {
        all += std::norm(pass.columns[j]);
        if (j >= elements) silent += std::norm(pass.columns[j]);
    }
    if (all > 0.0) pass.silent_share = silent / all;
    return pass;
}

/// The elements that always play while others step: nine around the middle, so that one may be dead.
std::vector<bool> steady_elements(const Array& array) {
    constexpr std::size_t most = 9;
    std::vector<std::size_t> order(array.elements.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t m) { return norm(array.elements[m].position); });
    std::vector<bool> steady(order.size());
    for (std::size_t i = 0; i < std::min(most, order.size()); ++i) steady[order[i]] = true;
    return steady;
}

/// A steady element's sound h, where R, without it, is less than the sum by h: h − |h|² / sum is what was measured. Of
/// the two that are so, the one that is as long as others: where several are reversed, the sum is no longer than that.
Complex steady_sound(Complex measured, double sum, double usual) {
    const double across = measured.imag();
    const double root = std::sqrt(std::max(0.0, 0.25 * sum * sum - sum * measured.real() - across * across));
    const Complex less(0.5 * sum - root, across), more(0.5 * sum + root, across);
    const double off = std::abs(std::abs(more) - usual);
    constexpr double alike = 0.4;  // of the usual; a dead one is measured as 0, whatever the sum
    return off < alike * usual && off < std::abs(std::abs(less) - usual) ? more : less;
}

Image empty_image(const Core& core) {
    Image image;
    image.channels = core.parameters.channels;
    image.clock_hz = core.parameters.clock_hz;
    image.timing_bits = core.parameters.timing_bits;
    image.pulse_bits = core.parameters.pulse_bits;
    return image;
}

Record silent_record(const Timer& timer, const Core& core) {
    return {timer.cycle_ticks, timer.prescaler, static_cast<std::uint8_t>(timer.pulse_ticks),
            std::vector<std::uint16_t>(core.parameters.channels, interface::silent_timing)};
}

/// Elements that play in each part: as many as tell by their phases that the microphone was moved.
constexpr std::size_t in_each_part = 9;

/// The fewest parts, from so many on, that the core holds; none when it holds no number of them.
/// @param records_of  how many the largest of so many parts takes
template <class RecordsOf>
std::optional<std::size_t> fewest_parts(const Core& core, std::size_t from, std::size_t most, RecordsOf records_of) {
    for (std::size_t parts = from; parts <= most; ++parts)
        if (records_of(parts) <= core.parameters.records && records_of(parts) < core.parameters.sequence_depth)
            return parts;
    return {};
}

/// @param fewest  parts that the core holds
/// @param otherwise  what helps when there is no number of them
void require_held(const Array& array, const Core& core, CodePart part, std::size_t records,
                  std::optional<std::size_t> fewest, const char* otherwise) {
    if (fewest == part.of) return;
    throw bad_input(
        core.name,
        fmt::format("for {} elements it takes {} records{}, and the board holds {} (and {} sequence entries); {}",
                    array.elements.size(), records, part.of > 1 ? " a part" : "", core.parameters.records,
                    core.parameters.sequence_depth - 1,
                    fewest ? fmt::format("make it in {0} parts, of which each is played and recorded: --part 1/{0} to "
                                         "{0}/{0}",
                                         *fewest)
                           : otherwise));
}

constexpr const char* of_few_records =
    "no part of the code has fewer than 32: read a meter of amplitudes (calibrate code --steps), which takes 4, or "
    "calibrate the array on a board that holds more";

/// Of the largest part.
std::size_t patterns_of(const Array& array, std::size_t parts) {
    return CalibrationCode(elements_of_part(array, {1, parts}).size()).patterns();
}

std::optional<std::size_t> fewest_parts_of_code(const Array& array, const Core& core, std::size_t from) {
    require_channels(array, core);
    const std::size_t count = array.elements.size();
    return fewest_parts(core, from, std::max(from, count > in_each_part ? count - in_each_part : 1),
                        [&](std::size_t parts) { return patterns_of(array, parts); });
}

/// A converter that is driven too hard has its largest value far more often than the one beside it, which a sound's
/// peaks, in steps however coarse, have not: a steady one's 2.4 times as often.
void refuse_clipped(const Recording& recording) {
    const std::vector<double>& samples = recording.samples;
    const auto [low, high] = std::ranges::minmax_element(samples);
    for (const double extreme : {*low, *high}) {
        double next = extreme == *low ? *high : *low;
        for (const double sample : samples)
            if (sample != extreme && std::abs(sample - extreme) < std::abs(next - extreme)) next = sample;
        const auto count = std::ranges::count(samples, extreme), beside = std::ranges::count(samples, next);
        constexpr std::ptrdiff_t least = 16, times = 5;
        if (extreme != 0.0 && count >= least && count > times * beside)
            throw bad_input(recording.name,
                            fmt::format("it has its extreme value {:g} at {} samples, and the one beside it at {}: it "
                                        "was clipped; lower the recording level, or move the microphone away",
                                        extreme, count, beside));
    }
}

}  // namespace

CalibrationCode::CalibrationCode(std::size_t elements, std::size_t part) {
    if (elements == 0) throw bad_input("calibration", "the array has no elements");
    // At least an eighth as many columns have no element, and at least sixteen.
    negated_.resize(std::bit_ceil(elements + std::max<std::size_t>(16, elements / 8)));
    std::mt19937 random(static_cast<std::uint32_t>(38 + part));
    for (std::size_t i = 0; i < negated_.size(); ++i) {
        negated_[i] = (random() >> 31U) != 0;
        column_of_.push_back(i);
    }
    for (std::size_t i = column_of_.size(); i > 1; --i) std::swap(column_of_[i - 1], column_of_[random() % i]);
}

bool CalibrationCode::turned(std::size_t pattern, std::size_t element) const {
    return (std::popcount(pattern & column_of_[element]) % 2 != 0) != negated_[pattern];
}

std::vector<Complex> CalibrationCode::columns(std::span<const Complex> sounds) const {
    Complexes values(sounds.begin(), sounds.end());
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] *= (negated_[i] ? -1.0 : 1.0) / static_cast<double>(values.size());
    // The fast Hadamard transform, in Sylvester's order.
    for (std::size_t step = 1; step < values.size(); step *= 2)
        for (std::size_t i = 0; i < values.size(); ++i)
            if ((i & step) == 0) {
                const Complex a = values[i], b = values[i + step];
                values[i] = a + b;
                values[i + step] = a - b;
            }
    Complexes found;
    for (const std::size_t column : column_of_) found.push_back(values[column]);
    return found;
}

std::vector<std::size_t> elements_of_part(const Array& array, CodePart part) {
    const std::size_t count = array.elements.size();
    std::vector<std::size_t> found;
    if (part.of <= 1) {
        found.resize(count);
        std::iota(found.begin(), found.end(), std::size_t{0});
        return found;
    }
    if (count <= in_each_part || part.of > count - in_each_part)
        throw bad_argument("part", fmt::format("{} elements cannot be shared out to {} parts", count, part.of));
    std::vector<bool> in_each(count);
    for (std::size_t i = 0; i < in_each_part; ++i) in_each[i * (count - 1) / (in_each_part - 1)] = true;
    std::size_t other = 0;
    for (std::size_t j = 0; j < count; ++j)
        if (in_each[j] || other++ % part.of == part.number - 1) found.push_back(j);
    return found;
}

std::size_t parts_of_code(const Array& array, const Core& core) {
    const std::optional<std::size_t> fewest = fewest_parts_of_code(array, core, 1);
    if (!fewest) require_held(array, core, {}, patterns_of(array, 1), fewest, of_few_records);
    return *fewest;
}

Image calibration_image(const Array& array, const Core& core, CodePart part) {
    require_held(array, core, part, patterns_of(array, part.of), fewest_parts_of_code(array, core, part.of),
                 of_few_records);
    const std::vector<std::size_t> elements = elements_of_part(array, part);
    const CalibrationCode code(elements.size(), part.number);
    const Timer timer = choose_timer(array, core);
    Image image = empty_image(core);
    for (std::size_t i = 0; i < code.patterns(); ++i) {
        Record record = silent_record(timer, core);
        for (std::size_t j = 0; j < elements.size(); ++j)
            record.timings[elements[j]] =
                code.turned(i, j) ? static_cast<std::uint16_t>(timer.cycle_ticks / 2) : std::uint16_t{0};
        image.records.push_back(std::move(record));
        image.sequence.push_back({static_cast<std::uint16_t>(i + 1), CalibrationCode::periods});
    }
    return image;
}

ElementSounds from_patterns(std::span<const Complex> readings, std::size_t elements, const std::string& name,
                            std::size_t part) {
    const CalibrationCode code(elements, part);
    if (readings.size() != code.patterns())
        throw bad_input(name, fmt::format("{} readings at a place, expected {}: one of each record of the code for {} "
                                          "elements",
                                          readings.size(), code.patterns(), elements));
    ElementSounds found{code.columns(readings)};
    double silent = 0.0;
    for (std::size_t j = elements; j < found.sounds.size(); ++j) silent += std::norm(found.sounds[j]);
    const auto columns = static_cast<double>(code.patterns()), unused = columns - static_cast<double>(elements);
    double all = silent;
    for (std::size_t j = 0; j < elements; ++j) all += std::norm(found.sounds[j]);
    if (!(silent < recognised * all * unused / columns))
        throw bad_input(name, fmt::format("the code for {} elements is not in it; see that the board played this "
                                          "array's code",
                                          elements));
    found.noise = std::sqrt(silent / unused);
    found.sounds.resize(elements);
    return found;
}

ElementSounds join_parts(const Array& array, std::span<const ElementSounds> parts, const std::string& name) {
    if (parts.size() == 1) return parts.front();
    const std::size_t count = array.elements.size();
    ElementSounds joined = parts.front();
    joined.sounds.assign(count, 0.0);
    std::vector<double> heard(count, 0.0);  // in how many parts
    double noise = 0.0, clock_ppm = 0.0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const std::vector<std::size_t> elements = elements_of_part(array, {p + 1, parts.size()});
        const Complexes& sounds = parts[p].sounds;
        Complex both = 0.0;
        double before = 0.0, now = 0.0;
        for (std::size_t i = 0; p > 0 && i < elements.size(); ++i)
            if (const std::size_t j = elements[i]; heard[j] > 0.0) {
                both += joined.sounds[j] / heard[j] * std::conj(sounds[i]);
                before += std::norm(joined.sounds[j] / heard[j]);
                now += std::norm(sounds[i]);
            }
        constexpr double alike = 0.95;  // of phases and levels; 3 mm beside its place, it is less
        if (p > 0 && !(std::abs(both) > alike * std::sqrt(before * now)))
            throw bad_input(name,
                            fmt::format("the elements that play in each part sound otherwise in part {} than before; "
                                        "leave the microphone and its level as they are from part to part",
                                        p + 1));
        const Complex turn_by = p > 0 ? both / now : 1.0;
        for (std::size_t i = 0; i < elements.size(); ++i) {
            joined.sounds[elements[i]] += turn_by * sounds[i];
            heard[elements[i]] += 1.0;
        }
        noise += std::norm(turn_by) * parts[p].noise * parts[p].noise / static_cast<double>(parts.size());
        clock_ppm += parts[p].clock_ppm / static_cast<double>(parts.size());
        joined.passes = std::min(joined.passes, parts[p].passes);
    }
    for (std::size_t j = 0; j < count; ++j) joined.sounds[j] /= heard[j];
    joined.noise = std::sqrt(noise);
    joined.clock_ppm = clock_ppm;
    return joined;
}

Image steps_image(const Array& array, const Core& core, Vec3 microphone, CodePart part) {
    const std::size_t count = array.elements.size();
    if (part.of > count)
        throw bad_argument("part", fmt::format("{} elements cannot be shared out to {} parts", count, part.of));
    require_channels(array, core);
    const auto records_of = [&](std::size_t parts) { return 4 * ((count + parts - 1) / parts); };
    require_held(array, core, part, records_of(part.of), fewest_parts(core, part.of, count, records_of),
                 "calibrate the array on a board that holds more");
    const Timer timer = choose_timer(array, core);
    const std::vector<std::uint16_t> focused = focal_law(array, timer, {&microphone, 1});
    const std::vector<bool> steady = steady_elements(array);
    Image image = empty_image(core);
    for (std::size_t j = count * (part.number - 1) / part.of; j < count * part.number / part.of; ++j)
        for (std::uint32_t step = 0; step < 4; ++step) {
            Record record = silent_record(timer, core);
            for (std::size_t m = 0; m < array.elements.size(); ++m)
                if (steady[m]) record.timings[m] = focused[m];
            const std::uint32_t ahead = (step * timer.cycle_ticks + 2) / 4;
            record.timings[j] =
                static_cast<std::uint16_t>((focused[j] + timer.cycle_ticks - ahead) % timer.cycle_ticks);
            image.records.push_back(std::move(record));
            image.sequence.push_back({static_cast<std::uint16_t>(image.records.size()), CalibrationCode::periods});
        }
    return image;
}

ElementSounds from_steps(const Array& array, std::span<const double> readings, Vec3 microphone,
                         const std::string& name) {
    const std::size_t elements = array.elements.size();
    if (readings.size() != 4 * elements)
        throw bad_input(name, fmt::format("{} readings, expected {}: one of each record, four an element",
                                          readings.size(), 4 * elements));
    const std::vector<bool> steady = steady_elements(array);
    const auto square = [&](std::size_t j, std::size_t step) {
        return readings[4 * j + step] * readings[4 * j + step];
    };
    double together = 0.0, count = 0.0;  // the steady ones', squared
    for (std::size_t j = 0; j < elements; ++j)
        if (steady[j]) {
            together += square(j, 0);
            count += 1.0;
        }
    const double sum = std::sqrt(together / count);
    if (!(sum > 0.0)) throw bad_input(name, "the microphone heard nothing of the elements in the middle");
    const std::vector<Complex> focused = ideal_drives(array, microphone);
    ElementSounds found;
    double rest = 0.0;
    std::vector<double> lengths;  // of those that are not steady, if there are any
    for (std::size_t j = 0; j < elements; ++j) {
        // Of the squares |R + h·jˢ|² of the others' sound R and the element's h, differences are 4·Re and −4·Im of
        // R*·h.
        found.sounds.emplace_back((square(j, 0) - square(j, 2)) / 4.0, (square(j, 3) - square(j, 1)) / 4.0);
        found.sounds[j] /= sum;
        if (!steady[j] || elements == static_cast<std::size_t>(count)) lengths.push_back(std::abs(found.sounds[j]));
        rest += std::pow(square(j, 0) + square(j, 2) - square(j, 1) - square(j, 3), 2.0);
    }
    std::ranges::sort(lengths);
    const double usual = lengths[lengths.size() / 2];
    for (std::size_t j = 0; j < elements; ++j) {
        if (steady[j]) found.sounds[j] = steady_sound(found.sounds[j], sum, usual);
        found.sounds[j] *= std::conj(focused[j]) / std::abs(focused[j]);
    }
    found.noise = std::sqrt(rest / static_cast<double>(elements)) / (4.0 * sum);
    return found;
}

ElementSounds decode(const Recording& recording, std::size_t elements, double carrier_hz, std::size_t part) {
    constexpr double least_rate = 2.2;  // of the carrier: a sound card's filter ends before half of its rate
    if (!(recording.rate_hz >= least_rate * carrier_hz))
        throw bad_input(recording.name, fmt::format("{:g} samples a second cannot hold {:g} Hz; record at {:g} Hz or "
                                                    "more",
                                                    recording.rate_hz, carrier_hz, 96e3 * carrier_hz / 40e3));
    const CalibrationCode code(elements, part);
    const double pattern_s = CalibrationCode::periods / carrier_hz;
    const double pass_s = pattern_s * static_cast<double>(code.patterns());
    const double seconds = static_cast<double>(recording.samples.size()) / recording.rate_hz;
    if (seconds < pass_s)
        throw bad_input(recording.name, fmt::format("it is {:.2f} s long, and one pass of the code {:.2f} s; record "
                                                    "twice that, so that it has a whole one",
                                                    seconds, pass_s));
    refuse_clipped(recording);
    const Baseband sound(recording, carrier_hz);
    const double first_s = first_change_s(sound, pattern_s);
    const double rough_hz = rough_error_hz(sound, first_s, pattern_s);
    // The share of the silent columns is least where the code begins, if the carrier is right to a part of a turn a
    // pass.
    const double step_hz = 0.25 / pass_s;
    constexpr double range_hz = 4.0;
    ElementSounds found;
    double least = 1.0, error_hz = rough_hz;
    const auto try_at = [&](double begin_s, double hz) {
        const double share = pass_at(code, elements, sound, begin_s, hz, carrier_hz).silent_share;
        if (share >= least) return;
        least = share;
        found.start_s = begin_s;
        error_hz = hz;
    };
    for (double begin_s = first_s - pattern_s; begin_s + pass_s < seconds + margin * pattern_s; begin_s += pattern_s)
        if (begin_s > -settling * pattern_s)
            for (double hz = rough_hz - range_hz; hz <= rough_hz + range_hz; hz += step_hz) try_at(begin_s, hz);
    const double by_chance = static_cast<double>(code.patterns() - elements) / static_cast<double>(code.patterns());
    if (!(least < recognised * by_chance))
        throw bad_input(
            recording.name,
            fmt::format("the code for {} elements is not in it: what sounds at {:g} Hz is {}; see that the "
                        "board played this array's code, of which all parts belong together, as 1.wav,2.wav, in their "
                        "order, and that the microphone hears 40 kHz",
                        elements, carrier_hz, least == 1.0 ? "nothing" : "something else, or noise"));
    for (double step = step_hz / 2.0; step > 1e-3 * step_hz; step /= 2.0)
        for (const double hz : {error_hz - step, error_hz + step}) try_at(found.start_s, hz);
    // Further passes are turned to the first before they are added.
    const double pass_there_s = pass_s * carrier_hz / (carrier_hz + error_hz);
    const Pass first = pass_at(code, elements, sound, found.start_s, error_hz, carrier_hz);
    Complexes sum = first.columns;
    found.passes = 1;
    for (double begin_s = found.start_s + pass_there_s; begin_s + pass_there_s < seconds; begin_s += pass_there_s) {
        const Pass next = pass_at(code, elements, sound, begin_s, error_hz, carrier_hz);
        if (!(next.silent_share < recognised * by_chance)) break;  // it was stopped there
        Complex both = 0.0;
        for (std::size_t j = 0; j < elements; ++j) both += first.columns[j] * std::conj(next.columns[j]);
        for (std::size_t j = 0; j < sum.size(); ++j) sum[j] += next.columns[j] * both / std::abs(both);
        ++found.passes;
    }
    double silent = 0.0;
    for (std::size_t j = 0; j < sum.size(); ++j) {
        sum[j] /= static_cast<double>(found.passes);
        if (j >= elements) silent += std::norm(sum[j]);
    }
    found.noise = std::sqrt(silent / static_cast<double>(sum.size() - elements));
    found.clock_ppm = error_hz / carrier_hz * 1e6;
    sum.resize(elements);
    found.sounds = std::move(sum);
    return found;
}

}  // namespace haptogram
