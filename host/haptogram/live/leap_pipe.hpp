// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/base/live_input.hpp"
#include "haptogram/hand/hand.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/depth_renderer.hpp"

namespace haptogram::live {

/// Hands as a Leap's tracking service sends them, a message a line, which simulated cameras see. A shot shows the
/// newest frame; its number counts the cameras' periods since the first frame, so those without a frame are lost shots.
class LeapPipe final : public DepthSource {
public:
    /// @param path  of the lines; "-" is standard input. A file is a recording
    /// @throws Error{bad_input} when it cannot be opened
    LeapPipe(const std::string& path, std::vector<DepthCamera> cameras, double rate_hz, const DepthNoise& noise);

    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return cameras_; }
    [[nodiscard]] double rate_hz() const override { return rate_hz_; }
    [[nodiscard]] bool live() const override { return !lines_.is_file(); }
    [[nodiscard]] bool ready() override;
    /// @throws Error{bad_input} naming the line and the place in it of what is missing or mistyped, or a frame that is
    /// earlier than the one before it
    [[nodiscard]] std::optional<DepthShot> next() override;

private:
    /// Waits for a line at most so long. @return whether one came
    bool take_line(std::chrono::milliseconds patience);
    [[nodiscard]] bool due() const { return frame_ && (!last_ || number_ > *last_); }

    LiveText lines_;
    std::vector<DepthCamera> cameras_;
    double rate_hz_;
    DepthNoise noise_;
    std::optional<HandFrame> frame_;     ///< the newest
    std::optional<double> begin_s_;      ///< when the first one was, by the tracker
    std::uint64_t number_ = 0;           ///< of the newest frame's period
    std::optional<std::uint64_t> last_;  ///< of the last shot
};

}  // namespace haptogram::live
