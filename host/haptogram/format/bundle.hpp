// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "haptogram/format/image.hpp"
#include "haptogram/format/manifest.hpp"

namespace haptogram {

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

}  // namespace haptogram
