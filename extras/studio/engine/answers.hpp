// SPDX-License-Identifier: Apache-2.0
// What pages ask of scenes, answered at once. The server calls these functions in threads of its own, the page without
// a server in its one thread (../wasm). No board, no file of this machine and no program has a part in them.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "haptogram/base/progress.hpp"
#include "messages.hpp"
#include "scenes.hpp"
#include "served.hpp"

namespace haptogram::studio {

// Each message is answered with what messages.hpp says, or with "failed". Nothing is told of work that was cancelled.
void answer(Scenes& scenes, Recipient& page, const SceneMessage& message);
void answer(Scenes& scenes, Recipient& page, const HandMessage& message);
void answer(Scenes& scenes, Recipient& page, const PathMessage& message, const Progress& progress = {});
void answer(Scenes& scenes, Recipient& page, const SliceMessage& message);
void answer(Scenes& scenes, Recipient& page, const ReachMessage& message);
void answer(Scenes& scenes, Recipient& page, const SkinMessage& message);
void answer(Scenes& scenes, Recipient& page, const DrivesMessage& message);
void answer(Scenes& scenes, Recipient& page, const AnalyzeMessage& message, const Progress& progress = {});

/// What a page must know to begin.
/// @param name  of the first document
[[nodiscard]] nlohmann::ordered_json hello_json(const Scenes& scenes, const std::string& name);

/// The answer to a request for documents, files and scenes as files.
/// @return none when it is for something else
/// @throws Error when what is asked for makes no sense
[[nodiscard]] std::optional<Answer> answer_at_once(Scenes& scenes, Request request);

/// Makes the content of a file, which takes a while.
using Writing = std::function<std::string(const Progress&)>;
/// A picture of what plays, for a report; may be empty.
using ReportPicture = std::function<std::string(const Timeline&, const Progress&)>;

/// The work that a request for a field or a report asks for.
/// @return none when it is for something else
/// @throws Error when what is asked for makes no sense
[[nodiscard]] std::optional<Writing> writing_of(Scenes& scenes, const Request& request, const ReportPicture& draw);

}  // namespace haptogram::studio
