// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <sndfile.hh>
#include <string_view>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram::cli {
namespace {

/// The two numbers that a line begins with.
std::optional<std::pair<double, double>> numbers_of(std::string_view line) {
    double values[2];
    for (double& value : values) {
        line.remove_prefix(std::min(line.find_first_not_of(" \t,;"), line.size()));
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
        if (error != std::errc() || !std::isfinite(value)) return {};
        line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    }
    return std::pair(values[0], values[1]);
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
        times.push_back(values->first);
        recording.samples.push_back(values->second);
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
    std::size_t number = 1;
    for (std::size_t begin = text.find('\n'); begin != std::string::npos && begin + 1 < text.size(); ++number) {
        const std::size_t end = std::min(text.find('\n', begin + 1), text.size());
        const std::string_view line(text.data() + begin + 1, end - begin - 1);
        begin = end;
        const auto values = numbers_of(line);
        constexpr double most = 65535.0;
        if (!values || !(values->first >= 1.0 && values->first <= most) || !(values->second >= 0.0) ||
            values->first != std::floor(values->first))
            throw bad_input(fmt::format("{}:{}", file, number + 1),
                            fmt::format("expected a record's index and a reading, not negative, found '{}'", line));
        const auto at = static_cast<std::size_t>(values->first) - 1;
        if (at >= readings.size()) readings.resize(at + 1, -1.0);
        if (readings[at] >= 0.0)
            throw bad_input(fmt::format("{}:{}", file, number + 1), fmt::format("record {} was read before", at + 1));
        readings[at] = values->second;
    }
    for (std::size_t i = 0; i < readings.size(); ++i)
        if (readings[i] < 0.0) throw bad_input(file, fmt::format("no reading of record {}", i + 1));
    return readings;
}

Recording read_recording(const std::string& file) {
    if (ending_of(file) == ".csv") return read_csv(file);
    SndfileHandle sound(file);
    if (sound.error() != SF_ERR_NO_ERROR)
        throw bad_input(file, fmt::format("no sound file that can be read: {} Take .wav, .flac, or the .csv of an "
                                          "oscilloscope.",
                                          sound.strError()));
    if (sound.channels() != 1)
        throw bad_input(file, fmt::format("{} channels; keep the microphone's alone (sox {} one.wav remix 1)",
                                          sound.channels(), file));
    Recording recording{file, static_cast<double>(sound.samplerate()),
                        std::vector<double>(static_cast<std::size_t>(sound.frames()))};
    const sf_count_t read = sound.readf(recording.samples.data(), sound.frames());
    if (read != sound.frames())
        throw bad_input(file, fmt::format("it ends after {} of {} samples; record it again", read, sound.frames()));
    return recording;
}

}  // namespace haptogram::cli
