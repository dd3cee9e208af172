// SPDX-License-Identifier: Apache-2.0
#include "haptogram/formats/svg_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram::formats {

void Pen::move(Point to) {
    at_ = start_ = to;
    drawing_ = false;
}

void Pen::add(Point p) {
    if (!drawing_) strokes_.push_back({to_mm_(start_)});
    drawing_ = true;
    strokes_.back().push_back(p);
}

void Pen::line(Point to) {
    add(to_mm_(to));
    at_ = to;
}

void Pen::cubic(Point first, Point second, Point to) {
    const Point p[] = {to_mm_(at_), to_mm_(first), to_mm_(second), to_mm_(to)};
    const double bend = std::max(std::abs(p[0] - 2.0 * p[1] + p[2]), std::abs(p[1] - 2.0 * p[2] + p[3]));
    constexpr double within_mm = 1e-3, most_pieces = 256.0;
    // Wang's bound (1984) on the distance between a Bézier curve and its chords.
    const double pieces = std::clamp(std::ceil(std::sqrt(0.75 * bend / within_mm)), 1.0, most_pieces);
    for (double k = 1.0; k < pieces; ++k) {
        const double t = k / pieces, u = 1.0 - t;
        add(u * u * u * p[0] + 3.0 * u * u * t * p[1] + 3.0 * u * t * t * p[2] + t * t * t * p[3]);
    }
    line(to);
}

void Pen::arc(double rx, double ry, double turn_deg, bool large, bool sweep, Point to) {
    rx = std::abs(rx);
    ry = std::abs(ry);
    if (to == at_) return;
    if (rx == 0.0 || ry == 0.0) return line(to);
    const Point turn = std::polar(1.0, turn_deg * std::numbers::pi / 180.0);
    // In units of the radii, along the axes.
    const auto inwards = [&](Point p) {
        const Point q = p * std::conj(turn);
        return Point{q.real() / rx, q.imag() / ry};
    };
    const Point half = inwards(0.5 * (at_ - to));
    const double length = std::abs(half);
    if (length > 1.0) {  // radii too small to reach grow
        rx *= length;
        ry *= length;
    }
    const Point unit = inwards(0.5 * (at_ - to));
    const double off = std::sqrt(std::max(0.0, 1.0 / std::norm(unit) - 1.0)) * (large == sweep ? -1.0 : 1.0);
    const Point centre{off * unit.imag(), -off * unit.real()};  // from the middle of the ends
    const double begin = std::arg(unit - centre);
    double angle = std::arg((-unit - centre) / (unit - centre));
    if (sweep && angle < 0.0) angle += 2.0 * std::numbers::pi;
    if (!sweep && angle > 0.0) angle -= 2.0 * std::numbers::pi;
    const Point middle = 0.5 * (at_ + to);
    constexpr double pieces_a_turn = 1024.0;
    const double pieces = std::max(1.0, std::ceil(pieces_a_turn * std::abs(angle) / (2.0 * std::numbers::pi)));
    for (double k = 1.0; k < pieces; ++k) {
        const Point q = centre + std::polar(1.0, begin + angle * k / pieces);
        add(to_mm_(middle + Point{q.real() * rx, q.imag() * ry} * turn));
    }
    line(to);
}

void Pen::close() {
    if (drawing_) line(start_);
    if (drawing_) strokes_.back().back() = strokes_.back().front();
    move(start_);
}

void Numbers::skip() {
    const std::size_t next = text_.find_first_not_of(" \t\r\n\f,", from_);
    from_ = next == std::string_view::npos ? text_.size() : next;
}

bool Numbers::at_end() {
    skip();
    return from_ == text_.size();
}

void Numbers::fail(std::string_view expected) {
    skip();
    throw bad_input(
        place_, fmt::format("found {} at character {}, expected {}; draw it again",
                            from_ == text_.size() ? "the end" : shown(text_.substr(from_, 20)), from_ + 1, expected));
}

double Numbers::number() {
    skip();
    std::size_t first = from_;
    if (first < text_.size() && text_[first] == '+') ++first;
    const std::size_t digits = first < text_.size() && text_[first] == '-' && first == from_ ? first + 1 : first;
    double value = 0.0;
    const bool begins =
        digits < text_.size() && (text_[digits] == '.' || (text_[digits] >= '0' && text_[digits] <= '9'));
    const auto [end, error] = std::from_chars(text_.data() + first, text_.data() + text_.size(), value);
    constexpr double most = 1e9;
    if (!begins || error != std::errc() || std::abs(value) > most) fail("a number of at most 1e9");
    from_ = static_cast<std::size_t>(end - text_.data());
    return value;
}

bool Numbers::flag() {
    skip();
    if (from_ == text_.size() || (text_[from_] != '0' && text_[from_] != '1')) fail("a flag, 0 or 1");
    return text_[from_++] == '1';
}

char Numbers::letter() {
    skip();
    return from_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[from_])) != 0 ? text_[from_++] : '\0';
}

std::string_view Numbers::until(char end) {
    skip();
    const std::size_t found = text_.find(end, from_);
    if (found == std::string_view::npos) fail(fmt::format("\"{}\" behind it", end));
    const std::string_view part = text_.substr(from_, found - from_);
    from_ = found + 1;
    return part;
}

void draw_path(Pen& pen, std::string_view data, const std::string& place) {
    Numbers numbers(data, place);
    char command = '\0', before = '\0';
    Point handle{};  // the last control point of the curve before
    while (!numbers.at_end()) {
        if (const char given = numbers.letter())
            command = given;
        else if (command == '\0' || command == 'Z' || command == 'z')
            numbers.fail(command == '\0' ? "M or m" : "a command such as M");
        const char kind = static_cast<char>(std::toupper(static_cast<unsigned char>(command)));
        if (before == '\0' && kind != 'M')
            throw bad_input(place, fmt::format("it begins with {}, expected M or m; draw it again", kind));
        const Point from = kind == command ? Point{} : pen.at();
        const auto point = [&] { return from + numbers.point(); };
        switch (kind) {
            case 'M':
                pen.move(point());
                command = command == 'M' ? 'L' : 'l';  // for further pairs
                break;
            case 'L': pen.line(point()); break;
            case 'H': pen.line({from.real() + numbers.number(), pen.at().imag()}); break;
            case 'V': pen.line({pen.at().real(), from.imag() + numbers.number()}); break;
            case 'C':
            case 'S': {
                const Point mirrored = before == 'C' || before == 'S' ? 2.0 * pen.at() - handle : pen.at();
                const Point first = kind == 'C' ? point() : mirrored;
                handle = point();
                pen.cubic(first, handle, point());
                break;
            }
            case 'Q':
            case 'T': {
                const Point mirrored = before == 'Q' || before == 'T' ? 2.0 * pen.at() - handle : pen.at();
                handle = kind == 'Q' ? point() : mirrored;
                const Point to = point();
                pen.cubic(pen.at() + 2.0 / 3.0 * (handle - pen.at()), to + 2.0 / 3.0 * (handle - to), to);
                break;
            }
            case 'A': {
                const double rx = numbers.number(), ry = numbers.number(), turn = numbers.number();
                const bool large = numbers.flag(), sweep = numbers.flag();
                pen.arc(rx, ry, turn, large, sweep, point());
                break;
            }
            case 'Z': pen.close(); break;
            default:
                throw bad_input(
                    place, fmt::format("found the command \"{}\", expected one of M L H V C S Q T A Z; draw it again",
                                       command));
        }
        before = kind;
    }
}

}  // namespace haptogram::formats
