// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/base/live_input.hpp"
#include "haptogram/live/depth.hpp"

namespace haptogram {

/// Shots of a program that has cameras, over a pipe, as extras/live/README.md describes it. A file that such a
/// program has written is a recording.
class DepthPipe final : public DepthSource {
public:
    /// Waits until the program has said which cameras it has.
    /// @param path  "-" is standard input
    /// @throws Error{bad_input} naming the pipe, and line and key of what is said of the cameras
    explicit DepthPipe(const std::string& path);

    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return cameras_; }
    [[nodiscard]] double rate_hz() const override { return rate_hz_; }
    [[nodiscard]] bool live() const override { return !input_.is_file(); }
    [[nodiscard]] bool ready() override;
    [[nodiscard]] std::optional<DepthShot> next() override;
    /// How many times bytes were no shot, so that the next one was searched for; and why the first time.
    [[nodiscard]] std::pair<std::uint64_t, std::string> junk() const override { return {junk_, why_}; }

private:
    /// Takes in what comes until a shot is whole, and waits for each part at most so long.
    void take_in(std::chrono::milliseconds patience);
    void take_shot();
    bool take_head();
    [[nodiscard]] std::string flaw_of(std::size_t at) const;
    void skip(const std::string& why);

    LiveInput input_;
    std::string bytes_;  ///< that have come, and are of no shot yet
    std::vector<DepthCamera> cameras_;
    double rate_hz_ = 30.0;
    std::optional<DepthShot> shot_;
    std::size_t shots_ = 0;
    bool searching_ = false;  ///< for the next shot
    std::uint64_t junk_ = 0;
    std::string why_;
};

/// What such a program writes: once the head, then each shot.
/// @throws Error{bad_argument} for no camera, more than depth_pipe_cameras, or a picture of another size than its
/// camera's
[[nodiscard]] std::string depth_pipe_head(const std::vector<DepthCamera>& cameras, double rate_hz);
[[nodiscard]] std::string depth_pipe_shot(const DepthShot& shot, const std::vector<DepthCamera>& cameras);
inline constexpr std::size_t depth_pipe_cameras = 32;

}  // namespace haptogram
