// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 (Khronos, ISO/IEC 12113:2022).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/formats/parts.hpp"

namespace haptogram::formats {
namespace {

/// How numbers of one componentType lie in a buffer.
struct Component {
    std::size_t bytes;
    double most;  ///< what stands for 1 when the numbers are normalized
    double (*at)(const char* bytes);
};

template <class Number>
constexpr Component component() {
    return {sizeof(Number), std::is_integral_v<Number> ? static_cast<double>(std::numeric_limits<Number>::max()) : 1.0,
            number_at<Number>};
}

std::optional<std::string> decoded(std::string_view base64) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    while (base64.ends_with('=')) base64.remove_suffix(1);
    std::string bytes;
    std::uint32_t held = 0;
    unsigned bits = 0;
    for (const char c : base64) {
        const std::size_t digit = digits.find(c);
        if (digit == std::string_view::npos) return {};
        held = held << 6U | static_cast<std::uint32_t>(digit);
        if ((bits += 6) < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<char>(held >> bits & 0xFFU));
    }
    return bytes;
}

/// The numbers of an accessor, `width` to an element.
struct Accessor {
    std::size_t count, width, stride;
    std::string_view bytes;
    Component component;
    bool normalized;

    [[nodiscard]] double at(std::size_t element, std::size_t which) const {
        const double value = component.at(&bytes[element * stride + which * component.bytes]);
        return normalized ? std::max(value / component.most, -1.0) : value;
    }
};

class GltfReader {
public:
    explicit GltfReader(const ShapeFile& file) : file_(file) {
        std::string_view text = file.content;
        if (text.starts_with("glTF")) text = chunks();
        json_ = parse_json(text, file.name);
        polygons_.own_unit_m = 1.0;
    }

    Polygons read() {
        const JsonMember root(json_, file_.name);
        if (const auto asset = root.at("asset"); !asset.at("version").text().starts_with("2."))
            throw asset.at("version").wrong("2.0, the glTF that is read; export it again as glTF 2.0");
        for (const char* const key : {"extensionsRequired", "extensionsUsed"})
            if (const auto names = root.find(key))
                for (const JsonMember& name : names->list()) require_readable(name, key);
        if (const auto buffers = root.find("buffers"))
            for (const JsonMember& each : buffers->list()) buffers_.push_back(buffer(each));
        nodes_ = list_of(root, "nodes");
        seen_.resize(nodes_.size());
        meshes_ = list_of(root, "meshes");
        accessors_ = list_of(root, "accessors");
        views_ = list_of(root, "bufferViews");
        if (const std::vector<JsonMember> scenes = list_of(root, "scenes"); !scenes.empty()) {
            const auto chosen = root.find("scene");
            const JsonMember& scene = scenes[chosen ? index(*chosen, scenes.size()) : 0];
            if (const auto roots = scene.find("nodes"))
                for (const JsonMember& node : roots->list()) add_node(index(node, nodes_.size()), {}, 0);
        } else {
            std::vector<bool> below(nodes_.size());
            for (const JsonMember& node : nodes_)
                if (const auto children = node.find("children"))
                    for (const JsonMember& child : children->list()) below[index(child, nodes_.size())] = true;
            for (std::size_t i = 0; i < nodes_.size(); ++i)
                if (!below[i]) add_node(i, {}, 0);
        }
        if (skinned_)
            polygons_.remarks.emplace_back("figures with a skeleton stand as they were modelled, without their pose");
        if (polygons_.vertices.empty())
            throw bad_input(file_.name, "its scene has no mesh with points; export the shape with its geometry");
        return std::move(polygons_);
    }

private:
    /// Of a GLB file: keeps the second chunk as a buffer. @return the first, which is JSON
    std::string_view chunks() {
        const std::string_view whole = file_.content;
        const auto word = [&](std::size_t at) {
            if (at + 4 > whole.size())
                throw bad_input(file_.name,
                                fmt::format("it ends at byte {}, expected more; the file is cut short", whole.size()));
            return static_cast<std::size_t>(number_at<std::uint32_t>(&whole[at]));
        };
        if (word(4) != 2)
            throw bad_input(file_.name, fmt::format("found version {} of GLB, expected 2; export it again", word(4)));
        if (word(8) != whole.size())
            throw bad_input(file_.name, fmt::format("it has {} bytes and says {}; the file is cut short or damaged",
                                                    whole.size(), word(8)));
        constexpr std::size_t json = 0x4E4F534A, binary = 0x004E4942, header = 12, of_chunk = 8;
        const auto chunk = [&](std::size_t at, std::size_t kind) {
            const std::size_t size = word(at);
            if (word(at + 4) != kind || size > whole.size() - at - of_chunk)
                throw bad_input(file_.name, fmt::format("the chunk at byte {} is damaged; export the file again", at));
            return whole.substr(at + of_chunk, size);
        };
        const std::string_view text = chunk(header, json);
        if (const std::size_t next = header + of_chunk + text.size(); next < whole.size()) chunk_ = chunk(next, binary);
        return text;
    }

    void require_readable(const JsonMember& extension, std::string_view key) const {
        const std::string name = extension.text();
        const bool changes_places = name == "EXT_mesh_gpu_instancing";
        const bool harmless = name.starts_with("KHR_materials") || name.starts_with("KHR_texture") ||
                              name.starts_with("KHR_lights") || name == "KHR_mesh_quantization";
        if (changes_places || (key == "extensionsRequired" && !harmless))
            throw bad_input(file_.name, fmt::format("it needs {}, which is not read; export it without compression and "
                                                    "instances",
                                                    shown(name)));
    }

    static std::vector<JsonMember> list_of(const JsonMember& root, const char* key) {
        const auto found = root.find(key);
        return found ? found->list() : std::vector<JsonMember>{};
    }

    static std::size_t index(const JsonMember& member, std::size_t count) {
        const double value = member.number(0.0, 4294967295.0);
        if (value != std::floor(value) || value >= static_cast<double>(count))
            throw member.wrong(count == 0 ? "left out, as the file has none of these; export it with its geometry"
                                          : fmt::format("the number of one of {}, from 0", count));
        return static_cast<std::size_t>(value);
    }
    static std::size_t whole(const JsonMember& of, const char* key, std::size_t otherwise) {
        const auto found = of.find(key);
        return found ? index(*found, std::numeric_limits<std::uint32_t>::max()) : otherwise;
    }

    std::string buffer(const JsonMember& member) {
        const std::size_t size = whole(member, "byteLength", 0);
        std::string bytes;
        if (const auto uri = member.find("uri")) {
            const std::string text = uri->text();
            if (text.starts_with("data:")) {
                const std::size_t comma = text.find(',');
                const bool is_base64 = comma != std::string::npos && text.substr(0, comma).ends_with(";base64");
                auto made = is_base64 ? decoded(std::string_view(text).substr(comma + 1)) : std::nullopt;
                if (!made) throw uri->wrong("data in base64, or the name of a file");
                bytes = *std::move(made);
            } else {
                bytes = beside(*uri, text);
                polygons_.beside += bytes;
            }
        } else {
            bytes = chunk_;
        }
        if (bytes.size() < size)
            throw bad_input(file_.name,
                            fmt::format("buffers[{}] has {} bytes, expected {}; keep the file and its buffers "
                                        "together, or export it as .glb",
                                        buffers_.size(), bytes.size(), size));
        return bytes;
    }

    std::string beside(const JsonMember& uri, const std::string& text) const {
        std::string name;
        for (std::size_t i = 0; i < text.size(); ++i) {
            const bool escaped = text[i] == '%' && i + 2 < text.size() &&
                                 std::isxdigit(static_cast<unsigned char>(text[i + 1])) != 0 &&
                                 std::isxdigit(static_cast<unsigned char>(text[i + 2])) != 0;
            name.push_back(escaped ? static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16)) : text[i]);
            if (escaped) i += 2;
        }
        const std::filesystem::path path = name;
        const bool inside = !path.is_absolute() && std::ranges::find(path, "..") == path.end() &&
                            name.find(':') == std::string::npos && name.find('\0') == std::string::npos;
        if (!inside) throw uri.wrong("the name of a file in its own folder");
        if (!file_.on_disk)
            throw uri.wrong("data within the file, as it comes without the files beside it; export it as .glb");
        try {
            return read_file(named_in(std::filesystem::path(file_.name).parent_path(), path));
        } catch (const Error& error) {
            throw bad_input(file_.name,
                            fmt::format("its buffer is the file {}, which {}; keep both together, or export it as .glb",
                                        shown(name), error.message().substr(0, error.message().find(';'))));
        }
    }

    [[nodiscard]] Error outside(std::string_view list, std::size_t number, std::size_t bytes) const {
        return bad_input(file_.name, fmt::format("{}[{}] lies outside of the {} bytes that it is a part of; export the "
                                                 "file again",
                                                 list, number, bytes));
    }

    [[nodiscard]] Accessor accessor(const JsonMember& number, std::string_view type) const {
        static const std::map<std::size_t, Component> components = {
            {5120, component<std::int8_t>()},   {5121, component<std::uint8_t>()},  {5122, component<std::int16_t>()},
            {5123, component<std::uint16_t>()}, {5125, component<std::uint32_t>()}, {5126, component<float>()}};
        const JsonMember& of = accessors_[index(number, accessors_.size())];
        if (const auto sparse = of.find("sparse"))
            throw sparse->wrong("left out; export the shape without sparse data");
        if (of.at("type").text() != type) throw of.at("type").wrong(type);
        const auto found = components.find(whole(of, "componentType", 0));
        if (found == components.end()) throw of.at("componentType").wrong("5120 to 5126 without 5124");
        const std::size_t view_number = index(of.at("bufferView"), views_.size());
        const JsonMember& view = views_[view_number];
        const std::string_view buffer = buffers_[index(view.at("buffer"), buffers_.size())];
        const std::size_t begin = whole(view, "byteOffset", 0), size = whole(view, "byteLength", 0);
        if (begin > buffer.size() || size > buffer.size() - begin)
            throw outside("bufferViews", view_number, buffer.size());
        const std::size_t offset = whole(of, "byteOffset", 0), width = type == "VEC3" ? 3 : 1;
        Accessor made{.count = whole(of, "count", 0),
                      .width = width,
                      .stride = whole(view, "byteStride", width * found->second.bytes),
                      .bytes = buffer.substr(begin, size),
                      .component = found->second,
                      .normalized = of.find("normalized") && of.at("normalized").value() == true};
        const std::size_t element = width * found->second.bytes;
        const bool fits = made.count == 0 || (made.stride >= element && offset <= size && size - offset >= element &&
                                              (made.count - 1) <= (size - offset - element) / made.stride);
        if (!fits) throw outside("accessors", index(number, accessors_.size()), size);
        made.bytes.remove_prefix(made.count == 0 ? 0 : offset);
        return made;
    }

    static std::vector<double> numbers(const JsonMember& member, std::size_t count) {
        std::vector<double> values;
        for (const JsonMember& each : member.list()) values.push_back(each.number(-1e12, 1e12));
        if (values.size() != count) throw member.wrong(fmt::format("{} numbers", count));
        return values;
    }

    static Motion motion_of(const JsonMember& node) {
        if (const auto matrix = node.find("matrix")) {
            const std::vector<double> m = numbers(*matrix, 16);
            if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0)
                throw matrix->wrong("a matrix whose last row is 0, 0, 0, 1");
            return {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
        }
        Motion motion;
        if (const auto rotation = node.find("rotation")) {
            const std::vector<double> q = numbers(*rotation, 4);
            const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
            if (!(norm2 > 0.0)) throw rotation->wrong("a quaternion that is not zero");
            const double s = 2.0 / norm2, x = q[0], y = q[1], z = q[2], w = q[3];
            motion.x = {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)};
            motion.y = {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)};
            motion.z = {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)};
        }
        if (const auto scale = node.find("scale")) {
            const std::vector<double> k = numbers(*scale, 3);
            motion.x = k[0] * motion.x;
            motion.y = k[1] * motion.y;
            motion.z = k[2] * motion.z;
        }
        if (const auto translation = node.find("translation")) {
            const std::vector<double> t = numbers(*translation, 3);
            motion.origin = {t[0], t[1], t[2]};
        }
        return motion;
    }

    void add_node(std::size_t number, const Motion& above, std::size_t depth) {
        const JsonMember& node = nodes_[number];
        if (seen_[number])
            throw bad_input(file_.name,
                            fmt::format("nodes[{}] is below two others, expected one; export the file again", number));
        seen_[number] = true;
        if (depth > most_deep)
            throw bad_input(file_.name, fmt::format("its nodes are more than {} deep; ungroup them", most_deep));
        const bool skinned = node.find("skin").has_value();
        skinned_ = skinned_ || skinned;
        const Motion motion = above.of(motion_of(node));
        // By the standard, a skinned mesh does not follow its node.
        if (const auto mesh = node.find("mesh"))
            for (const JsonMember& each : meshes_[index(*mesh, meshes_.size())].at("primitives").list())
                add(each, skinned ? Motion{} : motion);
        if (const auto children = node.find("children"))
            for (const JsonMember& child : children->list()) add_node(index(child, nodes_.size()), motion, depth + 1);
    }

    void add(const JsonMember& primitive, const Motion& motion) {
        const auto position = primitive.at("attributes").find("POSITION");
        if (!position) return;  // by the standard, there is then nothing to show
        const Accessor points = accessor(*position, "VEC3");
        const auto given = primitive.find("indices");
        std::optional<Accessor> indices;
        if (given) indices = accessor(*given, "SCALAR");
        const std::size_t count = indices ? indices->count : points.count;
        const auto number_at = [&](std::size_t i) {
            if (!indices) return i;
            const double number = indices->at(i, 0);
            if (!(number >= 0.0 && number < static_cast<double>(points.count)) || number != std::floor(number))
                throw given->wrong(fmt::format("a list of numbers of its {} points, from 0, and number {} is {}",
                                               points.count, i, number));
            return static_cast<std::size_t>(number);
        };
        require_small(polygons_, 3 * count, file_.name);
        std::vector<std::uint32_t> known(points.count, none);  // in the shape, of each point that is used
        const auto vertex = [&](std::size_t i) {
            std::uint32_t& place = known[number_at(i)];
            if (place != none) return place;
            const std::size_t from = number_at(i);
            place = static_cast<std::uint32_t>(polygons_.vertices.size());
            polygons_.vertices.push_back(
                motion.moved({points.at(from, 0), points.at(from, 1), points.at(from, 2)}, file_.name));
            return place;
        };
        const auto triangle = [&](std::size_t a, std::size_t b, std::size_t c) {
            polygons_.add_triangle(vertex(a), vertex(motion.mirrors() ? c : b), vertex(motion.mirrors() ? b : c));
        };
        const auto line = [&](std::size_t a, std::size_t b) {
            if (polygons_.curves.empty() || polygons_.curves.back().back() != vertex(a))
                polygons_.curves.push_back({vertex(a)});
            polygons_.curves.back().push_back(vertex(b));
        };
        const auto remainder = [&](std::size_t least, std::size_t each) {
            if (count < least || count % each != 0)
                throw bad_input(file_.name, fmt::format("a mesh has {} corners, which are no whole triangles or lines; "
                                                        "export the file again",
                                                        count));
        };
        switch (whole(primitive, "mode", 4)) {
            case 0:
                for (std::size_t i = 0; i < count; ++i) (void)vertex(i);
                break;
            case 1:
                remainder(2, 2);
                for (std::size_t i = 0; i + 1 < count; i += 2) line(i, i + 1);
                break;
            case 2:
            case 3: {
                remainder(2, 1);
                polygons_.curves.push_back({vertex(0)});
                for (std::size_t i = 0; i + 1 < count; ++i) line(i, i + 1);
                if (whole(primitive, "mode", 4) == 2) line(count - 1, 0);
                break;
            }
            case 4:
                remainder(3, 3);
                for (std::size_t i = 0; i < count; i += 3) triangle(i, i + 1, i + 2);
                break;
            case 5:
                remainder(3, 1);
                for (std::size_t i = 0; i + 2 < count; ++i) triangle(i, i + 1 + i % 2, i + 2 - i % 2);
                break;
            case 6:
                remainder(3, 1);
                for (std::size_t i = 1; i + 1 < count; ++i) triangle(0, i, i + 1);
                break;
            default: throw primitive.at("mode").wrong("0 to 6");
        }
    }

    static constexpr std::size_t most_deep = 256;
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    const ShapeFile& file_;
    nlohmann::ordered_json json_;
    std::string_view chunk_;
    std::vector<std::string> buffers_;
    std::vector<JsonMember> nodes_, meshes_, accessors_, views_;
    std::vector<bool> seen_;
    bool skinned_ = false;
    Polygons polygons_;
};

}  // namespace

Polygons read_gltf(const ShapeFile& file) { return GltfReader(file).read(); }

}  // namespace haptogram::formats
