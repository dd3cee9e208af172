// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/schedule.hpp"

namespace haptogram {

/// How drives are found that make several foci at the same time. docs/references.md names the sources.
enum class Method {
    gauss_newton,       ///< weighted GS, and one Gauss-Newton step that makes the foci equal
    weighted_gs,        ///< GS whose weights grow for foci that are too weak (Di Leonardo et al. 2007)
    gs,                 ///< Gerchberg and Saxton 1972: phases of the foci and of the elements in turn
    gs_pat,             ///< the same between foci alone (Plasencia et al. 2020)
    superposition,      ///< sum of the drives for each focus alone
    distance_weighted,  ///< the same, each element's share times its distance (Fingers, III-C)
    inverse_transform,  ///< Fourier transform of the foci, on the drives for one focus in their middle (Hoshi eq. 9)
};

struct MethodName {
    Method method;
    const char* name;   ///< on command lines and in files
    const char* about;  ///< for help
};
inline constexpr MethodName method_names[] = {
    {Method::gauss_newton, "gauss-newton", "weighted GS and a Gauss-Newton step"},
    {Method::weighted_gs, "weighted-gs", "weighted Gerchberg-Saxton"},
    {Method::gs, "gs", "Gerchberg-Saxton"},
    {Method::gs_pat, "gs-pat", "Gerchberg-Saxton between foci alone"},
    {Method::superposition, "superposition", "sum of the drives for each focus"},
    {Method::distance_weighted, "distance-weighted", "the same, times the distance"},
    {Method::inverse_transform, "inverse-transform", "Fourier transform of the foci"},
};
[[nodiscard]] const char* name_of(Method method);
/// @throws Error{bad_argument} with `setting` in it, naming the methods that there are
[[nodiscard]] Method method_of(const std::string& name, const std::string& setting = "solver");

/// The meaning of one record: its foci, and how strong its pulses are.
struct RecordMeaning {
    std::vector<Focus> foci;         ///< their amplitudes are relative to each other
    double amplitude = 1.0;          ///< of the record's pulses, as a fraction of that of the timer's pulses: 0…1
    std::uint32_t dwell_cycles = 0;  ///< carrier periods that it lasts in one pass
};

/// The meaning of records of foci, from which the board computes phases and amplitudes.
struct FocusMeaning {
    /// Length of a channel's sum of foci at which its amplitude is full, which is that of the timer's pulses. A lone
    /// focus of amplitude 1 has a sum of length 1.
    double full = 1.0;
};

/// What an image means in the world, kept beside it as JSON: the array and the core it was compiled for, the timer, and
/// what each record makes. Lengths are millimetres in the file.
struct Manifest {
    Array array;
    Core core;
    Timer timer;
    std::vector<RecordMeaning> records;  ///< in the order of the image's places (image.hpp)
    std::optional<FocusMeaning> foci;    ///< given when all of them are focus records, whose indices begin behind the
                                         ///< core's RECORDS
    std::optional<SampledModulation> modulation;  ///< by the board
    Method solver = Method::gauss_newton;         ///< of records of several foci
    std::string quantise;      ///< device on whose segments all pulses lie (solve/segments.hpp); empty: none
    double rate_hz = 0.0;      ///< passes a second, as it came out
    Formation formation;       ///< of the slowest focus
    std::string input_sha256;  ///< of every input and setting that shaped the image
    std::string image_sha256;  ///< of the HEX file's bytes

    /// The index of the record at a place, counted from 0; and the place of an index, empty when there is none.
    [[nodiscard]] std::uint32_t index_of(std::size_t place) const;
    [[nodiscard]] std::optional<std::size_t> place_of(std::uint32_t index) const;
    /// Carrier periods after which everything that plays is as before: whole passes, and whole rounds of the board's
    /// modulation. 0 when the manifest does not say how long a pass is.
    [[nodiscard]] std::uint64_t repeat_periods() const;
    /// Every focal point, record by record; places where pressure is held down, of amplitude 0, are none.
    [[nodiscard]] std::vector<Vec3> points() const;
    /// Whether any record makes several foci at the same time, so that there was something to solve.
    [[nodiscard]] bool has_several_foci() const;
};

[[nodiscard]] std::string version();

[[nodiscard]] nlohmann::ordered_json to_json(const Manifest& manifest);
/// The file's text.
[[nodiscard]] std::string to_text(const Manifest& manifest);

/// @param where  names the file in messages
/// @throws Error{bad_input} for invalid JSON, and for missing or mistyped members, which it names
[[nodiscard]] Manifest manifest_from_json(std::string_view text, const std::string& where);

/// An image with its manifest, which was checked to belong to it.
struct Bundle {
    Image image;
    Manifest manifest;
    std::string hex;   ///< the image's file
    std::string name;  ///< of that file, for messages
};

/// The path of an image's manifest, unless another is given: beside the image, with the ending ".json".
[[nodiscard]] std::string manifest_path(const std::string& image);

/// Puts the two together. Everything that is made of an image and its manifest begins here, so that there is one rule:
/// the image would play, and the manifest has its hash and agrees with it in channels, clock, records, timer, pulses,
/// dwells, and in the channels that stay silent.
/// @param name           of the image, for messages
/// @param manifest_name  of the manifest, for messages
/// @throws Error{bad_input} naming what would not play, or the first disagreement
[[nodiscard]] Bundle bundle_of(std::string hex, Manifest manifest, const std::string& name,
                               const std::string& manifest_name);

/// Reads both files. @param manifest  empty for the one beside the image
[[nodiscard]] Bundle load_bundle(const std::string& image, const std::string& manifest = {});

/// What an image plays in one pass: the foci of each record, at the record's amplitude, for as long as it lasts.
[[nodiscard]] Path path_of(const Bundle& bundle);
/// The places of one pass, for speed and spacing, by add_places(): a step of silence has no foci.
[[nodiscard]] Path places_of(const Manifest& manifest, std::span<const SequenceEntry> pass);

}  // namespace haptogram
