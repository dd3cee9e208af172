// SPDX-License-Identifier: Apache-2.0
// Forms that the formats allow and few programs write.
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/formats/readers.hpp"
#include "haptogram/shape/import.hpp"

using namespace haptogram;

namespace {

const std::filesystem::path data = std::filesystem::path(test_data()) / "shapes";

Piece read(const std::string& content, ShapeFormat format, double unit = 1.0) {
    const Shape shape = load_shape({content, "a shape", false}, format, unit, formats::readers());
    REQUIRE(shape.pieces.size() == 1);
    return shape.pieces.front();
}

Mesh read_mesh(const std::string& content, ShapeFormat format, double unit = 1.0) {
    const Piece piece = read(content, format, unit);
    REQUIRE(std::holds_alternative<Mesh>(piece));
    return std::get<Mesh>(piece);
}

Error refusal(const std::string& content, ShapeFormat format) {
    try {
        (void)load_shape({content, "a shape", false}, format, 1.0, formats::readers());
    } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::bad_input);
        CHECK_REFUSAL(heard::Refusal(error));
        return error;
    }
    FAIL("no error for " << content);
    return bad_input("", "");
}

double area(const Mesh& mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += 0.5 * norm(cross(mesh.vertices.at(b) - mesh.vertices.at(a), mesh.vertices.at(c) - mesh.vertices.at(a)));
    return sum;
}

using Faces = std::multiset<std::set<std::uint32_t>>;

Faces faces_of(const Mesh& mesh) {
    Faces faces;
    for (const auto& triangle : mesh.triangles) faces.insert({triangle.begin(), triangle.end()});
    return faces;
}

const Faces tetrahedron{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};

/// A header with `lines` between the format and its end.
std::string header(const std::string& lines, const std::string& format = "ascii") {
    return "ply\nformat " + format + " 1.0\n" + lines + "end_header\n";
}

const std::string three_vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string one_face = "element face 1\nproperty list uchar int vertex_indices\n";
const std::vector<Vec3> corners{{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}};

std::string all_replaced(std::string text, const std::string& what, const std::string& with) {
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
        text.replace(at, what.size(), with);
    return text;
}

}  // namespace

TEST_CASE("odd forms of PLY that another program wrote", "[shape][forms]") {
    const std::string form =
        GENERATE("faces_first", "integers", "float_corners", "more_elements", "strips", "many_strips");
    const std::string order = GENERATE("ascii", "little", "big");
    CAPTURE(form, order);
    const bool halves = form == "integers";  // of a millimetre
    const Mesh mesh = read_mesh(read_file(data / ("odd_" + form + "_" + order + ".ply")), ShapeFormat::ply,
                                halves ? 0.5 * millimetre : millimetre);
    CHECK(mesh.vertices ==
          std::vector<Vec3>{from_mm(0, 0, 0), from_mm(10, 0, 0), from_mm(0, 20, 0), from_mm(0, 0, 40.5)});
    if (form == "many_strips")
        CHECK(faces_of(mesh) == Faces{{0, 1, 2}, {1, 2, 3}, {0, 2, 3}});
    else
        CHECK(faces_of(mesh) == tetrahedron);
}

TEST_CASE("coordinates of PLY may have any scalar type", "[shape][forms]") {
    const auto [type, bytes] =
        GENERATE(table<std::string, std::string>({{"char", "\x05"},
                                                  {"int8", "\x05"},
                                                  {"uchar", "\x05"},
                                                  {"uint8", "\x05"},
                                                  {"short", std::string("\0\x05", 2)},
                                                  {"uint16", std::string("\0\x05", 2)},
                                                  {"int", std::string("\0\0\0\x05", 4)},
                                                  {"uint32", std::string("\0\0\0\x05", 4)},
                                                  {"float", std::string("\x40\xa0\0\0", 4)},
                                                  {"float64", std::string("\x40\x14\0\0\0\0\0\0", 8)}}));
    CAPTURE(type);
    const std::string lines =
        "element vertex 2\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
    const Cloud cloud{{{5, 5, 5}, {5, 5, 5}}};
    std::string body;
    for (int i = 0; i < 6; ++i) body += bytes;
    CHECK(std::get<Cloud>(read(header(lines, "binary_big_endian") + body, ShapeFormat::ply)).points == cloud.points);
    CHECK(std::get<Cloud>(read(header(lines) + "5 5 5\n5 5 5\n", ShapeFormat::ply)).points == cloud.points);
    CHECK_REFUSAL(heard::Refusal(refusal(header(lines, "binary_big_endian") + body.substr(1), ShapeFormat::ply)));
}

TEST_CASE("PLY keeps double precision", "[shape][forms]") {
    const double exact = 0.1234567890123456;
    const std::string lines = "element vertex 1\nproperty double x\nproperty double y\nproperty double z\n";
    CHECK(std::get<Cloud>(read(header(lines) + "0.1234567890123456 1 2", ShapeFormat::ply)).points.at(0).x == exact);
    std::string body(24, '\0');
    const auto raw = std::bit_cast<std::array<char, 8>>(exact);
    std::copy(raw.begin(), raw.end(), body.begin());
    if constexpr (std::endian::native == std::endian::little)
        CHECK(std::get<Cloud>(read(header(lines, "binary_little_endian") + body, ShapeFormat::ply)).points.at(0).x ==
              exact);
}

TEST_CASE("numbers of a text PLY may share lines and fill several", "[shape][forms]") {
    const std::string body =
        GENERATE("1 2 3\n4 5 6\n7 8 9.5\n", "1 2 3 4 5 6 7 8 9.5\n", "1\n2\n3\n4\n5\n6\n7\n8\n9.5",
                 "1 2\n3\n4 5 6 7 8 9.5", "1 2 3\t4 5 6 \n\n 7\n\n8 9.5\n\n", "1\r\n2 3\r\n4 5 6 7 8 9.5\r\n");
    CAPTURE(body);
    CHECK(std::get<Cloud>(read(header(three_vertices) + body, ShapeFormat::ply)).points == corners);
    const Mesh mesh = read_mesh(header(one_face + three_vertices) + "3 0\n1 2\n" + body, ShapeFormat::ply);
    CHECK(mesh.vertices == corners);
    CHECK(faces_of(mesh) == Faces{{0, 1, 2}});
}

TEST_CASE("a number that is lost or added does not shift the others", "[shape][forms]") {
    const std::string body =
        GENERATE(as<std::string>{}, "1 2 3\n4 5\n6 7 8 9.5\n",  // this makes up for the number that is absent
                 "1 2 3\n4 5 6 7\n8 9.5\n",                     // and this for the one that is too many
                 "1 2 3 4\n5 6\n7 8 9.5\n",                     // a line break inside the second of two
                 "1\n2\n3 4\n5 6\n7 8 9.5\n",                   // an element of several lines ends in a line
                 "1 2 3\n4 5 red\n7 8 9.5\n",                   //
                 "1 2 3\n4 5 6 red\n7 8 9.5\n",                 //
                 "1 2 3 4 5 6 7 8\n",                           //
                 "1\n2\n3\n4\n5\n6\n7\n8\n");
    CAPTURE(body);
    CHECK_REFUSAL(heard::Refusal(refusal(header(three_vertices) + body, ShapeFormat::ply)));
}

TEST_CASE("a PLY header may hold comments anywhere, and end its lines in three ways", "[shape][forms]") {
    const std::string line_end = GENERATE("\n", "\r\n", "\r", " \n");
    CAPTURE(line_end);
    const std::string text =
        "ply\ncomment before the format\nformat binary_little_endian 1.0\nobj_info num_cols 3\ncomment\nelement vertex "
        "3\ncomment element face 9\nproperty uchar x\nobj_info property uchar w\nproperty uchar y\nproperty uchar "
        "z\ncomment end_header of the vertices\nelement face 1\ncomment property list uchar int "
        "vertex_indices\nproperty list uchar uchar vertex_index\ncomment end_header\nend_header\n";
    const std::string body("\x01\x02\x03\x04\n\r\x07\x08\x09\x03\x00\x01\x02", 13);
    const Mesh mesh = read_mesh(all_replaced(text, "\n", line_end) + body, ShapeFormat::ply);
    CHECK(mesh.vertices == std::vector<Vec3>{{1, 2, 3}, {4, 10, 13}, {7, 8, 9}});
    CHECK(faces_of(mesh) == Faces{{0, 1, 2}});
    const Piece cloud =
        read(all_replaced(header(three_vertices) + "1 2 3\n4 5 6\n7 8 9.5\n", "\n", line_end), ShapeFormat::ply);
    CHECK(std::get<Cloud>(cloud).points == corners);
    CHECK_REFUSAL(heard::Refusal(
        refusal(all_replaced(header(three_vertices) + "1 2 3\n4 x 6\n7 8 9.5\n", "\n", line_end), ShapeFormat::ply)));
}

TEST_CASE("strips are wound alike, and joins in them are no surface", "[shape][forms]") {
    const std::string lines =
        "element vertex 6\nproperty int x\nproperty int y\nproperty int z\nelement tristrips 1\nproperty list int int "
        "vertex_indices\n";
    const std::string body = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n";
    const Mesh mesh = read_mesh(header(lines) + body + "11 -1 0 1 2 2 3 3 4 5 -1 -1\n", ShapeFormat::ply);
    CHECK(faces_of(mesh) == Faces{{0, 1, 2}, {3, 4, 5}});
    const Mesh grid = read_mesh(header(lines) + body + "6 0 1 2 3 4 5\n", ShapeFormat::ply);
    CHECK(area(grid) == 2.0);
    for (const auto& [a, b, c] : grid.triangles)
        CHECK(cross(grid.vertices[b] - grid.vertices[a], grid.vertices[c] - grid.vertices[a]) == Vec3{0, 0, 1});
    const std::string strip = GENERATE(as<std::string>{}, "5 0 1 2 -1 3", "5 0 1 -1 2 3", "4 0 1 2 6", "4 0 1 2 -2",
                                       "4 0 1 2 1.5", "-1", "4 0 1 2");
    CHECK_REFUSAL(heard::Refusal(refusal(header(lines) + body + strip, ShapeFormat::ply)));
}

TEST_CASE("a PLY header that does not say what is what is refused", "[shape][forms]") {
    const std::string lines =
        GENERATE(as<std::string>{}, three_vertices + "property float x\n",
                 "element vertex 3\nproperty list uchar float x\nproperty float y\nproperty float z\n",
                 three_vertices + "element face 1\nproperty list uchar int corners\n",
                 three_vertices + "element face 1\nproperty int vertex_indices\n",
                 three_vertices + one_face + "property list uchar int vertex_index\n",
                 three_vertices + "element tristrips 1\nproperty int length\n", three_vertices + three_vertices,
                 three_vertices + "property int64 time\n", three_vertices + "property list uchar list int w\n",
                 "property float x\n" + three_vertices);
    CAPTURE(lines);
    CHECK_REFUSAL(heard::Refusal(refusal(header(lines) + "1 2 3\n4 5 6\n7 8 9\n3 0 1 2\n", ShapeFormat::ply)));
    CHECK_REFUSAL(heard::Refusal(refusal(header(one_face) + "3 0 1 2\n", ShapeFormat::ply)));
}

TEST_CASE("statements of OBJ may go on in the next line", "[shape][forms]") {
    const std::string line_end = GENERATE("\n", "\r\n");
    const std::string text =
        "# a comment ends with its line \\\nv 0 \\\n0 0\nv 2 0 0\nv 2 2 0\\\n\nv 0 2 0 # not here \\\ng one \\\n "
        "two\nf "
        "1 2 \\\n  3 \\\n 4 # four\n";
    const Mesh mesh = read_mesh(all_replaced(text, "\n", line_end), ShapeFormat::obj);
    CHECK(mesh.vertices == std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
    CHECK(area(mesh) == 4.0);
}

TEST_CASE("a line of OBJ that goes on wrongly is refused by its number", "[shape][forms]") {
    const std::string square = "v 0 0 0\nv 2 0 0\nv 2 2 0\n";
    const std::string text = GENERATE(as<std::string>{}, "f 1 2 \\", "f 1 2 \\\n", "f 1 2 \\\n\n", "f 1 \\\n2 9\n",
                                      "mtllib C:\\\nv 1 1 1\nf 1 2 3\n", "f 1 2 3\\\nf 1 2 3\n", "f 1 2 \\ 3\n");
    CAPTURE(text);
    CHECK_REFUSAL(heard::Refusal(refusal(square + text, ShapeFormat::obj)));
}

TEST_CASE("polygons with holes, straight corners and many corners are cut rightly", "[shape][forms]") {
    const auto [text, triangles, expected] = GENERATE(table<std::string, std::size_t, double>({
        // A square of 4 with a square hole of 2, joined by a cut from corner 1 to corner 5.
        {"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\nf 1 2 3 4 1 5 6 7 8 5\n", 8, 12.0},
        // The same, standing upright and wound the other way.
        {"v 0 0 0\nv 0 0 4\nv 0 4 4\nv 0 4 0\nv 0 1 1\nv 0 3 1\nv 0 3 3\nv 0 1 3\nf 5 8 7 6 5 1 4 3 2 1\n", 8, 12.0},
        {"v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 2 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n", 4, 4.0},  // straight corners
        {"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 1 2 3 3 4\n", 4, 4.0},                    // corners twice
        {"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\n", 2, 4.0},                        // an arrow head
        // A comb.
        {"v 0 0 0\nv 5 0 0\nv 5 3 0\nv 4 3 0\nv 4 1 0\nv 3 1 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"
         "f 1 2 3 4 5 6 7 8 9 10 11 12\n",
         10, 11.0},
    }));
    CAPTURE(text);
    const Mesh mesh = read_mesh(text, ShapeFormat::obj);
    CHECK(mesh.triangles.size() == triangles);
    CHECK(area(mesh) == Approx(expected).epsilon(1e-12));
}

TEST_CASE("a polygon that crosses itself is cut as it is, and told by its number", "[shape][forms]") {
    const std::string square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n";
    const auto [crossing, corners] = GENERATE(table<std::string, std::size_t>({
        {"f 1 3 2 4\n", 4},                                                      // a bow tie
        {"v 1 5 0\nv 3 0 0\nv 0 3 0\nv 3 3 0\nf 1 6 7 5 8 3\n", 6},              // no ear is left
        {"v 0 10 0\nv 6 -8 0\nv -9 3 0\nv 9 3 0\nv -6 -8 0\nf 5 6 7 8 9\n", 5},  // a star
    }));
    const Mesh mesh = read_mesh(square + crossing, ShapeFormat::obj);
    CHECK_SAID(mesh.flaw);
    CHECK(mesh.triangles.size() == 2 + corners - 2);
    CHECK(read_mesh(square, ShapeFormat::obj).flaw.empty());
}

TEST_CASE("a content without a name tells its format", "[shape][forms]") {
    for (const char* const name :
         {"trimesh_little.ply", "trimesh.obj", "trimesh_binary.stl", "trimesh_cloud.xyz", "numpy_header.csv"}) {
        CAPTURE(name);
        CHECK(shape_format(read_file(data / name), "-") == shape_format(name));
    }
    CHECK_REFUSED(shape_format("a shopping list", "-"));
    CHECK_REFUSAL(heard::Refusal(refusal("\n<!DOCTYPE html>\n", ShapeFormat::stl)));
    CHECK_REFUSED(load_shape({"# .PCD v0.7\n", "cloud.pcd", false}, ShapeFormat::pcd, 1.0));  // read by an extra
}

TEST_CASE("a shape with y upwards is stood up", "[shape][forms]") {
    CHECK(has_y_up_by_habit("# Blender v2.80 (sub 75) OBJ File\nv 0 0 0\n"));
    CHECK_FALSE(has_y_up_by_habit("# by hand\no Blender\nv 0 0 0\n"));
    const Shape lying = load_shape({"v 1 2 3\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a shape", false}, ShapeFormat::obj, 1.0);
    CHECK(std::get<Mesh>(stood_up(lying).pieces.front()).vertices.front() == Vec3{1, -3, 2});
}

TEST_CASE("shapes are read from memory under a name of the caller's", "[shape][forms]") {
    CHECK(shape_format("Cat.PLY") == ShapeFormat::ply);
    CHECK(shape_format("folder.csv/dog.obj") == ShapeFormat::obj);
    for (const char* const name : {"cat", "cat.step", "", ".ply"}) CHECK_THROWS_AS(shape_format(name), Error);
    for (const char* const name :
         {"trimesh_little.ply", "trimesh.obj", "trimesh_binary.stl", "trimesh_cloud.xyz", "numpy_header.csv"}) {
        CAPTURE(name);
        const Shape here = load_shape({read_file(data / name), "an upload", false}, shape_format(name), millimetre);
        const Shape there = load_shape(data / name, millimetre);
        REQUIRE(here.pieces.size() == 1);
        CHECK(here.pieces.front().index() == there.pieces.front().index());
        if (const auto* const mesh = std::get_if<Mesh>(&here.pieces.front())) {
            CHECK(mesh->vertices == std::get<Mesh>(there.pieces.front()).vertices);
            CHECK(mesh->triangles == std::get<Mesh>(there.pieces.front()).triangles);
        } else {
            CHECK(std::get<Cloud>(here.pieces.front()).points == std::get<Cloud>(there.pieces.front()).points);
        }
    }
    CHECK(refusal("", ShapeFormat::obj).where() == "a shape");
    CHECK(refusal("1 2 3\n1 2\n", ShapeFormat::xyz).where() == "a shape, line 2");
    for (const double unit : {0.0, -1e-3, std::numeric_limits<double>::infinity()}) {
        try {
            (void)load_shape({"1 2 3\n", "a shape", false}, ShapeFormat::xyz, unit);
            FAIL("no error for " << unit);
        } catch (const Error& error) {
            CHECK(error.code() == ErrorCode::bad_argument);
            CHECK(error.where() == "metres_per_unit");
        }
    }
}

namespace {

/// Rows of a ring of 60 points, 40 mm wide, at a height of 130, with something in front of each.
std::string ring(const std::string& in_front = "", bool numbered = false) {
    std::string rows;
    for (int i = 0; i < 60; ++i) {
        const double turn = 2.0 * 3.141592653589793 * i / 60.0;
        rows += in_front + (numbered ? std::to_string(i + 1) + " " : "") + std::to_string(20.0 * std::cos(turn)) + " " +
                std::to_string(20.0 * std::sin(turn)) + " 130\n";
    }
    return rows;
}

std::string times(int count, const std::string& row) {
    std::string rows;
    for (int i = 0; i < count; ++i) rows += row;
    return rows;
}

std::vector<Vec3> cloud_of(const std::string& content, ShapeFormat format) {
    return std::get<Cloud>(read(content, format)).points;
}

}  // namespace

TEST_CASE("pixels that a depth camera has not seen are no points", "[shape][forms][seen]") {
    const std::vector<Vec3> clean = cloud_of(ring(), ShapeFormat::xyz);
    REQUIRE(clean.size() == 60);
    for (const std::string& unseen : {times(200, "0 0 0\n"), times(5, "3 4 -700\n"), times(7, "nan NaN nan\n")}) {
        CAPTURE(unseen);
        const Shape shape = load_shape({unseen + ring(), "a scan", false}, ShapeFormat::xyz, 1.0);
        CHECK(std::get<Cloud>(shape.pieces.front()).points == clean);
        REQUIRE(shape.remarks.size() == 1);
        CHECK_SAID(shape.remarks.front());
    }
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 63\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    CHECK(cloud_of(header + times(3, "nan nan nan\n") + ring(), ShapeFormat::ply) == clean);
    CHECK(cloud_of("x,y,z\nnan,nan,nan\n1,2,3\n", ShapeFormat::csv).size() == 1);
    // Two may be meant, a point that others surround is no heap apart, and a shape has each point several times.
    CHECK(cloud_of(ring() + times(2, "0 0 0\n"), ShapeFormat::xyz).size() == 62);
    CHECK(cloud_of(ring() + times(9, "20.5 0 130\n"), ShapeFormat::xyz).size() == 69);
    CHECK(cloud_of(ring() + ring() + times(9, "0 0 0\n"), ShapeFormat::xyz).size() == 129);
    refusal(times(4, "nan nan nan\n"), ShapeFormat::xyz);
    refusal(ring() + "nan 1 2\n", ShapeFormat::xyz);
    refusal(header + times(3, "nan nan 130\n") + ring(), ShapeFormat::ply);
}

TEST_CASE("a first column that counts is told of", "[shape][forms][rows]") {
    const Shape counted = load_shape({ring("", true), "a cloud", false}, ShapeFormat::xyz, 1.0);
    REQUIRE(counted.remarks.size() == 1);
    CHECK_SAID(counted.remarks.front());
    const Shape named = load_shape({"n x y z\n" + ring("", true), "a cloud", false}, ShapeFormat::xyz, 1.0);
    CHECK(named.remarks.empty());
    CHECK(std::get<Cloud>(named.pieces.front()).points == cloud_of(ring(), ShapeFormat::xyz));
    CHECK(load_shape({"1 0 130\n2 0 130\n3 0 130\n", "a line", false}, ShapeFormat::xyz, 1.0).remarks.empty());
    CHECK(load_shape({"1 0 130 7\n2 0 130 7\n4 0 130 7\n", "a line", false}, ShapeFormat::xyz, 1.0).remarks.empty());
}

TEST_CASE("rows as spreadsheets and other programs write them", "[shape][forms][rows]") {
    const std::vector<Vec3> points{{1.5, -2.0, 3.0}, {4.0, 5.0, 6.25}};
    for (const char* const csv :
         {"sep=;\nx;y;z\n1.5;-2;3\n4;5;6.25\n", "1,5;-2;3\n4;5;6,25\n",
          "\"Points:2\",\"Points:0\",\"Points:1\"\n3,1.5,-2\n6.25,4,5\n", "//X,Y,Z\n1.5,-2,3\n4,5,6.25\n",
          "2\n1.5,-2,3\n4,5,6.25\n", "x y z\n1.5 -2 3\n4 5 6.25\n",
          "\xEF\xBB\xBF"
          "x;y;z\n1,5;-2;3\n4;5;6,25\n"}) {
        CAPTURE(csv);
        CHECK(cloud_of(csv, ShapeFormat::csv) == points);
    }
    for (const char* const xyz : {"1.5, -2, 3\n4, 5, 6.25\n", "1.5,-2,3\n4,5,6.25\n", "2\n1.5 -2 3\n4 5 6.25\n",
                                  "X Y Z\n1.5 -2 3\n4 5 6.25\n", "//X Y Z Scalar_field\n1.5 -2 3 9\n4 5 6.25 9\n",
                                  "// made by a program\n1.5 -2 3\n4 5 6.25\n", "1.5\t-2\t3 # one\n4\t5\t6.25\n"}) {
        CAPTURE(xyz);
        CHECK(cloud_of(xyz, ShapeFormat::xyz) == points);
    }
    const std::string in_mm = "x_mm,y_mm,z_mm\n1.5,-2,3\n4,5,6.25\n";
    const Shape named = load_shape({in_mm, "named", false}, ShapeFormat::csv, millimetre);
    CHECK(std::get<Cloud>(named.pieces.front()).points.front() == millimetre * points.front());
    refusal(in_mm, ShapeFormat::csv);  // as metres
    refusal("3\n1 2 3\n4 5 6\n", ShapeFormat::xyz);
    refusal("1,5 2,5 3,5\n", ShapeFormat::xyz);
    refusal("1.234,5;2;3\n", ShapeFormat::csv);
    refusal("1,234,567;2;3\n", ShapeFormat::csv);
    refusal("time,height\n1,2\n", ShapeFormat::csv);
}

TEST_CASE("statements of OBJ that change nothing, a byte order mark, and faces before vertices",
          "[shape][forms][obj]") {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", face = "f 1 2 3 4\n";
    for (const std::string& more : {std::string("lod 2\nbevel on\nc_interp off\nd_interp on\nusemap a\nmaplib b\n"
                                                "shadow_obj c\ntrace_obj d\np 1 2\n"),
                                    std::string("\xEF\xBB\xBF")}) {
        CAPTURE(more);
        CHECK(area(read_mesh(more + vertices + face, ShapeFormat::obj)) == Approx(1.0));
    }
    CHECK(area(read_mesh(face + vertices, ShapeFormat::obj)) == Approx(1.0));
    CHECK(area(read_mesh(vertices + "f -4 -3 -2 -1\nv 9 9 9\n", ShapeFormat::obj)) == Approx(1.0));
    refusal("f 1 2 5\n" + vertices, ShapeFormat::obj);
    refusal("f -1 -2 -3\n" + vertices, ShapeFormat::obj);
    refusal(vertices + "curv 0 1 1 2\n", ShapeFormat::obj);
    const std::string stl =
        "\xEF\xBB\xBF"
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
        "0\nendloop\nendfacet\nendsolid a\n";
    CHECK(area(read_mesh(stl, ShapeFormat::stl)) == Approx(0.5));
}

TEST_CASE("lines of OBJ are curves, and beside faces left out with a word", "[shape][forms][obj]") {
    const std::string vertices = "v 0 0 0\nv 3 0 0\nv 3 4 0\n";
    const Curve outline = std::get<Curve>(read(vertices + "l 1 2 3 1\n", ShapeFormat::obj));
    CHECK(outline.closed);
    CHECK(outline.length == Approx(12.0));
    CHECK(distance(outline.at(5.0), {3.0, 2.0, 0.0}) < 1e-12);
    const Shape open = load_shape({vertices + "l 1/1 2/2\nl -1 -2\n", "lines", false}, ShapeFormat::obj, millimetre);
    REQUIRE(open.pieces.size() == 2);
    CHECK(std::get<Curve>(open.pieces[1]).length == Approx(4e-3));
    CHECK_FALSE(std::get<Curve>(open.pieces[0]).closed);
    CHECK(distance(std::get<Curve>(stood_up(open).pieces[1]).at(0.0), {3e-3, 0.0, 4e-3}) < 1e-12);
    const Shape beside = load_shape({vertices + "f 1 2 3\nl 1 3\n", "a face", false}, ShapeFormat::obj, 1.0);
    CHECK(std::get<Mesh>(beside.pieces.front()).triangles.size() == 1);
    REQUIRE(beside.remarks.size() == 1);
    CHECK_SAID(beside.remarks.front());
    refusal(vertices + "l 1\n", ShapeFormat::obj);
    refusal(vertices + "l 2 2\n", ShapeFormat::obj);
    refusal(vertices + "l 1 4\n", ShapeFormat::obj);
}

TEST_CASE("OFF has vertices and faces, or vertices alone", "[shape][forms][off]") {
    const std::string square = "4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    for (const std::string& text :
         {"OFF\n" + square, "# by a program\nOFF " + square,
          std::string("COFF\n\n4 1 0 # four\n0 0 0 9 9 9 1\n1 0 0 9 9 9 1\n1 1 0 9 9 9 1\n0 1 0 9 9 9 1\n"
                      "4 0 1 2 3 0.5 0.5 0.5\n\n")})
        CHECK(area(read_mesh(text, ShapeFormat::off)) == Approx(1.0));
    CHECK(cloud_of("OFF\n1 0 0\n1.5 2 3\n", ShapeFormat::off) == std::vector<Vec3>{{1.5, 2.0, 3.0}});
    CHECK(shape_format("OFF\n" + square, "-") == ShapeFormat::off);
    CHECK(has_shape_ending("Cat.OFF"));
    for (const char* const wrong :
         {"4OFF\n1 0 0\n1 2 3\n", "OFF\n", "OFF\n2 0 0\n1 2 3\n", "OFF\n1 1 0\n1 2 3\n", "OFF\n1 0 0\n1 2 3\n4 5 6\n",
          "OFF\n1 0 0\n1 2\n", "OFF\n1.5 0 0\n1 2 3\n", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
          "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "OFF\n0 0 0\n"})
        refusal(wrong, ShapeFormat::off);
}
