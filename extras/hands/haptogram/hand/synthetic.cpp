// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/synthetic.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

using std::numbers::pi;

/// From 0 to 1 and back in one period, and its derivative by time.
struct Swing {
    double value, rate;
};

Swing swing(double time_s, double period_s) {
    const double turns = 2.0 * pi * time_s / period_s;
    return {0.5 - 0.5 * std::cos(turns), pi / period_s * std::sin(turns)};
}

/// A finger that leaves the palm's centre at `knuckle` in the direction `out_deg` from y, with three segments, mm. It
/// bends towards −z, by `bend` at each of its two outer joints.
Finger finger(Vec3 knuckle, double out_deg, const std::array<double, 3>& lengths, double bend) {
    const double out = out_deg * pi / 180.0;
    const Vec3 along{std::sin(out), std::cos(out), 0.0};
    Finger made;
    Vec3 at = knuckle;
    made.joints[0] = at * millimetre;
    for (std::size_t i = 0; i < 3; ++i) {
        const double angle = bend * static_cast<double>(i);
        at = at + lengths.at(i) * (std::cos(angle) * along - std::sin(angle) * Vec3{0, 0, 1});
        made.joints.at(i + 1) = at * millimetre;
    }
    return made;
}

Vec3 about_z(Vec3 p, double angle) {
    return {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
}

}  // namespace

HandScript hand_script(std::string_view name) {
    if (name == "press") return HandScript::press;
    if (name == "slide") return HandScript::slide;
    if (name == "grasp") return HandScript::grasp;
    if (name == "wave") return HandScript::wave;
    throw bad_argument("hand", fmt::format("found \"{}\", expected press, slide, grasp or wave", name));
}

double seconds_of(HandScript script) {
    return script == HandScript::slide ? 3.0 : script == HandScript::wave ? 1.0 : 2.0;
}

Hand synthetic_hand(HandScript script, double time_s, double height_m) {
    Hand hand;
    double bend = 0.0;
    hand.palm = {0, 0, height_m};
    double turn = 0.0, turn_rate = 0.0;
    if (script == HandScript::press) {
        const Swing s = swing(time_s, seconds_of(script));
        hand.palm.z -= 0.03 * s.value;
        hand.velocity.z = -0.03 * s.rate;
    } else if (script == HandScript::slide) {
        const Swing s = swing(time_s, seconds_of(script));
        hand.palm.x += 0.06 * s.value;
        hand.velocity.x = 0.06 * s.rate;
    } else if (script == HandScript::grasp) {
        const Swing s = swing(time_s, seconds_of(script));
        bend = 70.0 * pi / 180.0 * s.value;
        hand.grab = s.value;
    } else {
        const double turns = 2.0 * pi * time_s / seconds_of(script);
        turn = pi / 6.0 * std::sin(turns);
        turn_rate = pi / 6.0 * 2.0 * pi * std::cos(turns);
    }
    // A palm-down right hand has its thumb on the side of −x.
    hand.fingers = {finger({-38, -20, 0}, -45, {46, 32, 27}, 0.5 * bend), finger({-27, 45, 0}, -8, {40, 23, 20}, bend),
                    finger({-8, 47, 0}, 0, {44, 27, 21}, bend), finger({11, 44, 0}, 6, {41, 26, 21}, bend),
                    finger({28, 38, 0}, 14, {33, 19, 19}, bend)};
    const Vec3 wrist{0, -0.05, 0};  // from the palm's centre
    const Vec3 centre = wrist + about_z(Vec3{} - wrist, turn);
    hand.palm = hand.palm + centre;
    hand.velocity = hand.velocity + turn_rate * cross({0, 0, 1}, centre - wrist);
    hand.direction = about_z(hand.direction, turn);
    for (auto& one : hand.fingers)
        for (Vec3& joint : one->joints) joint = hand.palm + about_z(joint, turn);
    return hand;
}

}  // namespace haptogram
