// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// Several cameras and trackers as one source. A frame of any of them is one of all: with what the others saw last, not
/// longer ago than `forget_s`. A hand that two trackers see is that of the one that was named first.
class CombinedSource final : public FrameSource {
public:
    struct Part {
        std::unique_ptr<FrameSource> frames;
        std::size_t cameras = 0;  ///< 0: a tracker's hands
    };
    /// @param now_s  a clock, by which live sources, each of which has one of its own, are put together
    /// @throws Error{bad_argument} when some are live and others recordings, or there are too many
    explicit CombinedSource(std::vector<Part> parts, std::function<double()> now_s = {});

    /// Of the fastest one.
    [[nodiscard]] double rate_hz() const override;
    [[nodiscard]] bool live() const override { return live_; }
    [[nodiscard]] bool ready() override;
    [[nodiscard]] std::optional<Frame> next() override;

    static constexpr double forget_s = 0.1;

private:
    struct Source {
        Part part;
        std::optional<Frame> coming{};  ///< of a recording
        std::optional<Frame> last{};
        double last_s = 0.0;
        bool ended = false;
    };
    void look_ahead(Source& source) const;
    [[nodiscard]] Source* earliest();
    [[nodiscard]] Source* first_ready();
    void take(Source& source, Frame frame, double time_s);
    [[nodiscard]] Frame together(double time_s) const;

    std::vector<Source> sources_;
    std::function<double()> now_s_;
    bool live_ = false;
    std::optional<double> begin_s_;
    double time_s_ = -1.0;
    std::uint64_t number_ = 0;
    bool begun_ = false;
};

}  // namespace haptogram::live
