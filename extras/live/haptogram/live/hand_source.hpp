// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "haptogram/array/pose.hpp"
#include "haptogram/base/live_input.hpp"
#include "haptogram/hand/hand.hpp"
#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// The frames of a recording or script of hands, once.
class RecordedHands final : public FrameSource {
public:
    /// @param seconds  how long it lasts; 0: to its end
    /// @throws Error{bad_input} when it has no frame
    RecordedHands(HandRecording recording, const std::string& name, double seconds = 0.0);
    [[nodiscard]] double rate_hz() const override { return rate_hz_; }
    [[nodiscard]] bool live() const override { return false; }
    [[nodiscard]] bool ready() override { return true; }
    [[nodiscard]] std::optional<Frame> next() override;

private:
    HandRecording recording_;
    double rate_hz_ = 60.0;
    std::size_t next_ = 0;
};

/// Hands as a tracker sends them, a message a line. The newest frame wins; those that it overtakes are
/// lost frames. Lines that are no frames are counted, and the next one is taken.
class HandPipe final : public FrameSource {
public:
    using LineReader = std::function<std::optional<HandFrame>(const std::string& line, const std::string& where)>;
    /// @param path      of the lines; "-" is standard input. A file is a recording
    /// @param read      makes a frame of a line, or nothing of one that has none
    /// @param mounting  of the tracker
    /// @throws Error{bad_input} when it cannot be opened
    HandPipe(const std::string& path, LineReader read, const Pose& mounting = {})
        : lines_(path), read_(std::move(read)), mounting_(mounting) {}
    [[nodiscard]] double rate_hz() const override { return 1.0 / interval_s_; }
    [[nodiscard]] bool live() const override { return !lines_.is_file(); }
    [[nodiscard]] bool ready() override;
    [[nodiscard]] std::optional<Frame> next() override;
    /// What was no frame, or earlier than the one before it; and why the first was none.
    [[nodiscard]] std::pair<std::uint64_t, std::string> junk() const { return {junk_, why_}; }

private:
    bool take_line(std::chrono::milliseconds patience);
    void take(HandFrame frame);

    LiveText lines_;
    LineReader read_;
    Pose mounting_;
    std::optional<Frame> newest_;
    std::optional<double> begin_s_, last_s_;  ///< when the first frame was, and the last one, by the tracker
    std::uint64_t frames_ = 0, junk_ = 0;
    std::string why_;
    double interval_s_ = 1.0 / 60.0;  ///< between frames, a running mean
};

}  // namespace haptogram::live
