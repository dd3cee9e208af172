// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr std::uint64_t longest_observation = 10'000'000;  ///< that a sequence and a modulation meet again after

/// A stretch of one set of drives with one factor on its pressure.
struct Held {
    std::size_t set = 0;
    double factor = 1.0;
    std::uint64_t periods = 0;
};

std::vector<Held> stretches_of(const DriveSequence& sequence, const Modulation& modulation) {
    std::vector<Held> found;
    const std::uint64_t round = modulation.samples.size() * modulation.periods_a_sample;
    const std::uint64_t end = round > 0 ? std::lcm(sequence.periods(), round) : sequence.periods();
    if (end > longest_observation)
        throw bad_argument("am", fmt::format("it and what plays meet again after {} carrier periods only, of at most "
                                             "{}; take a rate that divides the modulation's frequency",
                                             end, longest_observation));
    for (std::uint64_t now = 0; now < end;)
        for (const DriveSequence::Step& step : sequence.steps)
            for (const std::uint64_t until = now + step.periods; now < until;) {
                if (round == 0) {
                    found.push_back({step.set, 1.0, step.periods});
                } else {
                    const std::uint64_t sample = now / modulation.periods_a_sample;
                    const std::uint64_t next = std::min(until, (sample + 1) * modulation.periods_a_sample);
                    found.push_back({step.set, modulation.samples[sample % modulation.samples.size()], next - now});
                }
                now += found.back().periods;
            }
    return found;
}

/// What each set of drives adds to a reading, for each set that has a part in it.
using Parts = std::map<std::size_t, std::complex<double>>;

/// Different windows of an observation, and how often each one comes.
struct Windows {
    std::vector<Parts> parts;
    std::vector<double> times;
};

Windows windows_of(const std::vector<Held>& stretches, double carrier_hz, const Probe& probe) {
    if (!(probe.hz <= carrier_hz / 2.0))
        throw bad_argument("probe", fmt::format("{:g} Hz lie above half the carrier's {:g} Hz", probe.hz, carrier_hz));
    const double turns = std::max(1.0, std::round(probe.window_s * probe.hz));
    const auto length = static_cast<std::uint64_t>(std::round(turns / probe.hz * carrier_hz));
    std::vector<std::uint64_t> begins;  // of the stretches, and the end of all
    std::uint64_t all = 0;
    for (const Held& stretch : stretches) {
        begins.push_back(all);
        all += stretch.periods;
    }
    const auto count =
        std::max<std::uint64_t>(1, static_cast<std::uint64_t>(probe.observation_s * carrier_hz) / length);
    std::map<std::uint64_t, std::size_t> seen;  // by where they begin
    Windows found;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t begin = i * length % all;
        const auto [at, is_new] = seen.try_emplace(begin, found.parts.size());
        if (!is_new) {
            ++found.times[at->second];
            continue;
        }
        found.times.push_back(1.0);
        Parts& parts = found.parts.emplace_back();
        auto where =
            static_cast<std::size_t>(std::upper_bound(begins.begin(), begins.end(), begin) - begins.begin()) - 1;
        std::uint64_t now = begin;  // within the sequence
        for (std::uint64_t n = 0; n < length; ++n) {
            const Held& stretch = stretches[where];
            const double angle = -2.0 * std::numbers::pi *
                                 std::fmod(turns * static_cast<double>(n), static_cast<double>(length)) /
                                 static_cast<double>(length);
            parts[stretch.set] +=
                std::polar(2.0 / static_cast<double>(length) * stretch.factor * stretch.factor, angle);
            if (++now == all) now = 0;
            if (now == (where + 1 < begins.size() ? begins[where + 1] : 0)) where = (where + 1) % stretches.size();
        }
    }
    return found;
}

/// Shares of the time by sets, times the factor on the pressure.
Parts shares_of(const std::vector<Held>& stretches) {
    Parts found;
    double all = 0.0;
    for (const Held& stretch : stretches) {
        found[stretch.set] += stretch.factor * static_cast<double>(stretch.periods);
        all += static_cast<double>(stretch.periods);
    }
    for (auto& [set, share] : found) share /= all;
    return found;
}

}  // namespace

Probe probe_of(std::string_view text) {
    if (text == "haptogram") return {true, 9e-3, 0.0, 0.0, 0.0};
    constexpr std::string_view hoshi = "hoshi:";
    double hz = 0.0;
    const char* const end = text.data() + text.size();
    if (text.starts_with(hoshi))
        if (const auto [stop, error] = std::from_chars(text.data() + hoshi.size(), end, hz);
            error == std::errc() && stop == end && hz > 0.0 && std::isfinite(hz))
            return {false, 2e-3, hz, 0.1, 60.0};
    throw bad_argument("probe", fmt::format("expected haptogram, or hoshi: and the modulation's frequency in Hz, such "
                                            "as hoshi:100; found '{}'",
                                            text));
}

Field probe_field(const Array& array, const DriveSequence& sequence, const Modulation& modulation, const Region& region,
                  const Probe& probe, unsigned threads, const Progress& progress) {
    if (!sequence.repeats || sequence.periods() == 0)
        throw bad_input("sequence",
                        "fewer than two whole passes were measured; a probe reads what repeats, so simulate "
                        "more passes");
    const std::vector<Held> stretches = stretches_of(sequence, modulation);
    const Windows windows = probe.receives_ultrasound ? Windows{{shares_of(stretches)}, {1.0}}
                                                      : windows_of(stretches, sequence.carrier_hz, probe);
    std::vector<bool> used(sequence.drives.size());
    for (const Parts& parts : windows.parts)
        for (const auto& [set, part] : parts) used[set] = true;

    Field found;
    found.region = region;
    found.title = array.name;
    found.error = 1e-4;
    const std::size_t count = region.grid.size();
    if (probe.receives_ultrasound) {
        found.quantity = "rectified_pressure_pa";
        found.label = "mean of the rectified pressure at a receiver / Pa rms";
        found.parts.resize(1);
    } else {
        found.quantity = "radiation_pressure_pa";
        found.label = fmt::format("radiation pressure at {:g} Hz, greatest of a minute / Pa", probe.hz);
        found.parts.resize(3);
        found.names = {"mean", "least", "greatest"};
    }
    for (auto& part : found.parts) part.reserve(count);
    const std::vector<DiscNode> nodes = disc_nodes(probe.aperture_m, array.wavelength_m());
    FieldOptions options;
    options.threads = threads;
    constexpr std::size_t at_once = 1024;
    for (std::size_t begin = 0; begin < count; begin += at_once) {
        const std::size_t many = std::min(at_once, count - begin);
        std::vector<Vec3> points;
        for (std::size_t i = 0; i < many; ++i)
            for (const DiscNode& node : nodes) points.push_back(region.point(begin + i) + Vec3{node.x, node.y, 0.0});
        std::vector<std::vector<double>> signals(sequence.drives.size());  // one a set and a point
        for (std::size_t set = 0; set < signals.size(); ++set) {
            if (!used[set]) continue;
            const std::vector<std::complex<float>> pressures =
                pressure_at(array, sequence.drives[set], points, options);
            for (std::size_t i = 0; i < many; ++i) {
                std::complex<double> mean;
                double pressed = 0.0;
                for (std::size_t j = 0; j < nodes.size(); ++j) {
                    const std::complex<double> p(pressures[i * nodes.size() + j]);
                    mean += nodes[j].weight * p;
                    pressed += nodes[j].weight * radiation_pressure(p, array.medium);
                }
                signals[set].push_back(probe.receives_ultrasound ? std::abs(mean) / std::numbers::sqrt2 : pressed);
            }
        }
        for (std::size_t i = 0; i < many; ++i) {
            double sum = 0.0, times = 0.0, least = INFINITY, greatest = 0.0;
            for (std::size_t w = 0; w < windows.parts.size(); ++w) {
                std::complex<double> reading;
                for (const auto& [set, part] : windows.parts[w]) reading += part * signals[set][i];
                sum += windows.times[w] * std::abs(reading);
                times += windows.times[w];
                least = std::min(least, std::abs(reading));
                greatest = std::max(greatest, std::abs(reading));
            }
            const std::array<double, 3> read = {sum / times, least, greatest};
            for (std::size_t part = 0; part < found.parts.size(); ++part)
                found.parts[part].push_back(static_cast<float>(read[part]));
        }
        progress(static_cast<double>(begin + many) / static_cast<double>(count));
    }
    return found;
}

}  // namespace haptogram
