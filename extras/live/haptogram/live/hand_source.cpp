// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/hand_source.hpp"

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/mounting.hpp"

namespace haptogram::live {

using namespace std::chrono_literals;

namespace {
constexpr double anew_s = 1.0;  ///< a frame that is earlier by more is of another session of the tracker
}  // namespace

RecordedHands::RecordedHands(HandRecording recording, const std::string& name, double seconds)
    : recording_(std::move(recording)) {
    auto& frames = recording_.frames;
    if (seconds > 0.0) std::erase_if(frames, [seconds](const HandFrame& frame) { return frame.time_s >= seconds; });
    if (frames.empty()) throw bad_input(name, "there is no hand in it");
    if (const double span_s = frames.back().time_s - frames.front().time_s; span_s > 0.0)
        rate_hz_ = static_cast<double>(frames.size() - 1) / span_s;
}

std::optional<Frame> RecordedHands::next() {
    if (next_ == recording_.frames.size()) return {};
    const HandFrame& frame = recording_.frames[next_];
    return Frame{next_++, frame.time_s, {}, frame};
}

void HandPipe::take(HandFrame frame) {
    constexpr double weight = 0.1, longest_s = 0.1;  // a tracker that pauses does not become slow
    if (last_s_) interval_s_ += weight * (std::clamp(frame.time_s - *last_s_, 1e-3, longest_s) - interval_s_);
    last_s_ = frame.time_s;
    if (!begin_s_) begin_s_ = frame.time_s;
    frame.time_s -= *begin_s_;
    const double time_s = frame.time_s;
    newest_ = Frame{frames_++, time_s, {}, mounted(std::move(frame), mounting_)};
}

/// Takes one line in, if one comes in time. @return whether one did
bool HandPipe::take_line(std::chrono::milliseconds patience) {
    const std::optional<std::string> line = lines_.next(patience);
    if (!line) return false;
    if (line->find_first_not_of(" \t\r") == std::string::npos) return true;
    try {
        std::optional<HandFrame> frame = read_(*line, lines_.where());
        if (!frame) return true;
        const double behind_s = last_s_ ? *last_s_ - frame->time_s : -1.0;
        if (behind_s > anew_s)  // the tracking service has begun anew
            begin_s_ = frame->time_s - (*last_s_ - *begin_s_) - interval_s_;
        else if (behind_s >= 0.0)
            throw bad_input(lines_.where(), "found a frame that is no later than the one before it");
        take(std::move(*frame));
    } catch (const Error& error) {
        if (junk_++ == 0) why_ = error.what();
    }
    return true;
}

bool HandPipe::ready() {
    if (!live()) return true;
    while (take_line(0ms)) {
    }
    return newest_ || lines_.ended();
}

std::optional<Frame> HandPipe::next() {
    while (!newest_ && !lines_.ended()) take_line(100ms);
    return std::exchange(newest_, std::nullopt);
}

}  // namespace haptogram::live
