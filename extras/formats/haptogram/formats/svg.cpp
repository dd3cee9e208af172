// SPDX-License-Identifier: Apache-2.0
// SVG 2: outlines of paths and basic shapes, with transforms, units and what elements inherit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "haptogram/formats/parts.hpp"
#include "haptogram/formats/svg_path.hpp"
#include "haptogram/formats/xml.hpp"

namespace haptogram::formats {
namespace {

constexpr double px_mm = 25.4 / 96.0;

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
    return first == std::string_view::npos ? std::string_view{} : text.substr(first, last - first + 1);
}

/// What a node's style says of a property, or else its attribute.
std::string_view property(const pugi::xml_node& node, std::string_view name) {
    std::string_view style = node.attribute("style").value();
    std::string_view found = node.attribute(std::string(name).c_str()).value();
    while (!style.empty()) {
        const std::string_view part = style.substr(0, style.find(';'));
        style.remove_prefix(std::min(style.size(), part.size() + 1));
        if (const std::size_t colon = part.find(':');
            colon != std::string_view::npos && trimmed(part.substr(0, colon)) == name)
            found = part.substr(colon + 1);
    }
    return trimmed(found.substr(0, found.find('!')));
}

/// What elements take over from those around them.
struct Look {
    bool filled = true, stroked = false, visible = true;
};

Look look_of(const pugi::xml_node& node, Look look) {
    const auto take = [&node](std::string_view name, bool& is, auto means) {
        if (const std::string_view value = property(node, name); !value.empty() && value != "inherit")
            is = means(value);
    };
    const auto painted = [](std::string_view value) { return value != "none" && value != "transparent"; };
    take("fill", look.filled, painted);
    take("stroke", look.stroked, painted);
    take("visibility", look.visible, [](std::string_view value) { return value == "visible"; });
    return look;
}

class SvgReader {
public:
    explicit SvgReader(const ShapeFile& file) : file_(file) { parse_xml(document_, file.content, file.name); }

    Polygons read() {
        const pugi::xml_node top = document_.document_element();
        if (local(top.name()) != "svg")
            throw bad_input(file_.name, fmt::format("found <{}>, expected <svg>; export the drawing as SVG",
                                                    printable(std::string_view(top.name()).substr(0, 40))));
        find_names(top);
        shape_.own_unit_m = millimetre;
        add(top, {{px_mm, 0.0}, {0.0, -px_mm}, {}}, {}, 0);
        if (shape_.curves.empty())
            throw bad_input(file_.name,
                            fmt::format("found no visible outline{}, expected a path or a shape; convert text and "
                                        "pictures to paths",
                                        words_ > 0 ? " but text or pictures" : ""));
        const auto remark = [&](std::size_t count, std::string_view what) {
            if (count > 0) shape_.remarks.push_back(fmt::format("{} {}", count, what));
        };
        remark(words_, "texts or pictures are left out; convert them to paths");
        remark(unseen_, "outlines with neither fill nor stroke are left out");
        remark(clipped_, "elements are drawn whole, though the drawing clips or masks them");
        if (!in_mm_)
            shape_.remarks.emplace_back(
                "its width and height have no unit such as mm, and a px is 1/96 inch; say how "
                "large it shall be with --size");
        return std::move(shape_);
    }

private:
    void find_names(const pugi::xml_node& top) {
        struct Walker : pugi::xml_tree_walker {
            std::map<std::string, pugi::xml_node>* names = nullptr;
            bool moves = false;
            bool for_each(pugi::xml_node& node) override {
                if (const pugi::xml_attribute id = node.attribute("id")) names->emplace(id.value(), node);
                if (local(node.name()) == "style")
                    for (const char* const word : {"display:none", "transform:", "visibility:"}) {
                        std::string text = node.text().get();
                        std::erase_if(text, [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; });
                        moves = moves || text.find(word) != std::string::npos;
                    }
                return true;
            }
        } walker;
        walker.names = &names_;
        pugi::xml_node(top).traverse(walker);
        if (walker.moves)
            throw bad_input(file_.name,
                            "its style sheet hides or moves elements, expected attributes of theirs; export it as "
                            "plain SVG");
    }

    [[nodiscard]] std::string place(const pugi::xml_node& node) const {
        const std::string id = node.attribute("id").value();
        return fmt::format("{}, <{}{}> at byte {}", file_.name, printable(std::string_view(node.name()).substr(0, 40)),
                           id.empty() ? "" : fmt::format(" id={}", shown(id)), node.offset_debug());
    }

    /// A length in px; nothing when there is none, or a share of what is around it.
    std::optional<double> length(const pugi::xml_node& node, const char* name) {
        const std::string_view text = trimmed(node.attribute(name).value());
        if (text.empty() || text == "auto" || text.ends_with('%')) return {};
        static const std::map<std::string_view, double> units = {
            {"", 1.0},    {"px", 1.0},         {"mm", 96.0 / 25.4}, {"cm", 960.0 / 25.4},
            {"in", 96.0}, {"pt", 96.0 / 72.0}, {"pc", 16.0},        {"Q", 24.0 / 25.4}};
        const std::size_t end = text.find_last_of("0123456789.") + 1;
        const auto unit = units.find(trimmed(text.substr(end)));
        Numbers numbers(text.substr(0, end), fmt::format("{}, {}", place(node), name));
        if (unit == units.end())
            throw bad_input(place(node), fmt::format("found {} {}, expected a number in px, mm, cm, in, pt or pc", name,
                                                     shown(text)));
        const double value = numbers.number();
        if (!numbers.at_end()) numbers.fail("one number");
        in_physical_ = unit->second != 1.0;
        return value * unit->second;
    }
    double length_or(const pugi::xml_node& node, const char* name, double otherwise) {
        if (std::string_view(node.attribute(name).value()).ends_with('%'))
            throw bad_input(place(node), fmt::format("found {} {}, expected a length; export it as plain SVG", name,
                                                     shown(node.attribute(name).value())));
        return length(node, name).value_or(otherwise);
    }

    /// Of the attribute `transform`.
    [[nodiscard]] Affine transform_of(const pugi::xml_node& node) const {
        Affine whole;
        if (property(node, "transform") != trimmed(node.attribute("transform").value()))
            throw bad_input(place(node),
                            "found a transform in its style, expected the attribute; export it as plain SVG");
        Numbers text(node.attribute("transform").value(), place(node) + ", transform");
        while (!text.at_end()) {
            const std::string_view name = trimmed(text.until('('));
            Numbers inside(text.until(')'), place(node) + ", transform");
            std::vector<double> n;
            while (!inside.at_end() && n.size() < 7) n.push_back(inside.number());
            const auto is = [&](std::string_view kind, std::size_t least, std::size_t most) {
                return name == kind && (n.size() == least || n.size() == most);
            };
            if (is("matrix", 6, 6)) {
                whole = whole.of({{n[0], n[1]}, {n[2], n[3]}, {n[4], n[5]}});
            } else if (is("translate", 1, 2)) {
                whole = whole.of({.origin = {n[0], n.size() > 1 ? n[1] : 0.0}});
            } else if (is("scale", 1, 2)) {
                whole = whole.of({.x = {n[0], 0.0}, .y = {0.0, n.back()}});
            } else if (is("rotate", 1, 3)) {
                const Point turn = std::polar(1.0, n[0] * std::numbers::pi / 180.0);
                const Point about = n.size() > 1 ? Point{n[1], n[2]} : Point{};
                whole = whole.of({turn, turn * Point{0.0, 1.0}, about - turn * about});
            } else if (is("skewX", 1, 1)) {
                whole = whole.of({.y = {std::tan(n[0] * std::numbers::pi / 180.0), 1.0}});
            } else if (is("skewY", 1, 1)) {
                whole = whole.of({.x = {1.0, std::tan(n[0] * std::numbers::pi / 180.0)}});
            } else {
                throw bad_input(place(node),
                                fmt::format("found the transform {} of {} numbers, expected matrix, translate, "
                                            "scale, rotate, skewX or skewY with theirs; draw it again",
                                            shown(name), n.size()));
            }
        }
        return whole;
    }

    /// From a drawing's own numbers to those of what is around it (SVG 2, 8.2).
    Affine viewport(const pugi::xml_node& node, std::optional<double> width, std::optional<double> height) {
        const Point corner{length_or(node, "x", 0.0), length_or(node, "y", 0.0)};
        const pugi::xml_attribute box = node.attribute("viewBox");
        if (!box) return {.origin = corner};
        Numbers numbers(box.value(), place(node) + ", viewBox");
        const Point from = numbers.point(), size = numbers.point();
        if (!(size.real() > 0.0 && size.imag() > 0.0) || !numbers.at_end())
            numbers.fail("four numbers, the last two above 0");
        if (!width) width = height ? *height * size.real() / size.imag() : size.real();
        if (!height) height = *width * size.imag() / size.real();
        Point scale{*width / size.real(), *height / size.imag()};
        const std::string_view fit = node.attribute("preserveAspectRatio").value();
        Point free{};
        if (!fit.starts_with("none")) {
            const double one =
                fit.ends_with("slice") ? std::max(scale.real(), scale.imag()) : std::min(scale.real(), scale.imag());
            scale = {one, one};
            const auto share = [&](std::string_view min, std::string_view max) {
                return fit.find(min) != std::string_view::npos   ? 0.0
                       : fit.find(max) != std::string_view::npos ? 1.0
                                                                 : 0.5;
            };
            free = {(*width - one * size.real()) * share("xMin", "xMax"),
                    (*height - one * size.imag()) * share("YMin", "YMax")};
        }
        return {{scale.real(), 0.0},
                {0.0, scale.imag()},
                corner + free - Point{scale.real() * from.real(), scale.imag() * from.imag()}};
    }

    void add_children(const pugi::xml_node& node, const Affine& to_mm, Look look, std::size_t depth) {
        for (const pugi::xml_node& child : node) add(child, to_mm, look, depth + 1);
    }

    void add(const pugi::xml_node& node, const Affine& around, Look look, std::size_t depth) {
        if (depth > most_deep || ++visited_ > most_visited)
            throw bad_input(file_.name,
                            fmt::format("its elements use each other more than {} deep, or {} times; export it as "
                                        "plain SVG",
                                        most_deep, most_visited));
        const std::string_view name = local(node.name());
        if (property(node, "display") == "none") return;
        const bool is_group = name == "svg" || name == "g" || name == "a" || name == "switch" || name == "use";
        const bool is_shape = name == "path" || name == "rect" || name == "circle" || name == "ellipse" ||
                              name == "line" || name == "polyline" || name == "polygon";
        if (name == "text" || name == "image" || name == "foreignObject") ++words_;
        if (!is_group && !is_shape) return;  // definitions, and what other programs note
        look = look_of(node, look);
        if (!property(node, "clip-path").empty() || !property(node, "mask").empty()) ++clipped_;
        const Affine to_mm = around.of(transform_of(node));
        if (is_shape) {
            draw(node, name, to_mm, look);
        } else if (name == "svg") {
            const auto width = length(node, "width");
            const bool physical = width && in_physical_;
            const auto height = length(node, "height");
            if (depth == 0) in_mm_ = physical || (height && in_physical_);
            add_children(node, to_mm.of(viewport(node, width, height)), look, depth);
        } else if (name == "use") {
            use(node, to_mm, look, depth);
        } else {
            add_children(node, to_mm, look, depth);
        }
    }

    void use(const pugi::xml_node& node, const Affine& to_mm, Look look, std::size_t depth) {
        const pugi::xml_attribute plain = node.attribute("href");
        const std::string_view target = (plain ? plain : node.attribute("xlink:href")).value();
        const auto found = target.starts_with('#') ? names_.find(std::string(target.substr(1))) : names_.end();
        if (found == names_.end())
            throw bad_input(place(node),
                            fmt::format("there is no {} in the drawing; export it as plain SVG", shown(target)));
        const Affine there = to_mm.of({.origin = {length_or(node, "x", 0.0), length_or(node, "y", 0.0)}});
        if (local(found->second.name()) != "symbol") return add(found->second, there, look, depth + 1);
        const auto width = length(node, "width"), height = length(node, "height");
        if (found->second.attribute("viewBox") && !(width && height))
            throw bad_input(place(node),
                            "it uses a symbol with a viewBox, expected a width and a height; export it as plain SVG");
        add_children(found->second, there.of(viewport(found->second, width, height)), look_of(found->second, look),
                     depth + 1);
    }

    void draw(const pugi::xml_node& node, std::string_view name, const Affine& to_mm, Look look) {
        Pen pen(to_mm);
        const auto of = [&](const char* attribute) { return length_or(node, attribute, 0.0); };
        const auto ellipse = [&](double rx, double ry) {
            if (rx < 0.0 || ry < 0.0) throw bad_input(place(node), "found a radius below 0; draw it again");
            if (rx == 0.0 || ry == 0.0) return;
            const Point centre{of("cx"), of("cy")};
            pen.move(centre + rx);
            pen.arc(rx, ry, 0.0, false, true, centre - rx);
            pen.arc(rx, ry, 0.0, false, true, centre + rx);
            pen.close();
        };
        if (name == "path") {
            draw_path(pen, node.attribute("d").value(), place(node));
        } else if (name == "circle") {
            ellipse(of("r"), of("r"));
        } else if (name == "ellipse") {
            const auto rx = length(node, "rx"), ry = length(node, "ry");
            ellipse(rx.value_or(ry.value_or(0.0)), ry.value_or(rx.value_or(0.0)));
        } else if (name == "rect") {
            const double w = of("width"), h = of("height");
            if (w < 0.0 || h < 0.0) throw bad_input(place(node), "found a side below 0; draw it again");
            const auto given_x = length(node, "rx"), given_y = length(node, "ry");
            const double rx = std::clamp(given_x.value_or(given_y.value_or(0.0)), 0.0, 0.5 * w);
            const double ry = std::clamp(given_y.value_or(given_x.value_or(0.0)), 0.0, 0.5 * h);
            const Point p{of("x"), of("y")};
            if (w > 0.0 && h > 0.0) {
                pen.move(p + rx);
                const Point ends[] = {{w - rx, 0.0}, {w, ry},       {w, h - ry}, {w - rx, h},
                                      {rx, h},       {0.0, h - ry}, {0.0, ry},   {rx, 0.0}};
                for (std::size_t i = 0; i < 8; i += 2) {
                    pen.line(p + ends[i]);
                    pen.arc(rx, ry, 0.0, false, true, p + ends[i + 1]);
                }
                pen.close();
            }
        } else if (name == "line") {
            pen.move({of("x1"), of("y1")});
            pen.line({of("x2"), of("y2")});
        } else {
            Numbers numbers(node.attribute("points").value(), place(node) + ", points");
            for (bool first = true; !numbers.at_end(); first = false)
                first ? pen.move(numbers.point()) : pen.line(numbers.point());
            if (name == "polygon") pen.close();
        }
        if (!look.visible || (!look.filled && !look.stroked)) {
            ++unseen_;
            return;
        }
        for (Stroke& stroke : pen.strokes()) keep(stroke, node);
    }

    void keep(Stroke& stroke, const pugi::xml_node& node) {
        stroke.erase(std::unique(stroke.begin(), stroke.end()), stroke.end());
        if (stroke.size() < 2) return;  // a dot, which has no outline
        require_small(shape_, stroke.size(), file_.name);
        const bool closed = stroke.front() == stroke.back();
        if (closed) stroke.pop_back();
        std::vector<std::uint32_t>& curve = shape_.curves.emplace_back();
        for (const Point& p : stroke) {
            for (const double each : {p.real(), p.imag()})
                if (!is_coordinate(each)) throw bad_coordinate(place(node), fmt::format("{} mm", each));
            curve.push_back(static_cast<std::uint32_t>(shape_.vertices.size()));
            shape_.vertices.push_back({p.real(), p.imag(), 0.0});
        }
        if (closed) curve.push_back(curve.front());
    }

    static constexpr std::size_t most_deep = 128, most_visited = 1'000'000;

    const ShapeFile& file_;
    pugi::xml_document document_;
    std::map<std::string, pugi::xml_node> names_;
    std::size_t visited_ = 0, words_ = 0, unseen_ = 0, clipped_ = 0;
    bool in_mm_ = false, in_physical_ = false;
    Polygons shape_;
};

}  // namespace

Polygons read_svg(const ShapeFile& file) { return SvgReader(file).read(); }

}  // namespace haptogram::formats
