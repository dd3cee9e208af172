// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/hand/hand.hpp"
#include "haptogram/link/clock.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/frame.hpp"
#include "haptogram/live/hand_source.hpp"

namespace haptogram::live {

/// Cameras that are simulated, where a source has none of its own.
struct CameraOptions {
    std::size_t count = 4;    ///< around the object, as in Fingers; 1: below it, looking up, as in its first experiment
    double distance_m = 0.3;  ///< from the object
    Vec3 target{0, 0, 0.2};   ///< what they look at
    double rate_hz = 30.0;
    double seconds = 0.0;  ///< 0: as long as the recording or script is
    DepthNoise noise;
};

/// The cameras of these options.
[[nodiscard]] std::vector<DepthCamera> cameras_of(const CameraOptions& options);

/// Two round upright fingers of 8 mm that press on the top of an object and let go, once a second.
/// @param object  its middle @param half_m  half of its edge
[[nodiscard]] std::vector<RoundedBody> pressing_fingers(double time_s, Vec3 object, double half_m);

/// Where frames come from, as a user names it.
struct OpenedSource {
    std::unique_ptr<FrameSource> frames;
    std::vector<std::unique_ptr<DepthSource>> depth{};  ///< behind them; none of trackers' hands
    std::vector<const HandPipe*> trackers{};            ///< among them, those that come as it happens
    [[nodiscard]] bool only_hands() const { return depth.empty(); }
    /// Of all that are depth, in their order.
    [[nodiscard]] std::vector<DepthCamera> cameras() const;
};
/// - depth:FOLDER   a recording (live/depth_source.hpp)
/// - depth-pipe:FILE   cameras of another program (live/depth_source.hpp); - is standard input
/// - fingers:press   scripted fingers at the object, which simulated cameras see
/// - leap-pipe:FILE, joints-pipe:FILE   hands of another program (live/hand_source.hpp)
/// - leap:FILE, joints:FILE, poses:FILE   recorded hands; also synthetic:SCRIPT[:HEIGHT] as render has it
/// @MOUNTING behind a file says where the tracker, or the frame of all of the cameras, is (hand/mounting.hpp).
/// @param cameras  the simulated ones; of a recording of hands only their `seconds` count
/// @param object  its middle, @param half_m half of its edge, for scripted fingers
/// @throws Error{bad_input} for files that cannot be used, Error{bad_argument} for other names
[[nodiscard]] OpenedSource open_source(const std::string& name, const CameraOptions& cameras, Vec3 object,
                                       double half_m);
/// Several of them as one (live/source.hpp); one as it is.
/// @throws Error{bad_argument} when there is none, or when recordings are among what comes as it happens
[[nodiscard]] OpenedSource open_sources(const std::vector<std::string>& names, const CameraOptions& cameras,
                                        Vec3 object, double half_m);
/// Whether a source of this name is seen by simulated cameras.
[[nodiscard]] bool has_simulated_cameras(std::string_view name);

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
