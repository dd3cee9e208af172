// SPDX-License-Identifier: Apache-2.0
// Live sessions: `haptogram live` with what a page shows, on the studio's board. Hands, paths and times are its own.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "child.hpp"
#include "haptogram/base/process.hpp"
#include "messages.hpp"
#include "scenes.hpp"
#include "virtual_board.hpp"

namespace haptogram::studio {

/// A session that needs nothing more but its board.
struct LiveStart {
    std::shared_ptr<TemporaryFolder> folder;  ///< that it runs in, with the document's files
    std::vector<std::string> words;           ///< of the command line
    std::string left_out;                     ///< a sentence on settings of [live] that it does not take; may be empty
};

/// @throws Error as Scenes::hand(), and Error{bad_argument} for a tracker that is no named pipe, and for a design whose
/// amplitude, waveform or magnitude a session would not play
[[nodiscard]] LiveStart prepare_live(Scenes& scenes, const LiveMessage& asked);

/// The command of a session on a board.
[[nodiscard]] Child::Command live_command(const LiveStart& start, const BoardPort& port);

}  // namespace haptogram::studio
