// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "haptogram/image/image.hpp"
#include "haptogram/model/array.hpp"
#include "haptogram/solve/formation.hpp"
#include "haptogram/solve/timer.hpp"

namespace haptogram {

/// What an image means in the world, kept beside it as JSON: the array it was compiled for, the timer, and each
/// record's focal point. Lengths are millimetres in the file.
struct Manifest {
    Array array;  ///< name, elements, carrier, duty, medium, transducer, board
    Timer timer;
    std::vector<Vec3> foci;                   ///< metres; record i is foci[i − 1]
    std::vector<std::uint32_t> dwell_cycles;  ///< one a record: carrier cycles in one pass
    double rate_hz = 0.0;                     ///< passes a second, as it came out
    Formation formation;
    std::string input_sha256;  ///< of every input and option that shaped the image
    std::string image_sha256;  ///< of the HEX file's bytes
};

[[nodiscard]] std::string version();

[[nodiscard]] nlohmann::ordered_json to_json(const Manifest& manifest);

/// @param where  names the file in messages
/// @throws Error{bad_input} for invalid JSON, and for missing or mistyped members, which it names
[[nodiscard]] Manifest manifest_from_json(std::string_view text, const std::string& where);

}  // namespace haptogram
