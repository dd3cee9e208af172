// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "haptogram/base/live_input.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/live/frame.hpp"
#include "haptogram/live/hand_feeler.hpp"

namespace haptogram::live {

/// Opens objects as open_object() does, but reads each mesh file once: where it stands, how it is turned and how large
/// it is then costs no more than a look at its corners.
class OpenedObjects {
public:
    /// @throws as open_object()
    [[nodiscard]] TouchObject open(const ObjectSource& source);
    /// What a scene tells of it.
    /// @throws as open_object()
    [[nodiscard]] FeltObject told(const std::string& name, const ObjectSource& source);

private:
    struct Body;
    [[nodiscard]] const Body& body_of(const ObjectSource& source);

    std::map<std::pair<std::string, std::string>, std::shared_ptr<const Body>> bodies_;  ///< by file and unit
};

/// The objects that hands feel, over time: one that the command line names, and what lines of JSON bring, move and take
/// away (extras/live/README.md). A file is a script, whose lines are due at their times; of a pipe they count as they
/// come.
class SceneInput {
public:
    /// @param path  of the lines; "-" is standard input; empty: there are none
    /// @throws Error{bad_input} when it or an object's file cannot be opened, and naming any line of a script that
    /// makes no sense, whenever it is due
    SceneInput(const ObjectSource& first, const std::string& path);
    /// @param time_s  of the frame; never earlier than the last one
    [[nodiscard]] std::shared_ptr<const ObjectsNow> at(double time_s);
    /// How many lines of a pipe made no sense, and what is wrong with the first.
    [[nodiscard]] const std::pair<std::uint64_t, std::string>& junk() const { return junk_; }

private:
    /// What becomes of one object.
    struct Change {
        double due_s = 0.0;
        std::string name;
        std::optional<ObjectSource> source;  ///< none: it goes
    };
    using Sources = std::map<std::string, ObjectSource>;
    [[nodiscard]] Change read(const std::string& text, const std::string& where, const Sources& known);
    void read_script();
    void apply(const Change& change);

    OpenedObjects opened_;
    Sources sources_;
    std::map<std::string, TouchObject> objects_;
    std::shared_ptr<const ObjectsNow> now_;
    std::optional<LiveText> lines_;
    std::deque<Change> script_;  ///< what is not due yet
    std::pair<std::uint64_t, std::string> junk_{};
};

/// Solids and features of several objects as one object.
[[nodiscard]] TouchObject together(const std::map<std::string, TouchObject>& objects);

}  // namespace haptogram::live
