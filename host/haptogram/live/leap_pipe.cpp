// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/leap_pipe.hpp"

#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/leap.hpp"

namespace haptogram::live {

using namespace std::chrono_literals;

LeapPipe::LeapPipe(const std::string& path, std::vector<DepthCamera> cameras, double rate_hz, const DepthNoise& noise)
    : lines_(path), cameras_(std::move(cameras)), rate_hz_(rate_hz), noise_(noise) {
    if (!(rate_hz > 0.0)) throw bad_argument("rate", "expected more than 0 shots a second");
}

bool LeapPipe::take_line(std::chrono::milliseconds patience) {
    const std::optional<std::string> line = lines_.next(patience);
    if (!line) return false;
    if (line->find_first_not_of(" \t\r") == std::string::npos) return true;
    std::optional<HandFrame> frame = frame_from_leap_message(*line, lines_.where());
    if (!frame) return true;
    if (frame_ && frame->time_s < frame_->time_s)
        throw bad_input(lines_.where(),
                        "found a frame that is earlier than the one before it; the tracking service "
                        "seems to have begun anew: begin anew, too");
    if (!begin_s_) begin_s_ = frame->time_s;
    number_ = static_cast<std::uint64_t>((frame->time_s - *begin_s_) * rate_hz_);
    frame_ = std::move(frame);
    return true;
}

bool LeapPipe::ready() {
    if (!live()) return true;
    while (take_line(0ms)) {
    }
    return due() || lines_.ended();
}

std::optional<DepthShot> LeapPipe::next() {
    while (!due() && !lines_.ended()) take_line(100ms);
    if (!due()) return {};
    last_ = number_;
    std::vector<RoundedBody> bodies;
    for (const Hand& hand : frame_->hands) {
        const std::vector<RoundedBody> of_hand = bodies_of(hand);
        bodies.insert(bodies.end(), of_hand.begin(), of_hand.end());
    }
    return render_shot(bodies, cameras_, noise_, number_, frame_->time_s - *begin_s_);
}

}  // namespace haptogram::live
