// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "haptogram/link/clock.hpp"
#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// Several cameras and trackers as one source, in rounds: a frame has what is new of all. One that is late, by half of
/// its interval, is not waited for: its cameras have no picture then, and its hands stay, with the time at which they
/// were seen, for `forget_s`. A hand that two trackers see is that of the one that was named first.
class CombinedSource final : public FrameSource {
public:
    struct Part {
        std::unique_ptr<FrameSource> frames;
        std::size_t cameras = 0;  ///< 0: a tracker's hands
    };
    /// @param clock  by which live sources, each of which has one of its own, are put together
    /// @throws Error{bad_argument} when some are live and others recordings, or there are too many
    CombinedSource(std::vector<Part> parts, link::Clock& clock);

    /// Of the slowest one that is not late.
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
        double last_s = 0.0;              ///< when that was seen, by the common time
        double came_s = 0.0;              ///< and when it came
        std::optional<double> apart_s{};  ///< common time less the time of its own
        bool fresh = false;               ///< it is of this round
        bool late = false;                ///< the last round did not wait for it
        bool ended = false;
    };
    void look_ahead(Source& source) const;
    [[nodiscard]] Source* earliest();
    [[nodiscard]] bool is_round(double now_s);
    void take(Source& source, Frame frame, double came_s);
    void take_what_came();
    [[nodiscard]] Frame together();

    std::vector<Source> sources_;
    link::Clock& clock_;
    bool live_ = false;
    std::optional<double> begin_s_;
    std::uint64_t number_ = 0;
};

}  // namespace haptogram::live
