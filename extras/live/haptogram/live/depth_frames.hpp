// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <utility>

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
