// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/verbs/excitation.hpp"

namespace haptogram {

/// What a verb works on, as a user names it. Exactly one of `image`, `focus` and `pulses` is given.
struct Source {
    std::string image;                 ///< an image (.hex), a manifest alone (.json), a rig's manifest, which is its
                                       ///< images, or a project (.toml)
    std::uint32_t record = 0;          ///< only this record of it; 0: all in turn
    std::optional<Vec3> focus;         ///< or exact phases for a point, metres
    std::string array = "tile-10x10";  ///< of `focus`
    std::string rig;                   ///< of `focus` instead of the array: several in their places (array/rig.hpp)
    std::string quantise;              ///< device on whose segments the drives of `focus` lie; empty: exact phases
    std::string pulses;                ///< or pulses that a simulation measured, and
    std::string manifest;              ///< the manifest of the image that was played; of an image, its manifest if it
                                       ///< is not the one beside it
};

/// The image that a file is, or that a project file makes, with its manifest.
/// @param manifest  empty for the one beside the image
[[nodiscard]] Bundle open_bundle(const std::string& path, const std::string& manifest = {},
                                 const Progress& progress = {});

/// The bytes of the Intel HEX image that a file is, or that a project file makes, for verbs that need no manifest.
[[nodiscard]] std::string open_hex(const std::string& path, const Progress& progress = {});

/// @throws Error{bad_argument} when none is given, or Error{bad_input} for files that cannot be used
[[nodiscard]] Excitation open_excitation(const Source& source, const Progress& progress = {});

/// Reads "x,y,z" in millimetres. @param setting  names it in messages
[[nodiscard]] Vec3 parse_point_mm(const std::string& setting, const std::string& text);

}  // namespace haptogram
