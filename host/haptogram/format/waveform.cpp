// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/waveform.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double frequency_tolerance = 1e-3;
constexpr std::uint32_t file_periods_a_sample = 10;
constexpr std::size_t most_file_samples = 1U << 20U;

constexpr const char* kinds =
    "static, sine:HZ, square:HZ:DUTY, abs-sine:HZ, triangle:HZ, sawtooth:HZ, wav:FILE or csv:FILE";

/// A waveform as its integral over the phase, in periods. Its mean over any stretch follows from that.
struct Waveform {
    double frequency_hz = 0.0;  ///< 0: always 1
    std::function<double(double)> integral;
};

/// Makes the integral over any phase from that over one period, 0…1.
std::function<double(double)> repeated(const std::function<double(double)>& within) {
    return [within, whole = within(1.0)](double phase) {
        const double periods = std::floor(phase);
        return periods * whole + within(phase - periods);
    };
}

Error no_waveform(std::string_view text) {
    return bad_argument("am", fmt::format("found {}, expected {}, or several with + between them", shown(text), kinds));
}

std::vector<std::string_view> parts_of(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(separator, begin), text.size());
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

/// One waveform of a text; static has a frequency of 0.
NamedWaveform named_waveform(std::string_view text) {
    const std::vector<std::string_view> parts = parts_of(text, ':');
    const std::string_view kind = parts.front();
    if (kind == "static" && parts.size() == 1) return {std::string(kind), 0.0, 0.5};
    constexpr std::array<std::string_view, 5> known = {"sine", "square", "abs-sine", "triangle", "sawtooth"};
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const double hz = parts.size() > 1 ? parse_number(parts[1]).value_or(none) : none;
    if (std::find(known.begin(), known.end(), kind) == known.end() || std::isnan(hz) ||
        parts.size() > (kind == "square" ? 3U : 2U))
        throw no_waveform(text);
    if (!(hz > 0.0)) throw bad_argument("am", fmt::format("found a frequency of {} Hz, expected more than 0", hz));
    const double duty = parts.size() == 3 ? parse_number(parts[2]).value_or(0.0) : 0.5;
    if (!(duty > 0.0 && duty < 1.0))
        throw bad_argument("am",
                           fmt::format("found a duty of {}, expected more than 0 and less than 1", shown(parts[2])));
    return {std::string(kind), hz, duty};
}

Waveform waveform_of(const NamedWaveform& name, double carrier_hz) {
    if (name.kind == "static") return {0.0, [](double phase) { return phase; }};
    const double hz = name.frequency_hz;
    if (!(hz <= 0.5 * carrier_hz))
        throw bad_argument("am", fmt::format("found a frequency of {} Hz, expected more than 0 and at most half the "
                                             "carrier, {} Hz",
                                             hz, 0.5 * carrier_hz));
    if (name.kind == "square") return {hz, repeated([d = name.duty](double x) { return std::min(x, d); })};
    if (name.kind == "sine")
        return {hz, repeated([](double x) { return 0.5 * x + (1.0 - std::cos(2.0 * pi * x)) / (4.0 * pi); })};
    if (name.kind == "abs-sine") return {hz, repeated([](double x) { return (1.0 - std::cos(pi * x)) / pi; })};
    if (name.kind == "triangle")
        return {hz, repeated([](double x) { return x < 0.5 ? x * x : 0.5 - (1.0 - x) * (1.0 - x); })};
    return {hz, repeated([](double x) { return 0.5 * x * x; })};  // sawtooth
}

/// How many samples, of how many carrier periods, hold whole periods of all frequencies.
struct Length {
    std::size_t samples = 1;
    std::uint32_t periods_a_sample = 1;
};

Length length_for(const std::vector<Waveform>& waveforms, double carrier_hz, std::size_t most_samples) {
    double slowest = carrier_hz;
    bool any = false;
    for (const Waveform& w : waveforms) {
        if (w.frequency_hz == 0.0) continue;
        slowest = std::min(slowest, w.frequency_hz);
        any = true;
    }
    if (!any) return {};
    Length best;
    best.periods_a_sample =
        static_cast<std::uint32_t>(std::ceil(carrier_hz / slowest / static_cast<double>(most_samples)));
    const double sample_hz = carrier_hz / best.periods_a_sample;
    double least_error = std::numeric_limits<double>::infinity();
    for (auto n = static_cast<std::size_t>(std::max(1.0, std::floor(sample_hz / slowest))); n <= most_samples; ++n) {
        double error = 0.0;
        for (const Waveform& w : waveforms) {
            if (w.frequency_hz == 0.0) continue;
            const double periods = w.frequency_hz * static_cast<double>(n) / sample_hz;
            const double whole = std::max(1.0, std::round(periods));
            error = std::max(error, std::abs(whole / periods - 1.0));
        }
        if (error < least_error) {
            least_error = error;
            best.samples = n;
        }
        if (error <= frequency_tolerance) break;
    }
    return best;
}

void apply(AmplitudeLaw law, std::vector<double>& samples) {
    for (double& sample : samples) {
        sample = std::clamp(sample, 0.0, 1.0);  // rounding
        if (law == AmplitudeLaw::radiation) sample = std::sqrt(sample);
    }
}

/// A value in little-endian bytes.
template <class Value>
Value take(std::string_view bytes, std::size_t at) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(Value); ++i)
        bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
    Value value;
    std::memcpy(&value, &bits, sizeof value);  // the hosts that Highway knows and we build for are little-endian
    return value;
}

double sample_of(std::string_view bytes, std::size_t at, std::size_t width, bool is_float) {
    if (is_float) return width == 4 ? static_cast<double>(take<float>(bytes, at)) : take<double>(bytes, at);
    if (width == 1) return (static_cast<double>(static_cast<unsigned char>(bytes[at])) - 128.0) / 128.0;
    std::uint32_t bits = 0;  // the sample's bytes at the top, so that its sign is the word's
    for (std::size_t i = 0; i < width; ++i)
        bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * (4 - width + i));
    return static_cast<double>(static_cast<std::int32_t>(bits)) / 2147483648.0;
}

std::size_t samples_of_file(double length_s, double sample_hz, const std::string& where) {
    const double count = std::round(length_s * sample_hz);
    if (!(count >= 1.0 && count <= static_cast<double>(most_file_samples)))
        throw bad_input(where, fmt::format("it lasts {:.6g} s; expected {:.6g} s to {:.6g} s", length_s,
                                           1.0 / sample_hz, static_cast<double>(most_file_samples) / sample_hz));
    return static_cast<std::size_t>(count);
}

std::vector<double> samples_of_csv(std::string_view text, const std::string& where, double sample_hz) {
    std::vector<std::pair<double, double>> rows;
    Fields fields;
    char separator = 0;
    double seconds = 1.0;
    for (Lines lines(without_byte_order_mark(text)); lines.next();) {
        std::string_view rest = lines.line();
        if (const auto word = take_word(rest); word.empty() || word.starts_with('#')) continue;
        const std::string line = at_line(where, lines.number());
        const bool first = separator == 0;
        if (first) separator = separator_of(lines.line());
        split_at(separator, lines.line(), fields);
        if (first) {
            const bool in_ms = fields.size() == 2 && lower_case(fields[0]) == "time_ms";
            if (fields.size() != 2 || (!in_ms && lower_case(fields[0]) != "time_s") ||
                lower_case(fields[1]) != "amplitude")
                throw bad_input(line, "expected a first row \"time_s,amplitude\" or \"time_ms,amplitude\"");
            seconds = in_ms ? 1e-3 : 1.0;
            continue;
        }
        const auto time = fields.size() == 2 ? parse_number(fields[0]) : std::nullopt;
        const auto value = fields.size() == 2 ? parse_number(fields[1]) : std::nullopt;
        if (!time || !value || !std::isfinite(*time) || !(*value >= 0.0 && *value <= 1.0))
            throw bad_input(line,
                            fmt::format("found {}, expected a time and an amplitude from 0 to 1", shown(lines.line())));
        if (!rows.empty() && !(*time * seconds > rows.back().first))
            throw bad_input(line, "the time does not rise from the row before");
        rows.emplace_back(*time * seconds, *value);
    }
    if (rows.size() < 2) throw bad_input(where, "expected at least two rows; the last one's time is the end");
    const std::size_t count = samples_of_file(rows.back().first - rows.front().first, sample_hz, where);
    std::vector<double> samples;
    auto next = rows.begin() + 1;
    for (std::size_t i = 0; i < count; ++i) {
        const double time = rows.front().first + (static_cast<double>(i) + 0.5) / sample_hz;
        while (next->first < time && next + 1 != rows.end()) ++next;
        const auto& [last_time, last] = *(next - 1);
        samples.push_back(last + (next->second - last) * std::min(1.0, (time - last_time) / (next->first - last_time)));
    }
    return samples;
}

MadeModulation from_file(std::string_view kind, const std::filesystem::path& file, AmplitudeLaw law,
                         double carrier_hz) {
    const double sample_hz = carrier_hz / file_periods_a_sample;
    const std::string where = file.string();
    const std::string content = read_file(file);
    std::vector<double> samples;
    if (kind == "csv") {
        samples = samples_of_csv(content, where, sample_hz);
    } else {
        const Wave wave = wave_from_wav(content, where);
        const double length_s = static_cast<double>(wave.samples.size()) / wave.rate_hz;
        samples = resampled(wave.samples, wave.rate_hz, sample_hz, samples_of_file(length_s, sample_hz, where));
        for (double& sample : samples) sample = 0.5 + 0.5 * sample;
    }
    apply(law, samples);
    const double repeats_hz = sample_hz / static_cast<double>(samples.size());
    return {{std::move(samples), file_periods_a_sample}, {repeats_hz}};
}

}  // namespace

std::optional<NamedWaveform> single_waveform(std::string_view text) {
    if (text.empty() || text.starts_with("wav:") || text.starts_with("csv:") || text.find('+') != text.npos)
        return std::nullopt;
    NamedWaveform name = named_waveform(text);
    if (name.kind == "static") return std::nullopt;
    return name;
}

MadeModulation modulation_of(std::string_view text, AmplitudeLaw law, double carrier_hz,
                             const std::filesystem::path& folder, std::size_t most_samples) {
    for (const std::string_view kind : {"wav", "csv"})
        if (text.starts_with(kind) && text.substr(kind.size()).starts_with(':'))
            return from_file(kind, folder / std::filesystem::path(text.substr(kind.size() + 1)), law, carrier_hz);
    std::vector<Waveform> waveforms;
    for (const std::string_view part : parts_of(text, '+'))
        waveforms.push_back(waveform_of(named_waveform(part), carrier_hz));
    const Length length = length_for(waveforms, carrier_hz, most_samples);
    const double sample_hz = carrier_hz / length.periods_a_sample;
    const auto count = static_cast<double>(length.samples);
    MadeModulation made;
    made.modulation.periods_a_sample = length.periods_a_sample;
    made.modulation.samples.assign(length.samples, 0.0);
    for (const Waveform& waveform : waveforms) {
        const double periods =
            waveform.frequency_hz == 0.0 ? 1.0 : std::max(1.0, std::round(waveform.frequency_hz * count / sample_hz));
        made.frequencies_hz.push_back(waveform.frequency_hz == 0.0 ? 0.0 : periods * sample_hz / count);
        for (std::size_t i = 0; i < length.samples; ++i) {
            const double from = periods * static_cast<double>(i) / count;
            const double to = periods * static_cast<double>(i + 1) / count;
            made.modulation.samples[i] +=
                (waveform.integral(to) - waveform.integral(from)) / (to - from) / static_cast<double>(waveforms.size());
        }
    }
    apply(law, made.modulation.samples);
    return made;
}

std::array<double, 32> hoshi_frequencies_hz() {
    std::array<double, 32> frequencies{};
    for (std::size_t i = 0; i < frequencies.size(); ++i)
        frequencies.at(i) = std::pow(1000.0, static_cast<double>(i) / 31.0);
    return frequencies;
}

double mean_of(const Modulation& modulation) {
    if (modulation.samples.empty()) return 1.0;
    return std::accumulate(modulation.samples.begin(), modulation.samples.end(), 0.0) /
           static_cast<double>(modulation.samples.size());
}

double mean_square_of(const Modulation& modulation) {
    if (modulation.samples.empty()) return 1.0;
    return std::inner_product(modulation.samples.begin(), modulation.samples.end(), modulation.samples.begin(), 0.0) /
           static_cast<double>(modulation.samples.size());
}

Wave wave_from_wav(std::string_view bytes, const std::string& where) {
    if (bytes.size() < 12 || bytes.substr(0, 4) != "RIFF" || bytes.substr(8, 4) != "WAVE")
        throw bad_input(where, "not a WAV file; save the sound as WAV, PCM, one channel");
    Wave wave;
    std::uint16_t coding = 0, channels = 0, bits = 0;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
        const std::string_view name = bytes.substr(at, 4);
        std::size_t size = take<std::uint32_t>(bytes, at + 4);
        at += 8;
        // A pipe cannot go back and say how long the sound has become.
        constexpr std::size_t by_pipe = 0xFFFFFFFF;
        const bool unknown = size == by_pipe || (size == 0 && take<std::uint32_t>(bytes, 4) == 0);
        if (name == "data" && unknown) size = bytes.size() - at;
        if (size > bytes.size() - at)
            throw bad_input(where, fmt::format("a chunk of {} bytes, but {} are left; the file was cut short", size,
                                               bytes.size() - at));
        if (name == "fmt ") {
            if (size < 16) throw bad_input(where, "its format chunk is too short; save the sound again");
            coding = take<std::uint16_t>(bytes, at);
            channels = take<std::uint16_t>(bytes, at + 2);
            wave.rate_hz = take<std::uint32_t>(bytes, at + 4);
            bits = take<std::uint16_t>(bytes, at + 14);
            if (coding == 0xFFFE && size >= 26) coding = take<std::uint16_t>(bytes, at + 24);  // "extensible"
        } else if (name == "data") {
            const bool pcm = coding == 1 && (bits == 8 || bits == 16 || bits == 24 || bits == 32);
            const bool is_float = coding == 3 && (bits == 32 || bits == 64);
            if (!pcm && !is_float)
                throw bad_input(where, fmt::format("coding {} with {} bits; expected PCM of 8, 16, 24 or 32 bits, or "
                                                   "float",
                                                   coding, bits));
            if (channels != 1)
                throw bad_input(where,
                                fmt::format("{0} channels, expected one; keep one of them (sox {1} one.wav remix 1)",
                                            channels, where));
            if (!(wave.rate_hz > 0.0)) throw bad_input(where, "a rate of 0 samples a second");
            const std::size_t width = bits / 8U;
            for (std::size_t i = 0; i + width <= size; i += width) {
                const double value = sample_of(bytes, at + i, width, is_float);
                if (!(value >= -1.0 && value <= 1.0))
                    throw bad_input(where, fmt::format("sample {} is {}; expected −1 to 1", i / width + 1, value));
                wave.samples.push_back(value);
            }
            if (wave.samples.empty()) throw bad_input(where, "it has no samples");
            return wave;
        }
        at += size + size % 2;
    }
    throw bad_input(where, "it has no sound data; save the sound again");
}

std::vector<double> resampled(std::span<const double> samples, double rate_hz, double new_rate_hz, std::size_t count) {
    constexpr double lobes = 16.0;  // on either side
    // In units of the old samples; a lower new rate widens the kernel, which filters out what it cannot hold.
    const double cutoff = std::min(1.0, new_rate_hz / rate_hz);
    const double reach = lobes / cutoff;
    const auto size = static_cast<std::ptrdiff_t>(samples.size());
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
        const double at = (static_cast<double>(i) + 0.5) * rate_hz / new_rate_hz - 0.5;
        double sum = 0.0, weights = 0.0;
        for (auto k = static_cast<std::ptrdiff_t>(std::ceil(at - reach)); static_cast<double>(k) <= at + reach; ++k) {
            const double x = (static_cast<double>(k) - at) * cutoff;
            const double sinc = x == 0.0 ? 1.0 : std::sin(pi * x) / (pi * x);
            const double weight = sinc * (0.5 + 0.5 * std::cos(pi * x / lobes));
            sum += weight * samples[static_cast<std::size_t>(((k % size) + size) % size)];
            weights += weight;
        }
        result.push_back(std::clamp(sum / weights, -1.0, 1.0));  // between the samples it may overshoot
    }
    return result;
}

}  // namespace haptogram
