// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/base/live_input.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// A depth source as a source of frames.
class DepthFrames final : public FrameSource {
public:
    explicit DepthFrames(DepthSource& source) : source_(source) {}
    [[nodiscard]] double rate_hz() const override { return source_.rate_hz(); }
    [[nodiscard]] bool live() const override { return source_.live(); }
    [[nodiscard]] bool ready() override { return source_.ready(); }
    [[nodiscard]] std::optional<Frame> next() override {
        std::optional<DepthShot> shot = source_.next();
        if (!shot) return {};
        return Frame{shot->number, shot->time_s, {}, *std::move(shot)};
    }

private:
    DepthSource& source_;
};

}  // namespace haptogram::live

namespace haptogram {

/// Reads a depth picture: a PNG of one grey channel of 16 bits, of the camera's size. Its counts are taken as they are,
/// whatever gamma the file speaks of.
/// @param where  names the file in messages
/// @throws Error{bad_input} saying what is damaged, or which size and kind was found and which was expected
[[nodiscard]] DepthPicture depth_from_png(std::string_view bytes, const std::string& where, const DepthCamera& camera);

/// The same picture as the bytes of a PNG.
/// @throws Error{bad_argument} when the picture has not the camera's size
[[nodiscard]] std::string depth_to_png(const DepthPicture& picture, const DepthCamera& camera);

/// What cameras.toml says.
struct DepthCameras {
    double rate_hz = 30.0;
    std::vector<DepthCamera> cameras;
    std::vector<std::optional<std::string>> folders;  ///< of each camera's pictures, as the file names them, if it does
    std::vector<std::string> lines;                   ///< where it does, for messages
};
/// @param where  names the file in messages
/// @throws Error{bad_input} naming file, line and key
[[nodiscard]] DepthCameras cameras_from_toml(std::string_view text, const std::string& where);

/// A recording of depth cameras: a folder with cameras.toml, as extras/live/README.md describes it, and for each
/// camera a folder of pictures whose names are the shots' numbers, such as 0130.png. A shot comes for every number that
/// any camera has a picture of, so a camera that was lost is one without a picture.
class DepthFolder final : public DepthSource {
public:
    /// @throws Error{bad_input} naming file, line and key, also for a folder without pictures, or names that are no
    /// numbers
    explicit DepthFolder(const std::filesystem::path& folder);

    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return cameras_; }
    [[nodiscard]] double rate_hz() const override { return rate_hz_; }
    [[nodiscard]] std::optional<DepthShot> next() override;

private:
    struct Picture {
        std::uint64_t number;
        std::filesystem::path file;
    };
    std::vector<DepthCamera> cameras_;
    std::vector<std::vector<Picture>> pictures_;  ///< of each camera, in ascending order of their numbers
    std::vector<std::size_t> next_;
    double rate_hz_ = 30.0;
};

/// Writes such a folder, shot by shot.
class DepthRecorder {
public:
    /// Makes the folder, and cameras.toml in it.
    /// @throws Error{bad_input} when that is not possible, or when the folder has a cameras.toml already
    DepthRecorder(std::filesystem::path folder, const std::vector<DepthCamera>& cameras, double rate_hz);
    void write(const DepthShot& shot) const;

private:
    std::filesystem::path folder_;
    std::vector<DepthCamera> cameras_;
};

/// The text of cameras.toml: camera i's pictures are in the folder "camera" and i, from 1.
[[nodiscard]] std::string cameras_to_toml(const std::vector<DepthCamera>& cameras, double rate_hz);

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
