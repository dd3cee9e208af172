// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/finger_sound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "haptogram/base/error.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

constexpr std::string_view heading = "haptogram-finger-sound-1";
constexpr double file_step = 0.01;  // of the whole numbers in the file

/// The numbers of the next line that is no comment.
class NumberLines {
public:
    NumberLines(std::string_view text, const std::string& file) : lines_(text), file_(file) {}

    std::string_view line() {
        while (lines_.next())
            if (!lines_.line().empty() && !lines_.line().starts_with('#')) return lines_.line();
        throw bad_input(file_, "ends too early; make the table anew");
    }
    std::vector<double> numbers(std::string_view name) {
        std::string_view rest = line();
        if (!name.empty() && take_word(rest) != name)
            throw bad_input(at_line(file_, lines_.number()), fmt::format("expected '{}'", name));
        std::vector<double> numbers;
        for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
            const std::optional<double> number = parse_number(word);
            if (!number || !std::isfinite(*number))
                throw bad_input(at_line(file_, lines_.number()),
                                fmt::format("found {}, expected a number", shown(word)));
            numbers.push_back(*number);
        }
        return numbers;
    }
    [[nodiscard]] Error wrong(const std::string& what) const {
        return bad_input(at_line(file_, lines_.number()), what);
    }

private:
    Lines lines_;
    const std::string& file_;
};

std::vector<double> rising(NumberLines& lines, std::string_view name) {
    std::vector<double> list = lines.numbers(name);
    if (list.size() < 2 || std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) != list.end())
        throw lines.wrong("expected at least two numbers that rise");
    return list;
}

std::size_t count(NumberLines& lines, std::string_view name) {
    const std::vector<double> list = lines.numbers(name);
    if (list.size() != 1 || !(list[0] >= 2.0 && list[0] <= 1000.0 && list[0] == std::floor(list[0])))
        throw lines.wrong("expected a whole number from 2 to 1000");
    return static_cast<std::size_t>(list[0]);
}

/// Between which two numbers of a rising list a value lies, and how far; the ends stand for what is beyond them.
struct Between {
    std::size_t low;
    float share;
};
Between between(const std::vector<double>& list, double value) {
    const auto above = std::upper_bound(list.begin() + 1, list.end() - 1, value);
    const auto low = static_cast<std::size_t>(above - list.begin()) - 1;
    const double share = (value - list[low]) / (list[low + 1] - list[low]);
    return {low, static_cast<float>(std::clamp(share, 0.0, 1.0))};
}

void blend(const std::complex<float>* low, const std::complex<float>* high, float share, std::size_t count,
           FingerSound::Values& out) {
    out.resize(count);
    for (std::size_t i = 0; i < count; ++i) out[i] = low[i] + share * (high[i] - low[i]);
}

}  // namespace

FingerSound::FingerSound(std::string_view text, const std::string& file) {
    NumberLines lines(text, file);
    if (lines.line() != heading) throw lines.wrong(fmt::format("expected '{}'", heading));
    grid_.sizes = rising(lines, "sizes");
    grid_.ways = rising(lines, "ways");
    grid_.tilts = count(lines, "tilts");
    grid_.turns = count(lines, "turns");
    values_.resize(grid_.sizes.size());
    for (Values& values : values_) {
        for (std::size_t row = 0; row < grid_.ways.size() * grid_.tilts; ++row) {
            const std::vector<double> parts = lines.numbers({});
            if (parts.size() != 2 * grid_.turns)
                throw lines.wrong(fmt::format("found {} numbers, expected {}", parts.size(), 2 * grid_.turns));
            for (std::size_t i = 0; i < grid_.turns; ++i)
                values.emplace_back(static_cast<float>(file_step * parts[2 * i]),
                                    static_cast<float>(file_step * parts[2 * i + 1]));
        }
    }
}

bool FingerSound::knows(double size) const { return size >= grid_.sizes.front() && size <= grid_.sizes.back(); }

FingerSound::Values FingerSound::of_size(double size) const {
    const auto [low, share] = between(grid_.sizes, size);
    Values made;
    blend(values_[low].data(), values_[low + 1].data(), share, values_[low].size(), made);
    return made;
}

void FingerSound::at_way(const Values& of_size, double way, Values& slice) const {
    const auto [low, share] = between(grid_.ways, way);
    const std::complex<float>* const first = of_size.data() + low * grid_.slice();
    blend(first, first + grid_.slice(), share, grid_.slice(), slice);
}

const FingerSound& shipped_finger_sound() {
    static const FingerSound table(shipped_file("shipped:acoustics/finger_sound.txt").value(), "finger_sound.txt");
    return table;
}

std::string write_finger_sound(const FingerSound::Grid& grid, const std::vector<FingerSound::Values>& values) {
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "# SPDX-License-Identifier: Apache-2.0\n");
    fmt::format_to(
        out, "# Sound on a rigid finger in a plane wave, over the wave (haptogram/acoustics/finger_sound.hpp).\n");
    fmt::format_to(
        out,
        "# Generated by haptogram_finger_sound; edit that, not this file. Real and imaginary parts of a hundredth.\n");
    fmt::format_to(out, "{}\nsizes {:g}\nways {:g}\ntilts {}\nturns {}\n", heading, fmt::join(grid.sizes, " "),
                   fmt::join(grid.ways, " "), grid.tilts, grid.turns);
    for (const FingerSound::Values& of_size : values)
        for (std::size_t i = 0; i < of_size.size(); ++i) {
            const auto whole = [](float part) { return std::lround(static_cast<double>(part) / file_step); };
            fmt::format_to(out, "{} {}{}", whole(of_size[i].real()), whole(of_size[i].imag()),
                           (i + 1) % grid.turns == 0 ? "\n" : " ");
        }
    return fmt::to_string(text);
}

}  // namespace haptogram
