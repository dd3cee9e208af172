// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <clocale>
#include <filesystem>
#include <fstream>
#include <set>

#include "../test_data.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/place.hpp"

using namespace haptogram;

namespace {

const std::filesystem::path data = std::filesystem::path(test_data()) / "shapes";

const std::vector<Vec3> corners{from_mm(0, 0, 0), from_mm(10, 0, 0), from_mm(0, 20, 0), from_mm(0, 0, 40.5)};

Mesh load_mesh(const std::string& name) {
    const Shape shape = load_shape(data / name, millimetre);
    REQUIRE(shape.pieces.size() == 1);
    REQUIRE(std::holds_alternative<Mesh>(shape.pieces.front()));
    return std::get<Mesh>(shape.pieces.front());
}

Cloud load_cloud(const std::filesystem::path& path, double unit = millimetre) {
    const Shape shape = load_shape(path, unit);
    REQUIRE(shape.pieces.size() == 1);
    REQUIRE(std::holds_alternative<Cloud>(shape.pieces.front()));
    return std::get<Cloud>(shape.pieces.front());
}

std::size_t nearest_corner(Vec3 p) {
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (distance(p, corners[i]) < 1e-8) return i;
    FAIL("no corner is at " << p.x << ' ' << p.y << ' ' << p.z);
    return 0;
}

double area(const Mesh& mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += 0.5 * norm(cross(mesh.vertices.at(b) - mesh.vertices.at(a), mesh.vertices.at(c) - mesh.vertices.at(a)));
    return sum;
}

}  // namespace

TEST_CASE("meshes of other programs load with every face", "[shape][import]") {
    const std::string name =
        GENERATE("trimesh_ascii.ply", "trimesh_little.ply", "plyfile_ascii.ply", "plyfile_little.ply",
                 "plyfile_big.ply", "meshio_little.ply", "trimesh.obj", "meshio.obj", "trimesh_binary.stl",
                 "trimesh_ascii.stl", "meshio_binary.stl", "meshio_ascii.stl");
    CAPTURE(name);
    const Mesh mesh = load_mesh(name);
    std::multiset<std::set<std::size_t>> faces;
    for (const auto& triangle : mesh.triangles) {
        std::set<std::size_t> face;
        for (const auto corner : triangle) face.insert(nearest_corner(mesh.vertices.at(corner)));
        faces.insert(face);
    }
    CHECK(faces == std::multiset<std::set<std::size_t>>{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}});
}

TEST_CASE("clouds of other programs and hands load point by point", "[shape][import]") {
    const std::string name =
        GENERATE("trimesh_cloud.ply", "plyfile_cloud_ascii.ply", "plyfile_cloud_little.ply", "plyfile_cloud_big.ply",
                 "trimesh_cloud.xyz", "numpy_colours.xyz", "numpy_header.csv", "numpy_semicolon.csv",
                 "by_hand/points.obj", "by_hand/quoted.csv", "by_hand/tabs.csv");
    CAPTURE(name);
    const Cloud cloud = load_cloud(data / name);
    REQUIRE(cloud.points.size() == corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) CHECK(nearest_corner(cloud.points[i]) == i);
}

TEST_CASE("the unit of a file is what the caller says", "[shape][import]") {
    CHECK(load_cloud(data / "by_hand/tabs.csv", 1.0).points.back() == Vec3{0, 0, 40.5});
    CHECK(load_cloud(data / "by_hand/tabs.csv", 0.01).points.back().z == Approx(0.405).epsilon(1e-15));
}

TEST_CASE("polygons become triangles that cover them, also concave ones", "[shape][import]") {
    const Mesh mesh = load_mesh("by_hand/polygons.obj");
    CHECK(mesh.triangles.size() == 5);
    CHECK(area(mesh) == Approx((2.5 + 4.0) * 1e-6).epsilon(1e-6));  // the fan of the concave polygon would be 3.5
}

TEST_CASE("several solids of a file become one mesh", "[shape][import]") {
    const Mesh mesh = load_mesh("by_hand/two_solids.stl");
    CHECK(mesh.triangles.size() == 2);
    CHECK(area(mesh) == Approx(100.5e-6).epsilon(1e-6));
}

TEST_CASE("binary PLY data may begin with any byte", "[shape][import]") {
    // Assimp takes a line feed there for part of the header.
    const auto path = std::filesystem::temp_directory_path() / "haptogram_first_byte.ply";
    const unsigned first = GENERATE(range(0U, 256U));
    const std::string lines = GENERATE("\n", "\r\n");
    std::string text = "ply" + lines + "format binary_big_endian 1.0" + lines + "element vertex 2" + lines;
    for (const char* const axis : {"x", "y", "z"}) text += "property uchar " + std::string(axis) + lines;
    text += "end_header" + lines;
    for (const unsigned byte : {first, 2U, 3U, 10U, 13U, 32U}) text += static_cast<char>(byte);
    std::ofstream(path, std::ios::binary) << text;
    CHECK(load_cloud(path, 1.0).points == std::vector<Vec3>{{static_cast<double>(first), 2, 3}, {10, 13, 32}});
    std::filesystem::remove(path);
}

TEST_CASE("numbers mean the same in a locale with a decimal comma", "[shape][import]") {
    const std::string before = std::setlocale(LC_NUMERIC, nullptr);
    const bool found =
        std::setlocale(LC_NUMERIC, "de_DE.UTF-8") != nullptr || std::setlocale(LC_NUMERIC, "fr_FR.UTF-8") != nullptr;
    if (!found) WARN("not tested: no locale with a decimal comma is installed here");
    for (const char* const name :
         {"plyfile_cloud_ascii.ply", "trimesh_cloud.xyz", "numpy_semicolon.csv", "by_hand/points.obj"})
        CHECK(load_cloud(data / name).points.back().z == Approx(0.0405).epsilon(1e-7));
    CHECK(area(load_mesh("trimesh_ascii.stl")) == Approx(area(load_mesh("trimesh_binary.stl"))).epsilon(1e-6));
    std::setlocale(LC_NUMERIC, before.c_str());
}
