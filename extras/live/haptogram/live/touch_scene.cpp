// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/touch_scene.hpp"

#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double cos_45 = 0.5 * std::numbers::sqrt2;
constexpr std::size_t most_votes = 64;  ///< more points than that tell nothing new

/// Of the convex hull of points in a plane, m²: Andrew's chain, its lower half and then its upper one.
double hull_area(std::vector<std::array<double, 2>> points) {
    std::sort(points.begin(), points.end());
    double twice = 0.0;
    for (int half = 0; half < 2; ++half) {
        std::vector<std::array<double, 2>> chain;
        for (const auto& p : points) {
            const auto turns_left = [&](const auto& a, const auto& b) {
                return (b[0] - a[0]) * (p[1] - b[1]) > (b[1] - a[1]) * (p[0] - b[0]);
            };
            while (chain.size() > 1 && !turns_left(chain[chain.size() - 2], chain.back())) chain.pop_back();
            chain.push_back(p);
        }
        for (std::size_t i = 1; i < chain.size(); ++i)
            twice += chain[i - 1][0] * chain[i][1] - chain[i][0] * chain[i - 1][1];
        std::reverse(points.begin(), points.end());
    }
    return 0.5 * twice;
}

}  // namespace

std::optional<Vec3> inward_at(const Solid& solid, Vec3 place) {
    constexpr double step = 1e-6, least_slope = 0.9;
    const auto slope = [&](Vec3 way) {
        return (solid.distance(place + step * way) - solid.distance(place - step * way)) / (2.0 * step);
    };
    const Vec3 out{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
    // The slope is 1 but where two parts of the surface are equally near.
    if (!(norm(out) > least_slope)) return {};
    return out * (-1.0 / norm(out));
}

double depth_along(const Solid& solid, Vec3 place, Vec3 inward) {
    constexpr double there = 1e-7;
    double depth = 0.0;
    for (int step = 0; step < 200; ++step) {
        const double left = -solid.distance(place - depth * inward);
        if (left < there) break;
        depth += left;
    }
    return depth;
}

Crossing::Crossing(const Solid& solid, std::span<const Vec3> outside) {
    constexpr double below = 1e-4;  ///< a face's normal is looked up so far behind it
    const std::size_t stride = std::max<std::size_t>(1, (outside.size() + most_votes - 1) / most_votes);
    for (std::size_t i = 0; i < outside.size(); i += stride) {
        const std::optional<Vec3> way = inward_at(solid, outside[i]);
        if (!way) continue;
        const Vec3 behind = outside[i] + (solid.distance(outside[i]) + below) * *way;
        if (const std::optional<Vec3> inward = inward_at(solid, behind)) votes_.push_back({outside[i], *inward});
    }
}

Crossing::Crossing(const Crossing& a, const Crossing& b) : votes_(a.votes_) {
    votes_.insert(votes_.end(), b.votes_.begin(), b.votes_.end());
}

double Crossing::area(Vec3 inward) const {
    const Vec3 level = std::abs(inward.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 x = cross(inward, level) * (1.0 / norm(cross(inward, level))), y = cross(inward, x);
    std::vector<std::array<double, 2>> points;
    for (const Vote& vote : votes_)
        if (dot(vote.inward, inward) > cos_45) points.push_back({dot(vote.place, x), dot(vote.place, y)});
    return hull_area(std::move(points));
}

std::optional<Vec3> Crossing::inward() const {
    constexpr double same_face = 0.985;  // within 10°: its section is about the same
    if (votes_.empty()) return {};
    std::vector<Vec3> faces;
    double most = -1.0;
    Vec3 best;
    for (const Vote& vote : votes_) {
        if (std::any_of(faces.begin(), faces.end(), [&](Vec3 face) { return dot(face, vote.inward) > same_face; }))
            continue;
        faces.push_back(vote.inward);
        if (const double through = area(vote.inward); through > most) {
            most = through;
            best = vote.inward;
        }
    }
    Vec3 sum;
    for (const Vote& vote : votes_)
        if (dot(vote.inward, best) > cos_45) sum = sum + vote.inward;
    return sum * (1.0 / norm(sum));
}

void require_sound(const ContactOptions& options) {
    const auto not_negative = [](const char* name, double value) {
        if (!(value >= 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("found {}, expected 0 or more", value));
    };
    not_negative("stiffness", options.stiffness_n_m);
    not_negative("damping", options.damping_n_s_m);
    not_negative("static friction", options.static_friction);
    not_negative("dynamic friction", options.dynamic_friction);
    not_negative("spread", options.spread_m);
    if (options.dynamic_friction > options.static_friction)
        throw bad_argument("dynamic friction", fmt::format("found {}, expected no more than the static one, {}",
                                                           options.dynamic_friction, options.static_friction));
}

Vec3 slid(Vec3 god_object, Vec3 finger, Vec3 inward, double static_friction, double dynamic_friction) {
    const Vec3 way = finger - god_object;
    const double deep = dot(way, inward);
    const Vec3 along = way - deep * inward;
    const double sideways = norm(along);
    if (!(deep > 0.0) || sideways <= static_friction * deep) return god_object;
    return god_object + ((sideways - dynamic_friction * deep) / sideways) * along;
}

FingerContact::FingerContact(const ContactOptions& options, Vec3 finger, Vec3 inward, const Pose& body)
    : options_(options), inward_{dot(inward, body.x), dot(inward, body.y), dot(inward, body.z)} {
    require_sound(options);
    const Vec3 level = std::abs(inward.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 side = cross(inward, level) * (1.0 / norm(cross(inward, level)));
    const Vec3 up = cross(side, inward);
    offsets_ = {Vec3{}, options.spread_m * side, -1.0 * options.spread_m * side, options.spread_m * up,
                -1.0 * options.spread_m * up};
    for (std::size_t i = 0; i < god_objects; ++i) gods_.at(i) = body.inwards(finger + offsets_.at(i));
}

std::array<Push, FingerContact::god_objects> FingerContact::pushes(Vec3 finger, Vec3 finger_velocity, const Pose& body,
                                                                   const std::function<Vec3(Vec3 place)>& velocity_of) {
    constexpr double share = 1.0 / god_objects;
    const Vec3 normal = inward(body);
    std::array<Push, god_objects> pushes;
    for (std::size_t i = 0; i < god_objects; ++i) {
        const Vec3 point = finger + offsets_.at(i);
        const Vec3 god =
            slid(body.outwards(gods_.at(i)), point, normal, options_.static_friction, options_.dynamic_friction);
        gods_.at(i) = body.inwards(god);
        const Vec3 force = share * (options_.stiffness_n_m * (point - god) +
                                    options_.damping_n_s_m * (finger_velocity - velocity_of(god)));
        const bool inside = dot(point - god, normal) > 0.0 && dot(force, normal) > 0.0;
        pushes.at(i) = {inside ? force : Vec3{}, god};
    }
    return pushes;
}

void FingerContact::turn(Vec3 finger, Vec3 inward, const Pose& body) {
    const Vec3 from = this->inward(body), axis = cross(from, inward);
    const double cosine = dot(from, inward);
    // By Rodrigues' formula; half a turn has no axis of its own, and any across the normal does.
    const Vec3 across = std::abs(from.x) < 0.9 ? cross(from, {1, 0, 0}) : cross(from, {0, 1, 0});
    const auto turned = [&](Vec3 v) {
        if (cosine < -1.0 + 1e-9) return 2.0 / dot(across, across) * dot(across, v) * across - v;
        return cosine * v + cross(axis, v) + dot(axis, v) / (1.0 + cosine) * axis;
    };
    for (std::size_t i = 0; i < god_objects; ++i) {
        const Vec3 spring = finger + offsets_.at(i) - body.outwards(gods_.at(i));
        offsets_.at(i) = turned(offsets_.at(i));
        gods_.at(i) = body.inwards(finger + offsets_.at(i) - turned(spring));
    }
    inward_ = {dot(inward, body.x), dot(inward, body.y), dot(inward, body.z)};
}

bool FingerContact::ended(Vec3 finger, const Pose& body) const { return dot(finger - place(body), inward(body)) < 0.0; }

double FingerContact::spring_energy(Vec3 finger, const Pose& body) const {
    double energy = 0.0;
    for (std::size_t i = 0; i < god_objects; ++i) {
        const Vec3 way = finger + offsets_.at(i) - body.outwards(gods_.at(i));
        if (dot(way, inward(body)) > 0.0) energy += 0.5 * options_.stiffness_n_m / god_objects * dot(way, way);
    }
    return energy;
}

namespace {

constexpr double scale = 20.0;  ///< Bullet's lengths over metres
btVector3 to_bullet(Vec3 v, double factor) {
    return {static_cast<btScalar>(v.x * factor), static_cast<btScalar>(v.y * factor),
            static_cast<btScalar>(v.z * factor)};
}
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btTransform to_bullet(const Pose& pose) {
    const btMatrix3x3 turn(
        static_cast<btScalar>(pose.x.x), static_cast<btScalar>(pose.y.x), static_cast<btScalar>(pose.z.x),
        static_cast<btScalar>(pose.x.y), static_cast<btScalar>(pose.y.y), static_cast<btScalar>(pose.z.y),
        static_cast<btScalar>(pose.x.z), static_cast<btScalar>(pose.y.z), static_cast<btScalar>(pose.z.z));
    return btTransform(turn, to_bullet(pose.origin, scale));
}

std::unique_ptr<btCollisionShape> shape_of(std::string_view kind, double size_m, double height_m) {
    if (!(size_m > 0.0 && height_m > 0.0))
        throw bad_argument("size", fmt::format("{} and a height of {} m; expected more than 0", size_m, height_m));
    const auto half = static_cast<btScalar>(0.5 * size_m * scale), top = static_cast<btScalar>(0.5 * height_m * scale);
    if (kind == "cube") return std::make_unique<btBoxShape>(btVector3(half, half, half));
    if (kind == "sphere") return std::make_unique<btSphereShape>(half);
    if (kind == "cylinder") return std::make_unique<btCylinderShapeZ>(btVector3(half, half, top));
    throw bad_argument("object", fmt::format("found \"{}\", expected cube, sphere or cylinder", kind));
}

void require_sound(const WorldOptions& options) {
    const Vec3 room = options.high - options.low;
    if (!is_finite(options.gravity) || !(room.x > 0.0 && room.y > 0.0 && room.z > 0.0))
        throw bad_argument("walls", "there is no room between them, or the gravity is not finite");
    if (!(options.friction >= 0.0 && options.step_s > 0.0 && options.step_s < 1.0))
        throw bad_argument("world", fmt::format("friction {} and steps of {} s; expected 0 or more, and 0 to 1 s",
                                                options.friction, options.step_s));
}

}  // namespace

struct World::State {
    explicit State(const WorldOptions& given)
        : options(given), dispatcher(&configuration), dynamics(&dispatcher, &broadphase, &solver, &configuration) {
        require_sound(given);
        dynamics.setGravity(to_bullet(given.gravity, scale));
        for (unsigned axis = 0; axis < 3; ++axis)
            for (const double sign : {1.0, -1.0}) {
                const Vec3 normal{axis == 0 ? sign : 0.0, axis == 1 ? sign : 0.0, axis == 2 ? sign : 0.0};
                const double place = dot(normal, sign > 0.0 ? given.low : given.high);
                shapes.push_back(
                    std::make_unique<btStaticPlaneShape>(to_bullet(normal, 1.0), static_cast<btScalar>(place * scale)));
                add_rigid(shapes.back().get(), 0.0, btTransform::getIdentity());
            }
    }
    ~State() {
        for (const auto& body : rigid) dynamics.removeRigidBody(body.get());
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    void add_rigid(btCollisionShape* shape, double mass, const btTransform& place) {
        btVector3 inertia(0, 0, 0);
        if (mass > 0.0) shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
        btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape, inertia);
        info.m_startWorldTransform = place;
        info.m_friction = static_cast<btScalar>(options.friction);
        info.m_restitution = 0;
        auto body = std::make_unique<btRigidBody>(info);
        body->setActivationState(DISABLE_DEACTIVATION);
        dynamics.addRigidBody(body.get());
        rigid.push_back(std::move(body));
    }
    [[nodiscard]] btRigidBody& body(std::size_t number) const { return *rigid.at(walls + number); }

    static constexpr std::size_t walls = 6;
    WorldOptions options;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher;
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld dynamics;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> rigid;
};

World::World(const WorldOptions& options) : state_(std::make_unique<State>(options)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

std::size_t World::add(std::string_view kind, double size_m, double height_m, const BodyOptions& options) {
    if (!(options.mass_kg >= 0.0 && std::isfinite(options.mass_kg)))
        throw bad_argument("mass", fmt::format("found {} kg, expected 0 or more", options.mass_kg));
    state_->shapes.push_back(shape_of(kind, size_m, height_m));
    state_->add_rigid(state_->shapes.back().get(), options.mass_kg, to_bullet(options.pose));
    return bodies() - 1;
}

std::size_t World::bodies() const { return state_->rigid.size() - State::walls; }

Pose World::pose(std::size_t body) const {
    const btTransform& place = state_->body(body).getWorldTransform();
    const btMatrix3x3& turn = place.getBasis();
    Pose pose;
    pose.origin = from_bullet(place.getOrigin()) * (1.0 / scale);
    pose.x = from_bullet(turn.getColumn(0));
    pose.y = from_bullet(turn.getColumn(1));
    pose.z = from_bullet(turn.getColumn(2));
    return pose;
}

Vec3 World::velocity_at(std::size_t body, Vec3 place) const {
    const btRigidBody& rigid = state_->body(body);
    const btVector3 from = to_bullet(place, scale) - rigid.getCenterOfMassPosition();
    return from_bullet(rigid.getVelocityInLocalPoint(from)) * (1.0 / scale);
}

double World::mass(std::size_t body) const {
    const btScalar inverse = state_->body(body).getInvMass();
    return inverse > 0 ? 1.0 / inverse : 0.0;
}

double World::energy(std::size_t body) const {
    const btRigidBody& rigid = state_->body(body);
    if (rigid.getInvMass() <= 0) return 0.0;
    const btVector3 spin = rigid.getWorldTransform().getBasis().transpose() * rigid.getAngularVelocity();
    double turning = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        turning += 0.5 * spin[axis] * spin[axis] / rigid.getInvInertiaDiagLocal()[axis] / (scale * scale);
    const Vec3 velocity = from_bullet(rigid.getLinearVelocity()) * (1.0 / scale);
    const Vec3 height = pose(body).origin - state_->options.low;
    return turning + mass(body) * (0.5 * dot(velocity, velocity) - dot(state_->options.gravity, height));
}

void World::push(std::size_t body, Vec3 force, Vec3 place) {
    btRigidBody& rigid = state_->body(body);
    const btVector3 scaled = to_bullet(force, scale);
    rigid.applyForce(scaled, to_bullet(place, scale) - rigid.getCenterOfMassPosition());
}

void World::step() { state_->dynamics.stepSimulation(static_cast<btScalar>(state_->options.step_s), 0); }

const WorldOptions& World::options() const { return state_->options; }

namespace {

constexpr double longest_gap_s = 0.5;  ///< after a longer one the object has stood still: nobody held it

Solid solid_of(const SceneOptions& options) {
    if (options.solid) return *options.solid;
    return built_in_object(options.kind, {options.size_m, options.height_m, {}, {}}).solid;
}

/// Calls `take` with the points of a cloud that are not farther than a margin from a cluster's box.
template <class Take>
void around(std::span<const Vec3> cloud, const Cluster& cluster, double margin, Take take) {
    Vec3 low = cluster.points.front(), high = low;
    for (const Vec3& p : cluster.points) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    for (const Vec3& p : cloud)
        if (p.x > low.x - margin && p.y > low.y - margin && p.z > low.z - margin && p.x < high.x + margin &&
            p.y < high.y + margin && p.z < high.z + margin)
            take(p);
}

}  // namespace

TouchScene::TouchScene(const SceneOptions& options)
    : options_(options), solid_(solid_of(options)), world_(options.world), tracker_(options.gate_m) {
    require_sound(options.contact);
    if (!(options.slab_m > 0.0))
        throw bad_argument("slab", fmt::format("found {} m, expected more than 0", options.slab_m));
    if (options.mass_kg > 0.0) {
        const double height = options.kind == "cylinder" ? options.height_m : options.size_m;
        world_.add(options.kind, options.size_m, height, {options.mass_kg, options.pose});
    }
}

Pose TouchScene::object() const { return world_.bodies() > 0 ? world_.pose(0) : options_.pose; }

double TouchScene::distance_to(Vec3 point) const { return solid_.distance(object().inwards(point)); }

TouchScene::Entry TouchScene::entry_of(std::span<const Vec3> cloud, Cluster cluster) const {
    const Pose pose = object();
    std::vector<Vec3> outside;
    around(cloud, cluster, options_.slab_m + options_.cluster_m, [&](Vec3 p) {
        const Vec3 at = pose.inwards(p);
        if (const double out = solid_.distance(at); out >= 0.0 && out < options_.slab_m) outside.push_back(at);
    });
    Crossing crossing(solid_, outside);
    // What is in the object altogether came in by the nearest face, and in the middle of it from above.
    const std::optional<Vec3> voted = crossing.inward();
    const std::optional<Vec3> nearest = voted ? voted : inward_at(solid_, pose.inwards(cluster.centroid));
    const Vec3 inward = nearest ? pose.turned(*nearest) : Vec3{0, 0, -1};
    return {std::move(cluster), std::move(crossing), inward};
}

std::vector<TouchScene::Entry> TouchScene::entries_of(std::span<const Vec3> cloud) const {
    const Pose pose = object();
    std::vector<Vec3> inside;
    for (const Vec3& p : cloud)
        if (solid_.contains(pose.inwards(p))) inside.push_back(p);
    std::vector<Entry> entries;
    for (Cluster& cluster : clusters_of(inside, options_.cluster_m, options_.least_points))
        entries.push_back(entry_of(cloud, std::move(cluster)));
    join_parts(cloud, entries);
    return entries;
}

/// Whether two parts of skin go through the surface the same way, within 45°, and are together no wider than a finger.
/// Beside an edge a finger goes through two faces, and each part of it may have more of the other one; so it is enough
/// that both go through the face that they go through most together.
bool TouchScene::one_finger(const Entry& a, const Entry& b) const {
    constexpr double same_way = 0.5 * std::numbers::sqrt2;
    const std::optional<Vec3> through = Crossing(a.crossing, b.crossing).inward();
    const bool both = through && a.crossing.area(*through) > 0.0 && b.crossing.area(*through) > 0.0;
    if (!both && dot(a.inward, b.inward) < same_way) return false;
    const Vec3 inward = through ? object().turned(*through) : a.inward;
    return width_across(together(a.cluster, b.cluster).points, inward) <= options_.finger_m;
}

/// Cameras that look along a finger, or at its sides alone, see parts of its skin with gaps between them. Those that
/// are one finger are joined, the nearest pairs first. Ours: the paper has cameras on all sides.
void TouchScene::join_parts(std::span<const Vec3> cloud, std::vector<Entry>& entries) const {
    for (bool joined = options_.finger_m > 0.0; joined;) {
        joined = false;
        std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
        for (std::size_t a = 0; a < entries.size(); ++a)
            for (std::size_t b = a + 1; b < entries.size(); ++b)
                pairs.emplace_back(distance(entries[a].cluster.centroid, entries[b].cluster.centroid), a, b);
        std::sort(pairs.begin(), pairs.end());
        for (const auto& [way, a, b] : pairs) {
            if (!one_finger(entries[a], entries[b])) continue;
            entries[a] = entry_of(cloud, together(entries[a].cluster, entries[b].cluster));
            entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(b));
            joined = true;
            break;
        }
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.cluster.points.size() > b.cluster.points.size(); });
}

std::vector<Vec3> TouchScene::section_of(std::span<const Vec3> cloud, const Cluster& cluster, Vec3 surface,
                                         Vec3 inward) const {
    const auto beside_plane = [&](Vec3 p) { return std::abs(dot(p - surface, inward)) < options_.slab_m; };
    std::vector<Vec3> points;
    for (const Vec3& p : cluster.points)
        if (beside_plane(p)) points.push_back(p);
    // Outside, what is joined to the points inside is the same finger. It starts within the slab's thickness of them.
    around(cloud, cluster, 2.0 * options_.slab_m + options_.cluster_m, [&](Vec3 p) {
        if (beside_plane(p) && distance_to(p) >= 0.0) points.push_back(p);
    });
    const std::vector<Cluster> parts = clusters_of(points, options_.cluster_m, 1);
    if (parts.empty()) return {};
    // A part that has points inside is of this finger, too, unless it makes it wider than one.
    std::vector<Vec3> section = parts.front().points;
    for (std::size_t i = 1; i < parts.size(); ++i) {
        if (std::none_of(parts[i].points.begin(), parts[i].points.end(), [&](Vec3 p) { return distance_to(p) < 0.0; }))
            continue;
        std::vector<Vec3> both = section;
        both.insert(both.end(), parts[i].points.begin(), parts[i].points.end());
        if (width_across(both, inward) <= options_.finger_m) section = std::move(both);
    }
    return section;
}

/// The contact of a finger: a new one, or the one that it has, turned to where it goes through the surface now.
/// @param entry  nothing for a finger that is not seen in this shot
TouchScene::Held& TouchScene::hold(const TrackedFinger& finger, const Entry* entry) {
    const Pose pose = object();
    const auto found = held_.find(finger.id);
    // A finger that has come out, and is in again at another place, begins anew.
    if (found != held_.end() && entry != nullptr && found->second.contact.ended(finger.place, pose)) held_.erase(found);
    const Vec3 inward = entry != nullptr ? entry->inward : Vec3{0, 0, -1};
    const auto [at, fresh] = held_.try_emplace(
        finger.id, Held{FingerContact(options_.contact, finger.place, inward, pose), finger.place, finger.place});
    Held& held = at->second;
    if (!fresh && entry != nullptr) {
        constexpr double same = 0.985, bend = 0.5 * std::numbers::sqrt2;  // 10° and 45°
        const double alike = dot(held.contact.inward(pose), entry->inward);
        const auto area = [&](Vec3 way) {
            return entry->crossing.area({dot(way, pose.x), dot(way, pose.y), dot(way, pose.z)});
        };
        // Round a bend the normal follows; over an edge only when most of the finger is on the other face.
        const bool follows = alike > bend || area(entry->inward) >= 2.0 * area(held.contact.inward(pose));
        if (alike < same && follows && area(entry->inward) > 0.0) held.contact.turn(held.to, entry->inward, pose);
    }
    held.from = fresh ? finger.place : held.to;
    held.to = finger.place;
    return held;
}

/// The point of the surface that a god-object belongs to: outwards from one inside, the nearest from one outside.
Vec3 TouchScene::surface_at(Vec3 god, Vec3 inward_of_body) const {
    const Pose pose = object();
    const Vec3 at = pose.inwards(god);
    const double out = solid_.distance(at);
    if (out < 0.0) return god - depth_along(solid_, at, inward_of_body) * pose.turned(inward_of_body);
    const Vec3 way = inward_at(solid_, at).value_or(inward_of_body);
    return god + out * pose.turned(way);
}

void TouchScene::meet(std::span<const Vec3> cloud, const std::vector<Entry>& entries,
                      const std::vector<TrackedFinger>& tracked) {
    const Pose pose = object();
    std::erase_if(held_, [&](const auto& held) {
        return std::none_of(tracked.begin(), tracked.end(), [&](const auto& t) { return t.id == held.first; });
    });
    fingers_.clear();
    for (const TrackedFinger& t : tracked) {
        const Entry* entry = t.seen ? &entries[t.cluster] : nullptr;
        const Held& held = hold(t, entry);
        SceneFinger finger;
        finger.id = t.id;
        finger.seen = t.seen;
        finger.place = t.place;
        if (shot_s_ > 0.0) finger.velocity = (t.place - held.from) * (1.0 / shot_s_);
        finger.inward = held.contact.inward(pose);
        finger.surface = surface_at(held.contact.place(pose), held.contact.inward_of_body());
        if (entry != nullptr) {
            for (const Vec3& p : entry->cluster.points)
                finger.deepest_m = std::max(finger.deepest_m, dot(p - finger.surface, finger.inward));
            finger.section = section_of(cloud, entry->cluster, finger.surface, finger.inward);
        }
        fingers_.push_back(std::move(finger));
    }
}

void TouchScene::simulate(double seconds) {
    const bool moves = world_.bodies() > 0;  // what is fixed is pushed, too, and god-objects slide on it
    if (seconds > longest_gap_s) seconds = longest_gap_s;
    owed_s_ += seconds;
    const double step_s = options_.world.step_s;
    const auto steps = static_cast<std::size_t>(std::floor(owed_s_ / step_s + 1e-9));
    owed_s_ -= static_cast<double>(steps) * step_s;
    for (std::size_t i = 1; i <= steps; ++i) {
        const Pose pose = object();
        const double part = static_cast<double>(i) / static_cast<double>(steps);
        for (SceneFinger& finger : fingers_) {
            Held& held = held_.at(finger.id);
            const Vec3 velocity = (held.to - held.from) * (1.0 / seconds);
            const Vec3 moved = (held.to - held.from) * (1.0 / static_cast<double>(steps));
            const Vec3 place = held.from + part * (held.to - held.from);
            finger.force = {};
            for (const Push& push : held.contact.pushes(
                     place, velocity, pose, [&](Vec3 p) { return moves ? world_.velocity_at(0, p) : Vec3{}; })) {
                if (moves) world_.push(0, push.force, push.place);
                finger.force = finger.force + push.force;
            }
            // A spring's force grows with the way, so its mean over the step is what counts.
            work_j_ += 0.5 * dot(held.force + finger.force, moved);
            held.force = finger.force;
        }
        if (moves) world_.step();
    }
}

const std::vector<SceneFinger>& TouchScene::update(std::span<const Vec3> cloud, double time_s) {
    if (time_s_ && !(time_s > *time_s_))
        throw bad_argument("time", fmt::format("{} s after one of {} s; expected a later one", time_s, *time_s_));
    shot_s_ = time_s_ ? time_s - *time_s_ : 0.0;
    time_s_ = time_s;
    const std::vector<Entry> entries = entries_of(cloud);
    std::vector<Cluster> clusters;
    for (const Entry& entry : entries) clusters.push_back(entry.cluster);
    meet(cloud, entries, tracker_.update(clusters));
    if (shot_s_ > 0.0) simulate(shot_s_);
    return fingers_;
}

double TouchScene::energy() const {
    const Pose pose = object();
    double energy = world_.bodies() > 0 ? world_.energy(0) : 0.0;
    for (const auto& [id, held] : held_) energy += held.contact.spring_energy(held.to, pose);
    return energy;
}

}  // namespace haptogram
