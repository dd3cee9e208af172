// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/depth_pipe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/live/depth_folder.hpp"

namespace haptogram {
namespace {

constexpr std::string_view magic = "SHOT";
constexpr std::size_t head_bytes = 24;
constexpr std::size_t most_text = 1U << 16U;
constexpr std::chrono::milliseconds pause{100};

// The machines that the project is built for keep numbers as the pipe has them.
static_assert(std::endian::native == std::endian::little);

template <class Number>
Number number_at(const std::string& bytes, std::size_t at) {
    Number number{};
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

template <class Number>
void append(std::string& bytes, Number number) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof number);
    std::memcpy(bytes.data() + at, &number, sizeof number);
}

std::size_t bytes_of(const DepthCamera& camera) {
    return std::size_t{camera.width} * camera.height * sizeof(DepthPicture::value_type);
}

}  // namespace

DepthPipe::DepthPipe(const std::string& path) : input_(path) {
    std::size_t end = std::string::npos;
    while ((end = bytes_.find('\0')) == std::string::npos) {
        if (bytes_.size() > most_text || input_.ended())
            throw bad_input(input_.name(),
                            fmt::format("expected cameras.toml and a byte of 0 behind it; {}",
                                        input_.ended() ? "it ended before that byte" : "there is none in 64 KiB"));
        (void)input_.read(bytes_, pause);
    }
    DepthCameras found = cameras_from_toml(std::string_view(bytes_).substr(0, end), input_.name());
    if (found.cameras.size() > depth_pipe_cameras)
        throw bad_input(input_.name(), fmt::format("found {} cameras; a pipe has at most {}", found.cameras.size(),
                                                   depth_pipe_cameras));
    bytes_.erase(0, end + 1);
    cameras_ = std::move(found.cameras);
    rate_hz_ = found.rate_hz;
}

/// Why no shot begins at a place, behind which there is a whole head; empty when one may.
std::string DepthPipe::flaw_of(std::size_t at) const {
    if (std::string_view(bytes_).substr(at, magic.size()) != magic)
        return "it must begin with \"SHOT\"; a picture before it has not its camera's size, or bytes were lost";
    const auto seen = number_at<std::uint32_t>(bytes_, at + 4);
    if (cameras_.size() < depth_pipe_cameras && seen >> cameras_.size() != 0)
        return fmt::format("it has pictures by the mask {:#x}, but there are {} cameras", seen, cameras_.size());
    if (!std::isfinite(number_at<double>(bytes_, at + 16))) return "its time is not a finite number";
    return {};
}

/// Goes to the next place at which a shot may begin.
void DepthPipe::skip(const std::string& why) {
    if (!searching_ && junk_++ == 0) why_ = fmt::format("shot {} of the pipe: {}", shots_ + 1, why);
    const std::size_t next = bytes_.find(magic, 1);
    // The beginning of the word may be there, and the rest still come.
    bytes_.erase(0, std::min(next, bytes_.size() - std::min(bytes_.size(), magic.size() - 1)));
    searching_ = true;
}

/// Until a shot may begin with the first byte. @return whether one may
bool DepthPipe::take_head() {
    while (bytes_.size() >= head_bytes) {
        const std::string flaw = flaw_of(0);
        if (flaw.empty()) return true;
        skip(flaw);
    }
    return false;
}

void DepthPipe::take_shot() {
    while (take_head()) {
        const auto seen = number_at<std::uint32_t>(bytes_, 4);
        DepthShot shot{number_at<std::uint64_t>(bytes_, 8), number_at<double>(bytes_, 16), {}};
        std::size_t end = head_bytes;
        for (std::size_t i = 0; i < cameras_.size(); ++i) end += (seen >> i & 1U) != 0 ? bytes_of(cameras_[i]) : 0;
        // A later shot that begins within this one: the writer has lost the rest of this one.
        const std::size_t most = std::min(end, bytes_.size() - head_bytes + 1);
        std::size_t other = bytes_.find(magic, head_bytes);
        while (other < most && !(flaw_of(other).empty() && number_at<std::uint64_t>(bytes_, other + 8) > shot.number &&
                                 number_at<double>(bytes_, other + 16) > shot.time_s))
            other = bytes_.find(magic, other + 1);
        if (other < most) {
            bytes_.erase(0, other - 1);  // so that it is what the search finds
            skip("the next one begins within it");
            continue;
        }
        if (bytes_.size() < end) return;
        std::size_t at = head_bytes;
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
            shot.pictures.emplace_back();
            if ((seen >> i & 1U) == 0) continue;
            DepthPicture picture(std::size_t{cameras_[i].width} * cameras_[i].height);
            std::memcpy(picture.data(), bytes_.data() + at, bytes_of(cameras_[i]));
            at += bytes_of(cameras_[i]);
            shot.pictures.back() = std::move(picture);
        }
        bytes_.erase(0, end);
        shot_ = std::move(shot);
        ++shots_;
        searching_ = false;
        return;
    }
}

bool DepthPipe::ready() {
    using namespace std::chrono_literals;
    take_in(0ms);
    return shot_.has_value() || input_.ended();
}

std::optional<DepthShot> DepthPipe::next() {
    while (!shot_ && !input_.ended()) take_in(pause);
    return std::exchange(shot_, std::nullopt);
}

void DepthPipe::take_in(std::chrono::milliseconds patience) {
    if (!shot_) take_shot();
    while (!shot_ && !input_.ended() && input_.read(bytes_, patience)) take_shot();
    if (!shot_ && input_.ended() && !bytes_.empty()) {
        skip(fmt::format("the pipe ended within it, after {} bytes", bytes_.size()));
        bytes_.clear();
    }
}

std::string depth_pipe_head(const std::vector<DepthCamera>& cameras, double rate_hz) {
    if (cameras.empty() || cameras.size() > depth_pipe_cameras)
        throw bad_argument("cameras", fmt::format("found {}, expected 1 to {}", cameras.size(), depth_pipe_cameras));
    std::string head = cameras_to_toml(cameras, rate_hz);
    head += '\0';
    return head;
}

std::string depth_pipe_shot(const DepthShot& shot, const std::vector<DepthCamera>& cameras) {
    std::string bytes(magic);
    std::uint32_t seen = 0;
    std::string pictures;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const std::optional<DepthPicture>& picture = shot.pictures.at(i);
        if (!picture) continue;
        const std::size_t size = picture->size() * sizeof(DepthPicture::value_type), at = pictures.size();
        if (size != bytes_of(cameras[i]))
            throw bad_argument("shot", fmt::format("the picture of camera {} has {} pixels, expected {} x {}", i + 1,
                                                   picture->size(), cameras[i].width, cameras[i].height));
        seen |= std::uint32_t{1} << i;
        pictures.resize(at + size);
        std::memcpy(pictures.data() + at, picture->data(), size);
    }
    append(bytes, seen);
    append(bytes, shot.number);
    append(bytes, shot.time_s);
    return bytes + pictures;
}

}  // namespace haptogram
