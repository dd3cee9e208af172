// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/opened_objects.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/open.hpp"

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

}  // namespace haptogram::live
