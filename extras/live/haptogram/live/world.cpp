// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/world.hpp"

#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram {
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

}  // namespace haptogram
