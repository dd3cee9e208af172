// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram::formats {

/// A place in a drawing.
using Point = std::complex<double>;

struct Affine {
    Point x{1.0, 0.0}, y{0.0, 1.0}, origin{};

    Point operator()(Point p) const { return origin + p.real() * x + p.imag() * y; }
    [[nodiscard]] Affine of(const Affine& inner) const {
        const Point start = (*this)(inner.origin);
        return {(*this)(inner.origin + inner.x) - start, (*this)(inner.origin + inner.y) - start, start};
    }
};

/// A stretch of an outline without a break, as straight pieces; closed when the last point is the first.
using Stroke = std::vector<Point>;

/// Draws outlines of straight lines, Bézier curves and arcs, and keeps them moved by a transform to mm. A curve becomes
/// pieces that are within 1 µm of it up to a size of 100 mm, and within 1e-5 of its size beyond.
class Pen {
public:
    explicit Pen(const Affine& to_mm) : to_mm_(to_mm) {}

    void move(Point to);
    void line(Point to);
    void cubic(Point first, Point second, Point to);
    /// An arc of an ellipse as SVG has it (SVG 2, appendix B.2). @param turn_deg  of the ellipse's axes
    void arc(double rx, double ry, double turn_deg, bool large, bool sweep, Point to);
    void close();

    [[nodiscard]] Point at() const { return at_; }
    [[nodiscard]] std::vector<Stroke>& strokes() { return strokes_; }

private:
    void add(Point p);

    Affine to_mm_;
    Point at_{}, start_{};
    bool drawing_ = false;
    std::vector<Stroke> strokes_;
};

/// A walk over numbers as SVG writes them: with commas or blanks between them, or nothing.
class Numbers {
public:
    /// @param place  for messages
    Numbers(std::string_view text, std::string place) : text_(text), place_(std::move(place)) {}

    [[nodiscard]] bool at_end();
    /// @throws Error{bad_input} unless a finite number of at most 1e9 follows
    double number();
    /// A digit 0 or 1, which another may follow at once.
    bool flag();
    Point point() {
        const double x = number();
        return {x, number()};
    }
    /// The next character, when it is a letter.
    char letter();
    /// What stands until a character, which is taken, too.
    std::string_view until(char end);
    /// What follows is not what is expected. @throws Error{bad_input}
    [[noreturn]] void fail(std::string_view expected);

private:
    void skip();

    std::string_view text_;
    std::size_t from_ = 0;
    std::string place_;
};

/// Draws the data of a <path>.
void draw_path(Pen& pen, std::string_view data, const std::string& place);

}  // namespace haptogram::formats
