// SPDX-License-Identifier: Apache-2.0
#include "haptogram/calibration/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/waveform.hpp"

namespace haptogram {
namespace {

/// The numbers that a line begins with.
template <std::size_t count = 2>
std::optional<std::array<double, count>> numbers_of(std::string_view line) {
    std::array<double, count> values;
    for (double& value : values) {
        line.remove_prefix(std::min(line.find_first_not_of(" \t,;"), line.size()));
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
        if (error != std::errc() || !std::isfinite(value)) return {};
        line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    }
    return values;
}

constexpr double most_records = 65535.0;
bool is_index(double number) { return number >= 1.0 && number <= most_records && number == std::floor(number); }

/// The lines behind the header.
template <class Take>
void each_line(const std::string& file, const std::string& text, Take take) {
    std::size_t number = 2;
    for (std::size_t begin = text.find('\n'); begin != std::string::npos && begin + 1 < text.size(); ++number) {
        const std::size_t end = std::min(text.find('\n', begin + 1), text.size());
        take(std::string_view(text.data() + begin + 1, end - begin - 1), fmt::format("{}:{}", file, number));
        begin = end;
    }
}

Recording read_csv(const std::string& file) {
    const std::string text = read_file(file);
    Recording recording{file, 0.0, {}};
    std::vector<double> times;
    std::size_t number = 0;
    for (std::size_t begin = 0; begin < text.size(); ++number) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        const std::string_view line(text.data() + begin, end - begin);
        begin = end + 1;
        const auto values = numbers_of(line);
        if (!values && times.empty()) continue;  // an oscilloscope's heading
        if (!values)
            throw bad_input(fmt::format("{}:{}", file, number + 1),
                            fmt::format("expected a time and a voltage, found '{}'", line));
        times.push_back((*values)[0]);
        recording.samples.push_back((*values)[1]);
    }
    if (times.size() < 2) throw bad_input(file, "no lines of time and voltage; export the trace as CSV");
    const double step_s = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
    for (std::size_t i = 0; i < times.size(); ++i)
        if (!(std::abs(times[i] - times.front() - static_cast<double>(i) * step_s) < 0.5 * step_s))
            throw bad_input(file, fmt::format("sample {} is at {:g} s; times must rise in even steps, here of {:g} s",
                                              i + 1, times[i], step_s));
    recording.rate_hz = 1.0 / step_s;
    return recording;
}

}  // namespace

std::optional<std::vector<double>> read_steps(const std::string& file) {
    if (ending_of(file) != ".csv") return {};
    const std::string text = read_file(file);
    constexpr std::string_view header = "index,reading";
    if (!text.starts_with(header)) return {};
    std::vector<double> readings;
    each_line(file, text, [&](std::string_view line, const std::string& where) {
        const auto values = numbers_of(line);
        if (!values || !is_index((*values)[0]) || !((*values)[1] >= 0.0))
            throw bad_input(where,
                            fmt::format("expected a record's index and a reading, not negative, found '{}'", line));
        const auto at = static_cast<std::size_t>((*values)[0]) - 1;
        if (at >= readings.size()) readings.resize(at + 1, -1.0);
        if (readings[at] >= 0.0) throw bad_input(where, fmt::format("record {} was read before", at + 1));
        readings[at] = (*values)[1];
    });
    for (std::size_t i = 0; i < readings.size(); ++i)
        if (readings[i] < 0.0) throw bad_input(file, fmt::format("no reading of record {}", i + 1));
    return readings;
}

std::optional<Scan> read_scan(const std::string& file) {
    if (ending_of(file) != ".csv") return {};
    const std::string text = read_file(file);
    const bool complex = text.starts_with("x_mm,y_mm,z_mm,index,re,im");
    if (!complex && !text.starts_with("x_mm,y_mm,z_mm,index,reading")) return {};
    std::map<std::array<double, 3>, std::map<std::size_t, std::complex<double>>> places;
    each_line(file, text, [&](std::string_view line, const std::string& where) {
        const std::optional<std::array<double, 6>> values =
            numbers_of<6>(complex ? std::string(line) : fmt::format("{},0", line.substr(0, line.find('\r'))));
        if (!values || !is_index((*values)[3]) || !(complex || (*values)[4] >= 0.0))
            throw bad_input(where,
                            fmt::format("expected three coordinates, a record's index and {}, found '{}'",
                                        complex ? "the two parts of a reading" : "a reading, not negative", line));
        const auto& [x, y, z, index, re, im] = *values;
        if (!places[{x, y, z}].try_emplace(static_cast<std::size_t>(index), re, im).second)
            throw bad_input(where, fmt::format("record {} was read at this place before", index));
    });
    if (places.empty()) throw bad_input(file, "no lines behind the header; export the scan again");
    Scan scan{!complex, {}};
    const std::size_t records = places.begin()->second.rbegin()->first;
    for (const auto& [at, of_records] : places) {
        StageReadings& place = scan.places.emplace_back(StageReadings{from_mm(at[0], at[1], at[2]), {}});
        for (std::size_t index = 1; index <= records; ++index) {
            const auto found = of_records.find(index);
            if (found == of_records.end() || of_records.size() > records)
                throw bad_input(file, fmt::format("{} records were read at ({}, {}, {}), and {} at the first place; "
                                                  "read each record at each place",
                                                  of_records.size(), at[0], at[1], at[2], records));
            place.readings.push_back(found->second);
        }
    }
    return scan;
}

Recording read_recording(const std::string& file) {
    if (ending_of(file) == ".csv") return read_csv(file);
    Wave wave = wave_from_wav(read_file(file), file);
    return {file, wave.rate_hz, std::move(wave.samples)};
}

namespace {

/// What one file says of one place, or of each of a stage's.
struct HeardPart {
    Vec3 off;
    std::vector<double> amplitudes;  ///< of the records of steps_image(); or
    ElementSounds sounds;            ///< of a part's elements
};

std::vector<HeardPart> heard_in(const std::string& file, const Array& array, CodePart part) {
    const std::size_t elements = elements_of_part(array, part).size();
    std::vector<HeardPart> found;
    if (const auto scan = read_scan(file)) {
        for (const StageReadings& place : scan->places) {
            HeardPart& one = found.emplace_back();
            one.off = place.off;
            if (scan->amplitudes)
                for (const auto& reading : place.readings) one.amplitudes.push_back(reading.real());
            else
                one.sounds = from_patterns(place.readings, elements, file, part.number);
        }
    } else if (auto readings = read_steps(file)) {
        found.push_back({{}, std::move(*readings), {}});
    } else {
        found.push_back({{}, {}, decode(read_recording(file), elements, array.carrier_hz, part.number)});
    }
    return found;
}

}  // namespace

std::vector<std::string> files_of_recording(const std::string& recording) {
    if (std::filesystem::exists(recording)) return {recording};
    std::vector<std::string> files;
    for (std::size_t begin = 0; begin <= recording.size();) {
        const std::size_t end = std::min(recording.find(',', begin), recording.size());
        files.push_back(recording.substr(begin, end - begin));
        begin = end + 1;
    }
    return files;
}

std::vector<HeardAt> hear(const std::string& recording, const Array& array, Vec3 at) {
    const std::vector<std::string> files = files_of_recording(recording);
    std::vector<std::vector<HeardPart>> parts;
    for (std::size_t p = 0; p < files.size(); ++p) {
        parts.push_back(heard_in(files[p], array, {p + 1, files.size()}));
        const auto alike = [](const HeardPart& a, const HeardPart& b) {
            return a.off == b.off && a.amplitudes.empty() == b.amplitudes.empty();
        };
        if (!std::ranges::equal(parts.back(), parts.front(), alike))
            throw bad_input(files[p],
                            fmt::format("it is read at other places or by another meter than {}; the parts of "
                                        "a code belong to one microphone at one place, or to one scan",
                                        files.front()));
    }
    std::vector<HeardAt> heard;
    for (std::size_t place = 0; place < parts.front().size(); ++place) {
        std::vector<double> amplitudes;
        std::vector<ElementSounds> sounds;
        for (const std::vector<HeardPart>& part : parts) {
            amplitudes.insert(amplitudes.end(), part[place].amplitudes.begin(), part[place].amplitudes.end());
            sounds.push_back(part[place].sounds);
        }
        heard.push_back(
            {amplitudes.empty() ? join_parts(array, sounds, recording) : from_steps(array, amplitudes, at, recording),
             at + parts.front()[place].off});
    }
    return heard;
}

}  // namespace haptogram
