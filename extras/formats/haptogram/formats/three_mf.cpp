// SPDX-License-Identifier: Apache-2.0
// 3MF Core Specification 1.3, and of the Production Extension 1.1 the parts in further files.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "haptogram/base/bundle.hpp"
#include "haptogram/formats/parts.hpp"
#include "haptogram/formats/xml.hpp"

namespace haptogram::formats {
namespace {

/// One of the XML files within.
struct Model {
    pugi::xml_document document;
    std::map<std::string, pugi::xml_node> objects;  ///< by id
    std::string unit;
};

pugi::xml_node child(const pugi::xml_node& node, std::string_view name) {
    return node.find_child([name](const pugi::xml_node& each) { return local(each.name()) == name; });
}

class ThreeMfReader {
public:
    ThreeMfReader(const Parts& part, const std::string& name) : part_(part), name_(name) {}

    Polygons read() {
        const std::string start = start_part();
        const Model& model = opened(start);
        shape_.own_unit_m = metres(model.unit, start);
        const pugi::xml_node build = child(root(model), "build");
        for (const pugi::xml_node& item : build)
            if (local(item.name()) == "item") add(item, start, Motion{}, 0, "a build item");
        if (shape_.vertices.empty())
            throw bad_input(name_, "found no build item with a mesh; export the model from a slicer or modeller again");
        return std::move(shape_);
    }

private:
    [[nodiscard]] std::string in(const std::string& part) const { return name_ + "/" + part; }

    [[nodiscard]] std::string contents(const std::string& part) const {
        if (auto found = part_(part)) return *std::move(found);
        throw bad_input(name_, fmt::format("there is no {} in it; expected a 3MF file, export it again", shown(part)));
    }

    /// The model where reading begins.
    [[nodiscard]] std::string start_part() const {
        const std::optional<std::string> named = part_("_rels/.rels");
        if (!named) return "3D/3dmodel.model";  // where all programs put it
        pugi::xml_document relations;
        parse_xml(relations, *named, in("_rels/.rels"));
        for (const pugi::xml_node& each : relations.first_child())
            if (std::string_view(each.attribute("Type").value()).ends_with("/3dmodel"))
                return without_slash(each.attribute("Target").value());
        throw bad_input(in("_rels/.rels"), "it names no 3-D model; export the file again");
    }

    static std::string without_slash(std::string_view part) {
        return std::string(part.substr(part.starts_with('/') ? 1 : 0));
    }

    static pugi::xml_node root(const Model& model) { return model.document.document_element(); }

    const Model& opened(const std::string& part) {
        std::unique_ptr<Model>& model = models_[part];
        if (model) return *model;
        model = std::make_unique<Model>();
        const std::string text = contents(part);
        if ((bytes_ += text.size()) > most_bytes)
            throw bad_input(name_, fmt::format("its models have more than {} bytes; simplify the shape", most_bytes));
        parse_xml(model->document, text, in(part));
        const pugi::xml_node top = root(*model);
        if (local(top.name()) != "model")
            throw bad_input(in(part), fmt::format("found <{}>, expected <model>; export the file again",
                                                  printable(std::string_view(top.name()).substr(0, 40))));
        model->unit = top.attribute("unit").as_string("millimeter");
        require_known(top, part);
        for (const pugi::xml_node& object : child(top, "resources"))
            if (local(object.name()) == "object") model->objects[object.attribute("id").value()] = object;
        return *model;
    }

    void require_known(const pugi::xml_node& top, const std::string& part) const {
        std::string_view rest = top.attribute("requiredextensions").value();
        for (std::string_view prefix = take_word(rest); !prefix.empty(); prefix = take_word(rest)) {
            const std::string meaning = top.attribute(fmt::format("xmlns:{}", prefix).c_str()).value();
            if (meaning.find("/production/") == std::string::npos && meaning.find("/material/") == std::string::npos)
                throw bad_input(in(part),
                                fmt::format("it needs the extension {}, which is not read; export the shape as "
                                            "a mesh alone",
                                            shown(meaning.empty() ? prefix : meaning)));
        }
    }

    [[nodiscard]] double metres(const std::string& unit, const std::string& part) const {
        static const std::map<std::string, double> units = {{"micron", 1e-6},     {"millimeter", millimetre},
                                                            {"centimeter", 1e-2}, {"inch", 25.4e-3},
                                                            {"foot", 304.8e-3},   {"meter", 1.0}};
        if (const auto found = units.find(unit); found != units.end()) return found->second;
        throw bad_input(in(part),
                        fmt::format("found the unit {}, expected micron, millimeter, centimeter, inch, foot or "
                                    "meter; export the file again",
                                    shown(unit)));
    }

    [[nodiscard]] Motion transform_of(const pugi::xml_node& node, const std::string& place) const {
        const std::string_view text = node.attribute("transform").value();
        if (text.empty()) return Motion{};
        std::array<double, 12> m{};
        std::string_view rest = text;
        for (double& each : m) each = number(take_word(rest), place);
        if (!take_word(rest).empty())
            throw bad_input(
                place, fmt::format("found the transform {}, expected 12 numbers; export the file again", shown(text)));
        return {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}, {m[9], m[10], m[11]}};
    }

    static double number(std::string_view word, const std::string& place) {
        const auto value = parse_number(word);
        if (!value || !is_coordinate(*value)) throw bad_coordinate(place, word);
        return *value;
    }

    /// The object that an item or a component names, at its place.
    void add(const pugi::xml_node& user, const std::string& part, const Motion& above, std::size_t depth,
             const std::string& what) {
        if (depth > most_deep || ++uses_ > most_uses)
            throw bad_input(in(part),
                            fmt::format("its objects name each other more than {} deep, or {} times; export the "
                                        "file again",
                                        most_deep, most_uses));
        const pugi::xml_attribute path =
            user.find_attribute([](const pugi::xml_attribute& each) { return local(each.name()) == "path"; });
        const std::string where = path ? without_slash(path.value()) : part;
        const Model& model = opened(where);
        if (model.unit != opened(part).unit)
            throw bad_input(in(where),
                            fmt::format("found the unit {} beside {}, expected one for all; export the file again",
                                        shown(model.unit), shown(opened(part).unit)));
        const std::string id = user.attribute("objectid").value();
        const auto found = model.objects.find(id);
        if (found == model.objects.end())
            throw bad_input(in(where), fmt::format("there is no object {}, which {} names; export the file again",
                                                   shown(id), what));
        const std::string place = fmt::format("{}, object {}", in(where), printable(id));
        const Motion transform = above.of(transform_of(user, place));
        if (const pugi::xml_node mesh = child(found->second, "mesh")) add_mesh(mesh, transform, place);
        for (const pugi::xml_node& component : child(found->second, "components"))
            if (local(component.name()) == "component")
                add(component, where, transform, depth + 1, fmt::format("object {}", printable(id)));
    }

    void add_mesh(const pugi::xml_node& mesh, const Motion& transform, const std::string& place) {
        const std::size_t first = shape_.vertices.size();
        for (const pugi::xml_node& vertex : child(mesh, "vertices")) {
            require_small(shape_, 1, name_);
            const auto coordinate = [&](const char* axis) { return number(vertex.attribute(axis).value(), place); };
            shape_.vertices.push_back(transform.moved({coordinate("x"), coordinate("y"), coordinate("z")}, place));
        }
        const std::size_t count = shape_.vertices.size() - first;
        for (const pugi::xml_node& triangle : child(mesh, "triangles")) {
            if (local(triangle.name()) != "triangle") continue;
            require_small(shape_, 3, name_);
            const auto corner = [&](const char* name) {
                const std::string_view word = triangle.attribute(name).value();
                const double value = parse_number(word).value_or(-1.0);
                if (!(value >= 0.0 && value < static_cast<double>(count)) || value != std::floor(value))
                    throw bad_input(place,
                                    fmt::format("found the corner {} of a triangle, expected one of the {} vertices, "
                                                "from 0; export the file again",
                                                shown(word), count));
                return static_cast<std::uint32_t>(first + static_cast<std::size_t>(value));
            };
            const std::uint32_t a = corner("v1"), b = corner("v2"), c = corner("v3");
            shape_.add_triangle(a, transform.mirrors() ? c : b, transform.mirrors() ? b : c);
        }
    }

    static constexpr std::size_t most_deep = 64, most_uses = 100'000, most_bytes = 48UL * 1024 * 1024;

    const Parts& part_;
    const std::string& name_;
    std::map<std::string, std::unique_ptr<Model>> models_;
    std::size_t uses_ = 0, bytes_ = 0;
    Polygons shape_;
};

}  // namespace

Polygons read_three_mf_parts(const Parts& part, const std::string& name) { return ThreeMfReader(part, name).read(); }

Polygons read_three_mf(const ShapeFile& file) {
    return read_three_mf_parts([&file](const std::string& part) { return read_zipped(file.content, part, file.name); },
                               file.name);
}

}  // namespace haptogram::formats
