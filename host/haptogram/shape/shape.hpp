// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// A curve known exactly. `at` maps an arc length in [0, length] to a point; all in metres.
struct Curve {
    std::function<Vec3(double)> at;
    double length = 0.0;
    bool closed = false;
};

/// A surface of triangles, metres. Triangles of no area are allowed; a corner that is no vertex is not.
struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::string flaw{};  ///< what is wrong with the faces that it was cut from, as a sentence; empty for a sound one
};

/// Points without order, metres.
struct Cloud {
    std::vector<Vec3> points;
};

using Piece = std::variant<Curve, Mesh, Cloud>;

/// What a hand shall feel: all of its pieces together.
struct Shape {
    std::vector<Piece> pieces;
    std::vector<std::string> remarks{};  ///< on what a file's reader has left out, or what may be meant otherwise
    bool has_own_unit = false;           ///< which its file says
    std::string beside{};                ///< contents of other files that it was read from
};

}  // namespace haptogram
