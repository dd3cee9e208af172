// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/live/depth.hpp"

namespace haptogram {

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

}  // namespace haptogram
