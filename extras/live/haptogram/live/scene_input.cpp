// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/scene_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/hand/recording.hpp"

namespace haptogram::live {
namespace {

/// Takes in a point.
void widen(Vec3& low, Vec3& high, Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

Solid scaled(const Solid& solid, const Pose& pose, double scale) {
    const auto at = [pose, scale](const std::function<double(Vec3)>& of) {
        return [of, pose, scale](Vec3 p) { return scale * of(pose.inwards(p) * (1.0 / scale)); };
    };
    Solid result{at(solid.distance)};
    if (solid.bound) result.bound = at(solid.bound);
    return result;
}

}  // namespace

/// A mesh with its box around the origin, as large as the file has it.
struct OpenedObjects::Body {
    TouchObject object;
    std::vector<Vec3> corners;  ///< of its triangles
    double largest = 0.0;       ///< of the box's edges
};

const OpenedObjects::Body& OpenedObjects::body_of(const ObjectSource& source) {
    std::shared_ptr<const Body>& kept = bodies_[{source.name, source.unit}];
    if (kept) return *kept;
    ObjectSource plain;
    plain.name = source.name;
    plain.unit = source.unit;
    plain.readers = source.readers;
    plain.centre = {};
    const std::string content = names_mesh(plain) ? read_file(plain.name) : std::string();
    const FileReader read = [&](const auto&) { return content; };
    Body body;
    body.object = open_object(plain, read);
    const Mesh mesh = surface_of(plain, read);
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) body.corners.push_back(mesh.vertices.at(corner));
    Vec3 low = body.corners.front(), high = low;
    for (const Vec3& p : body.corners) widen(low, high, p);
    body.largest = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    return *(kept = std::make_shared<const Body>(std::move(body)));
}

TouchObject OpenedObjects::open(const ObjectSource& source) {
    if (is_built_in(source)) return open_object(source);
    if (source.height_m) return open_object(source);  // which refuses it
    const Body& body = body_of(source);
    const double scale = source.size_m ? *source.size_m / body.largest : 1.0;
    Pose pose = pose_of({}, source.angles_deg);
    const auto placed = [&](Vec3 p) { return pose.outwards(scale * p); };
    Vec3 low = placed(body.corners.front()), high = low;
    for (const Vec3& p : body.corners) widen(low, high, placed(p));
    pose.origin = source.centre - 0.5 * (low + high);
    TouchObject object;
    object.name = body.object.name;
    object.solid = scaled(body.object.solid, pose, scale);
    object.low = low + pose.origin;
    object.high = high + pose.origin;
    for (const Edge& edge : body.object.edges) {
        Edge& moved = object.edges.emplace_back();
        for (const Vec3& p : edge) moved.push_back(placed(p));
    }
    for (const Vec3& corner : body.object.corners) object.corners.push_back(placed(corner));
    return object;
}

FeltObject OpenedObjects::told(const std::string& name, const ObjectSource& source) {
    FeltObject told{name, source.name, 0.0, {}, pose_of(source.centre, source.angles_deg)};
    if (names_mesh(source)) {
        told.size_m = source.size_m ? *source.size_m : body_of(source).largest;
        return told;
    }
    told.size_m = source.size_m.value_or(ObjectMeasures{}.size);
    if (has_height(source.name)) told.height_m = source.height_m.value_or(told.size_m);
    return told;
}

namespace {

constexpr const char* first_name = "object";
constexpr double largest = 1e6;  // mm, degrees, seconds

Vec3 triple_of(const JsonMember& member) {
    const std::vector<JsonMember> parts = member.list();
    if (parts.size() != 3) throw member.wrong("three numbers");
    const auto part = [&](std::size_t i) { return parts[i].number(-largest, largest); };
    return {part(0), part(1), part(2)};
}

/// What a line says of an object, over what was known of it.
ObjectSource changed(ObjectSource source, const JsonMember& line) {
    const auto length = [&](const char* key, std::optional<double>& metres) {
        if (const auto found = line.find(key)) metres = found->number(1e-3, largest) * millimetre;
    };
    if (const auto kind = line.find("object")) source.name = kind->text();
    length("size_mm", source.size_m);
    length("height_mm", source.height_m);
    if (const auto centre = line.find("center_mm")) source.centre = triple_of(*centre) * millimetre;
    if (const auto angles = line.find("rotate_deg")) source.angles_deg = triple_of(*angles);
    return source;
}

bool is_blank(const std::string& line) { return line.find_first_not_of(" \t\r") == std::string::npos; }

template <typename Map>
std::string names_of(const Map& known) {
    std::string names;
    for (const auto& [name, source] : known) names += (names.empty() ? "" : ", ") + name;
    return names.empty() ? "none" : names;
}

}  // namespace

TouchObject together(const std::map<std::string, TouchObject>& objects) {
    TouchObject all;
    std::vector<Solid> solids;
    for (const auto& [name, object] : objects) {
        solids.push_back(object.solid);
        all.edges.insert(all.edges.end(), object.edges.begin(), object.edges.end());
        all.corners.insert(all.corners.end(), object.corners.begin(), object.corners.end());
        if (solids.size() == 1) all.low = object.low, all.high = object.high, all.name = object.name;
        all.low = {std::min(all.low.x, object.low.x), std::min(all.low.y, object.low.y),
                   std::min(all.low.z, object.low.z)};
        all.high = {std::max(all.high.x, object.high.x), std::max(all.high.y, object.high.y),
                    std::max(all.high.z, object.high.z)};
    }
    if (solids.size() == 1) {
        all.solid = solids.front();
        return all;
    }
    all.solid.distance = [solids = std::move(solids)](Vec3 p) {
        double least = HUGE_VAL;  // of nothing: nobody touches it
        for (const Solid& solid : solids) least = std::min(least, solid.distance(p));
        return least;
    };
    return all;
}

SceneInput::SceneInput(const ObjectSource& first, const std::string& path) {
    apply({0.0, first_name, first});
    if (!path.empty()) lines_.emplace(path);
    if (lines_ && lines_->is_file()) read_script();
}

/// What a line says, once it is known to make sense.
/// @throws Error{bad_input} naming `where`
SceneInput::Change SceneInput::read(const std::string& text, const std::string& where, const Sources& known) {
    const nlohmann::ordered_json document = parse_json(text, where);
    const JsonMember line(document, where);
    line.only({"time_s", "name", "object", "size_mm", "height_mm", "center_mm", "rotate_deg", "remove"});
    Change change{0.0, first_name, {}};
    if (const auto time = line.find("time_s")) change.due_s = time->number(0.0, largest);
    if (const auto name = line.find("name")) change.name = name->text();
    const auto before = known.find(change.name);
    const auto remove = line.find("remove");
    if (remove && !remove->value().is_boolean()) throw remove->wrong("true or false");
    if (remove && remove->value().get<bool>()) {
        line.only({"time_s", "name", "remove"});
        if (before == known.end())
            throw bad_input(where,
                            fmt::format("there is no {} to remove; there are: {}", change.name, names_of(known)));
        return change;
    }
    if (before == known.end() && !line.find("object"))
        throw bad_input(where, fmt::format("there is no {} yet; say what 'object' it is", change.name));
    ObjectSource source = changed(before == known.end() ? ObjectSource{} : before->second, line);
    if (!has_height(source.name)) {
        if (line.find("height_mm"))
            throw bad_input(
                where, fmt::format("found height_mm of a {}; a cone, a pyramid and a cylinder have one", source.name));
        source.height_m.reset();
    }
    try {
        static_cast<void>(opened_.open(source));
    } catch (const Error& error) {
        throw bad_input(where, fmt::format("{}: {}", error.where(), error.message()));
    }
    change.source = std::move(source);
    return change;
}

void SceneInput::read_script() {
    Sources known = sources_;
    double last_s = 0.0;
    while (const std::optional<std::string> text = lines_->next(std::chrono::milliseconds(0))) {
        if (is_blank(*text)) continue;
        Change change = read(*text, lines_->where(), known);
        if (change.due_s < last_s)
            throw bad_input(lines_->where(),
                            fmt::format("found time_s {:g} behind a line of {:g}; put the lines in the "
                                        "order of their times",
                                        change.due_s, last_s));
        last_s = change.due_s;
        if (change.source)
            known[change.name] = *change.source;
        else
            known.erase(change.name);
        script_.push_back(std::move(change));
    }
}

void SceneInput::apply(const Change& change) {
    if (change.source) {
        objects_[change.name] = opened_.open(*change.source);
        sources_[change.name] = *change.source;
    } else {
        objects_.erase(change.name);
        sources_.erase(change.name);
    }
    auto now = std::make_shared<ObjectsNow>();
    now->all = together(objects_);
    for (const auto& [name, source] : sources_) {
        now->parts.push_back(objects_.at(name));
        now->told.push_back(opened_.told(name, source));
    }
    now_ = std::move(now);
}

std::shared_ptr<const ObjectsNow> SceneInput::at(double time_s) {
    for (; !script_.empty() && script_.front().due_s <= time_s; script_.pop_front()) apply(script_.front());
    if (!lines_ || lines_->is_file()) return now_;
    while (const std::optional<std::string> text = lines_->next(std::chrono::milliseconds(0))) {
        if (is_blank(*text)) continue;
        try {
            apply(read(*text, lines_->where(), sources_));
        } catch (const Error& error) {
            if (junk_.first++ == 0) junk_.second = error.what();
        }
    }
    return now_;
}

}  // namespace haptogram::live
