// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// What a shape file holds, in the file's unit: vertices, and faces of three or more corners.
struct Polygons {
    std::vector<Vec3> vertices;
    std::optional<double> own_unit_m;                ///< when the file says itself what a 1 in it means
    std::string beside;                              ///< contents of other files that it is read from
    std::size_t unseen = 0;                          ///< points of NaN, which are no vertices
    std::vector<std::string> remarks;                ///< sentences on what was stepped over or may be meant otherwise
    std::vector<std::uint32_t> corners;              ///< indices into `vertices`, one face after another
    std::vector<std::size_t> face_ends;              ///< for each face, where in `corners` the next one begins
    std::vector<std::vector<std::uint32_t>> curves;  ///< indices into `vertices`; closed when the first is the last

    /// Ends the face whose corners were added last.
    void end_face() { face_ends.push_back(corners.size()); }
    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        corners.insert(corners.end(), {a, b, c});
        end_face();
    }
};

/// A mesh, its faces cut into triangles; or curves, when there are no faces; or the vertices as a cloud, when there is
/// neither. A face of n corners becomes n - 2 triangles, also when it is concave. A cloud loses what depth cameras
/// write for pixels that they have not seen: three or more points in one place, apart from all others, each of which is
/// there once.
/// @param name  of the file, for messages
/// @throws Error{bad_input} for no vertices, for faces that have no area, and for a curve without length
[[nodiscard]] Shape as_shape(Polygons polygons, const std::string& name);

/// Takes three coordinates off the front of a line's rest. @throws Error{bad_input} with `where`
[[nodiscard]] Vec3 take_point(std::string_view& rest, const std::string& where);

// Each of these reads a whole file of one format, to its last byte, in the file's unit.
// `name` is what messages call the file.
// They throw Error{bad_input} that names the file, the line or record, what was found and what was expected.

[[nodiscard]] Polygons read_ply(std::string_view content, const std::string& name);
[[nodiscard]] Polygons read_obj(std::string_view content, const std::string& name);
[[nodiscard]] Polygons read_stl(std::string_view content, const std::string& name);

/// Rows of columns, with white space, commas, semicolons or tabs between them, as the first row has them. The first row
/// may name the columns, as x, x_mm or Points:0 and so on; otherwise x, y and z come first. A line with one number
/// before the rows counts them. Behind semicolons a number may have a decimal comma. Further columns are ignored.
/// @param tabs  part columns, also when one is empty, instead of being white space
[[nodiscard]] Polygons read_rows(std::string_view content, const std::string& name, bool tabs);

}  // namespace haptogram
