// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/scattering/shells.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/readers.hpp"

namespace haptogram::scattering {

/// A rigid body: the path of a closed mesh, or the name of a built-in one.
struct BodySource {
    std::string name;                  ///< "sphere", "finger", or a file
    double metres_per_unit = 1e-3;     ///< of a file
    std::optional<double> radius_m{};  ///< of a built-in one; 8 mm
    std::optional<double> length_m{};  ///< of the finger, which lies along z before it is turned; 50 mm
    std::optional<double> edge_m{};    ///< of a built-in one's triangles; an eighth of the wavelength
    Placement placement{};
    ShapeReaders readers{};  ///< of formats that the core does not read
};
[[nodiscard]] bool is_built_in_body(std::string_view name);

/// @throws Error{bad_argument} for measures that make no sense or do not belong to this body, Error{bad_input} naming
/// the file, for one that cannot be read, is open or is turned inside out
[[nodiscard]] Body open_body(const BodySource& source, double wavelength_m);

/// What plays at the body: sets of foci in turn, on an array or a rig.
struct ScatterSource {
    BodySource body;
    std::vector<Vec3> foci;            ///< exact phases for one after the other, for equal times; or
    std::string path;                  ///< a path file; or
    std::optional<Vec3> plane_wave{};  ///< a plane wave of 1 Pa that travels in this direction, from no array
    std::optional<Vec3>
        ring{};             ///< or ten foci in turn around the built-in finger, where a surface through here cuts it
    Vec3 inward{0, 0, -1};  ///< of the ring: into the object whose surface that is
    bool weighed = false;   ///< of the ring: with the amplitudes that `live` gives it (hand/ring.hpp)
    std::string array = "tile-10x10";
    std::string rig;              ///< instead of the array
    bool foci_inside = false;     ///< foci inside of the body are meant, and no mistake
    bool flat_estimate = false;   ///< also the estimate of acoustics/skin_force.hpp, for comparison
    double least_elements = 6.0;  ///< triangles a wavelength, along the mean edge
};

/// One set of foci.
struct ScatteredStep {
    std::vector<Focus> foci;
    double share = 0.0;       ///< of the time
    double highest_pa = 0.0;  ///< radiation pressure
    Vec3 highest_at;
    Vec3 force_n;
};

/// Of a ring: how alike its foci's highest radiation pressures are, and how far each lies from its focus.
struct RingEvenness {
    std::size_t foci = 0;  ///< that sound
    double uneven = 0.0;   ///< the most over the least
    double farthest_m = 0.0;
};

/// What a body's skin gets.
struct Scattered {
    Array array;
    Body body;
    std::string title;           ///< in words
    bool is_plane_wave = false;  ///< from no array
    std::vector<ScatteredStep> steps;
    std::vector<float> rms_pressure;  ///< Pa, root of the mean square over time, one a triangle
    std::vector<float> radiation;     ///< Pa, mean over time, inwards
    std::vector<float> flat;          ///< the same as if each triangle were a patch of large flat skin; only on request
    std::size_t highest = 0;          ///< the triangle with the largest radiation pressure
    Vec3 force_n;                     ///< mean over time
    double resting = 0.0;             ///< share of the time in which nothing plays
    std::size_t rounds = 0;           ///< of the iteration; 0 when the matrix was taken apart instead
    double residual = 0.0;            ///< of the linear equations, relative
    double pattern_error = 0.0;       ///< of the transducers' directivity, of the amplitude on the axis
    std::optional<RingEvenness> ring;  ///< when one was played

    [[nodiscard]] double elements_per_wavelength() const { return array.wavelength_m() / body.mean_edge(); }
};

/// By how much the sound pressure is off because of the mesh, over the whole skin (L2, relative): between these two for
/// smooth bodies whose wave number times radius is 2 to 10, by comparison with rigid spheres. It falls with the
/// square of the elements a wavelength.
struct ErrorRange {
    double low, high;
};
[[nodiscard]] ErrorRange mesh_error(double elements_per_wavelength);

/// The sound on a rigid body's skin by boundary elements (scattering/scatterer.hpp). Foci that the source plays are
/// those in free air: the body is in the way of their sound, and no drive makes up for it. Absorption is taken into
/// account on the way to the body.
/// @throws Error{bad_argument} when not just one of foci, path, plane wave and ring is given; Error{bad_input} as
/// open_body(), for triangles that are too large, for foci out of reach, or inside of the body, and for transducers
/// inside of it
[[nodiscard]] Scattered scatter(const ScatterSource& source, const Progress& progress = {});

/// The report as JSON text: forces in mN, lengths in mm.
[[nodiscard]] std::string to_json_text(const Scattered& scattered);
/// As CSV, a line a triangle.
[[nodiscard]] std::string to_csv(const Scattered& scattered);
/// As VTK PolyData for ParaView, in mm, with the values on the triangles.
[[nodiscard]] std::string to_vtp(const Scattered& scattered);

/// @throws Error{bad_argument} when a path's ending is none of .csv, .vtp and .png
void check_scattered_path(const std::string& path);
/// Writes it in the format that the path's ending names; standard output ("-") gets CSV. The picture shows the body
/// from the side that is pushed and from the other one; it is drawn by python3 with matplotlib.
/// @throws Error{bad_input} when it cannot be written
void write_scattered(const std::string& path, const Scattered& scattered);

}  // namespace haptogram::scattering
