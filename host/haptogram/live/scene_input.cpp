// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/scene_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/json_member.hpp"

namespace haptogram::live {
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

double due_s(const std::string& line, const std::string& where) {
    const nlohmann::ordered_json document = parse_json(line, where);
    const auto time = JsonMember(document, where).find("time_s");
    return time ? time->number(0.0, largest) : 0.0;
}

bool is_blank(const std::string& line) { return line.find_first_not_of(" \t\r") == std::string::npos; }

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
    sources_[first_name] = first;
    objects_[first_name] = open_object(first);
    all_ = std::make_shared<const TouchObject>(together(objects_));
    if (!path.empty()) lines_.emplace(path);
    if (lines_ && lines_->is_file()) static_cast<void>(at(0.0));  // so that what is wrong there is said at once
}

void SceneInput::take(const std::string& text) {
    const std::string where = lines_->where();
    const nlohmann::ordered_json document = parse_json(text, where);
    const JsonMember line(document, where);
    for (const auto& [key, value] : line.object().items())
        if (const auto known = {"time_s", "name", "object", "size_mm", "height_mm", "center_mm", "rotate_deg",
                                "remove"};
            std::find(known.begin(), known.end(), key) == known.end())
            throw bad_input(where, fmt::format("found {}, expected {}", key, fmt::join(known, ", ")));
    const auto name_given = line.find("name");
    const std::string name = name_given ? name_given->text() : first_name;
    if (line.find("remove")) {
        objects_.erase(name);
        sources_.erase(name);
    } else {
        const auto known = sources_.find(name);
        if (known == sources_.end() && !line.find("object"))
            throw bad_input(where, fmt::format("there is no {} yet; say what 'object' it is", name));
        ObjectSource source = changed(known == sources_.end() ? ObjectSource{} : known->second, line);
        objects_[name] = open_object(source);
        sources_[name] = std::move(source);
    }
    all_ = std::make_shared<const TouchObject>(together(objects_));
}

std::shared_ptr<const TouchObject> SceneInput::at(double time_s) {
    while (lines_) {
        if (!waiting_) waiting_ = lines_->next(std::chrono::milliseconds(0));
        if (!waiting_) break;
        if (is_blank(*waiting_)) {
            waiting_.reset();
            continue;
        }
        try {
            if (lines_->is_file() && due_s(*waiting_, lines_->where()) > time_s) break;
            take(*std::exchange(waiting_, std::nullopt));
        } catch (const Error&) {
            if (lines_->is_file()) throw;
            waiting_.reset();
            ++junk_;
        }
    }
    return all_;
}

}  // namespace haptogram::live
