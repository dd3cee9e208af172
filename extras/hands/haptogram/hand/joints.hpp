// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

#include "haptogram/hand/hand.hpp"

namespace haptogram {

/// Reads hands of any tracker, a frame a line, as JSON (extras/hands/README.md has the form). x to the right, y up and
/// z to the user become x, z and −y of the array frame.
class JointLines {
public:
    /// @param where  names the line in messages
    /// @throws Error{bad_input} naming the place of what is missing, mistyped or unknown
    [[nodiscard]] HandFrame frame(std::string_view json, const std::string& where);

private:
    HandFrame last_;  ///< from which palms move
};

/// A file of such lines. @throws Error{bad_input} also for a frame that is earlier than the one before it
[[nodiscard]] HandRecording recording_from_joints(std::string_view text, const std::string& where);

}  // namespace haptogram
