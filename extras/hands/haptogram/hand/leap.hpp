// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "haptogram/hand/hand.hpp"

namespace haptogram {

/// Reads a recording of LeapJS Playback: JSON with an object a frame, or the packed format 2, whose first entry lists
/// the members of the others. The text may be compressed by LZString to base64. The Leap's x, y (up) and z (to the
/// user), in millimetres, become x, z and −y of the array frame, in metres.
/// @param where  names the file in messages
/// @throws Error{bad_input} for damaged text, and naming the place of what is missing or mistyped
[[nodiscard]] HandRecording recording_from_leap(std::string_view text, const std::string& where);
[[nodiscard]] HandRecording load_leap(const std::filesystem::path& file);

/// A message of the WebSocket of a Leap's tracking service, protocol 6: a frame, in the same frame and units, with the
/// tracker's own time; or nothing when it is another message, such as the service's version.
/// @throws Error{bad_input} as above
[[nodiscard]] std::optional<HandFrame> frame_from_leap_message(std::string_view json, const std::string& where);

/// The text that LZString compressed to base64 (Pieroxy's lz-string, compressToBase64).
/// @throws Error{bad_input} when the text is cut short or damaged
[[nodiscard]] std::string from_lz_string(std::string_view base64, const std::string& where);

}  // namespace haptogram
