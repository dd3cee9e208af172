// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "haptogram/base/live_input.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/verbs/hand_source.hpp"

namespace haptogram::live {

/// The objects that hands feel, over time: one that the command line names, and what lines of JSON bring, move and take
/// away (README.md). A file is a script, whose lines are due at their times; of a pipe they count as they come.
class SceneInput {
public:
    /// @param path  of the lines; "-" is standard input; empty: there are none
    /// @throws Error{bad_input} when it or an object's file cannot be opened
    SceneInput(const ObjectSource& first, const std::string& path);
    /// The objects as one.
    /// @param time_s  of the frame; never earlier than the last one
    /// @throws Error{bad_input} naming a line of a script that makes no sense; those of a pipe are counted
    [[nodiscard]] std::shared_ptr<const TouchObject> at(double time_s);
    [[nodiscard]] std::uint64_t junk() const { return junk_; }

private:
    void take(const std::string& line);

    std::map<std::string, TouchObject> objects_;
    std::map<std::string, ObjectSource> sources_;
    std::shared_ptr<const TouchObject> all_;
    std::optional<LiveText> lines_;
    std::optional<std::string> waiting_;  ///< a line of a script that is not due
    std::uint64_t junk_ = 0;
};

/// Solids and features of several objects as one object.
[[nodiscard]] TouchObject together(const std::map<std::string, TouchObject>& objects);

}  // namespace haptogram::live
