// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/recording.hpp"

using namespace haptogram;

namespace {

/// Poses of real hands that are not part of the repository, in a folder beside it.
std::filesystem::path recordings() {
    return std::filesystem::path(test_data()).parent_path().parent_path().parent_path() / "shared/data/poses";
}

/// A model whose bones are boxes of 20 × 10 × 30 mm that begin 5 mm behind their joint, at their origin.
std::string model_text(const std::string& cage = {}) {
    std::string box = R"({"verts": [)";
    for (int i = 0; i < 8; ++i)
        box += fmt::format("{}[{}, {}, {}]", i == 0 ? "" : ", ", (i & 1) != 0 ? 0.01 : -0.01,
                           (i & 2) != 0 ? 0.005 : -0.005, (i & 4) != 0 ? 0.025 : -0.005);
    box += R"(], "faces": [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]})";
    std::string text = R"({"controlcages": [)";
    for (int i = 0; i < 17; ++i) text += (i == 0 ? "" : ", ") + (i == 3 && !cage.empty() ? cage : box);
    text += R"(], "joints": [)";
    for (int bone = 1; bone < 17; ++bone)
        text += fmt::format(R"({}{{"rbi0": {}, "rbi1": {}, "p0": [0, 0, 0], "p1": [0, 0, 0]}})", bone == 1 ? "" : ", ",
                            bone == 1             ? 0
                            : (bone - 2) % 3 == 0 ? 1
                                                  : bone - 1,
                            bone);
    return text + R"(], "pose": []})";
}

/// A line of poses: bone i is at (10 i, 0, 300) mm and turned by the quaternion.
std::string line_of(const std::string& quaternion) {
    std::string line;
    for (int i = 0; i < 17; ++i) line += fmt::format("{} 0 0.3 {}  ", 0.01 * i, quaternion);
    return line + "\n";
}

}  // namespace

TEST_CASE("poses: joints, palm and fingertips of a small file", "[hand]") {
    const HandBones bones = bones_from_json(model_text(), "model.json");
    for (const HandBones::Bone& bone : bones.bones) {
        CHECK(distance(bone.centre, Vec3{0, 0, 0.01}) < 1e-12);
        CHECK(distance(bone.tip, Vec3{0, 0, 0.025}) < 1e-12);
    }
    // A quarter turn about x takes z to −y, and −y to −z.
    const HandRecording recording =
        recording_from_poses(line_of("0 0 0 1") + "\r\n" + line_of("0.70710678 0 0 0.70710678"), "p.pose", bones, 50.0);
    REQUIRE(recording.frames.size() == 2);
    CHECK(recording.frames[1].time_s == Approx(0.02));
    const Hand& straight = recording.frames[0].hands.at(0);
    CHECK(distance(straight.palm, Vec3{0.01, 0, 0.3}) < 1e-12);
    CHECK(distance(straight.direction, Vec3{0, 0, 1}) < 1e-12);
    CHECK(distance(straight.normal, Vec3{0, -1, 0}) < 1e-12);
    // The index finger's bones are 5, 6 and 7; their joints are 10 mm before their centres, and the tip 15 mm behind.
    CHECK(distance(straight.fingers[1]->joints[0], Vec3{0.05, 0, 0.29}) < 1e-12);
    CHECK(distance(straight.fingers[1]->joints[1], Vec3{0.06, 0, 0.29}) < 1e-12);
    CHECK(distance(straight.fingers[1]->joints[2], Vec3{0.07, 0, 0.29}) < 1e-12);
    CHECK(distance(straight.fingers[1]->joints[3], Vec3{0.07, 0, 0.315}) < 1e-12);
    const Hand& turned = recording.frames[1].hands.at(0);
    CHECK(distance(turned.direction, Vec3{0, -1, 0}) < 1e-7);
    CHECK(distance(turned.normal, Vec3{0, 0, -1}) < 1e-7);
    CHECK(distance(turned.fingers[4]->joints[3], Vec3{0.16, -0.015, 0.3}) < 1e-7);
}

TEST_CASE("poses: mistakes are named by file and line", "[hand]") {
    const HandBones bones = bones_from_json(model_text(), "model.json");
    const auto refuses = [&](const std::string& text) {
        CAPTURE(text);
        REQUIRE_REFUSED(recording_from_poses(text, "p.pose", bones, 60.0));
    };
    refuses("");
    refuses("\n \n");
    refuses(line_of("0 0 0 1") + "1 2 3\n");
    refuses(line_of("0 0 0 nan"));
    refuses(line_of("0 0 zero 1"));
    refuses(line_of("0 0 0 0"));
    REQUIRE_REFUSED(recording_from_poses(line_of("0 0 0 1"), "p.pose", bones, 0.0));
    REQUIRE_REFUSED(bones_from_json("{}", "m.json"));
    REQUIRE_REFUSED(bones_from_json(R"({"controlcages": [], "joints": []})", "m.json"));
    REQUIRE_REFUSED(
        bones_from_json(model_text(R"({"verts": [[0,0,0],[1,0,0],[0,1,0],[1,1,0]], "faces": [[0,1,2]]})"), "m.json"));
    REQUIRE_REFUSED(
        bones_from_json(model_text(R"({"verts": [[0,0,0],[1,0,0],[0,1,0],[1,1,1]], "faces": [[0,1,9]]})"), "m.json"));
    REQUIRE_REFUSED(load_hands("hand.txt"));
}

TEST_CASE("poses: recorded poses have hands of one size that move by millimetres", "[hand]") {
    if (!std::filesystem::exists(recordings())) {
        WARN("not tested: no recordings in " << recordings());
        return;
    }
    const HandRecording recording = load_hands(recordings() / "animbank.pose");
    REQUIRE(recording.frames.size() == 2336);
    CHECK(load_hands(recordings() / "hand_data_example.pose", recordings() / "model_hand.json").frames.size() == 69);
    // The file's own numbers: a fingertip is as far from its bone's centre of mass as the model says.
    const HandBones bones =
        bones_from_json(read_file(recordings() / "model_hand.json"), (recordings() / "model_hand.json").string());
    std::istringstream numbers(read_file(recordings() / "animbank.pose"));
    std::array<std::array<double, 2>, 15> lengths;
    lengths.fill({INFINITY, 0.0});
    for (const HandFrame& frame : recording.frames) {
        const Hand& hand = frame.hands.at(0);
        std::array<double, 119> row{};
        for (double& number : row) numbers >> number;
        CHECK(std::abs(dot(hand.normal, hand.direction)) < 1e-5);
        for (std::size_t f = 0; f < 5; ++f) {
            const auto& joints = hand.fingers.at(f)->joints;
            for (std::size_t i = 0; i < 3; ++i) {
                const double length = distance(joints.at(i), joints.at(i + 1));
                auto& [least, most] = lengths.at(3 * f + i);
                least = std::min(least, length);
                most = std::max(most, length);
            }
            const std::size_t bone = 4 + 3 * f;
            const Vec3 centre{row.at(7 * bone), row.at(7 * bone + 1), row.at(7 * bone + 2)};
            const HandBones::Bone& model = bones.bones.at(bone);
            REQUIRE(distance(joints[3], centre) == Approx(distance(model.tip, model.centre)).epsilon(1e-5));
            REQUIRE(distance(joints[2], centre) == Approx(distance(model.joint, model.centre)).epsilon(1e-5));
        }
    }
    // Bones keep their lengths; the recording's joints are off by about a millimetre.
    for (const auto& [least, most] : lengths) CHECK(most - least < 6e-3);
}
