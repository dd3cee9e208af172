// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/joints.hpp"
#include "haptogram/hand/mounting.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/live/depth_source.hpp"
#include "haptogram/live/hand_source.hpp"

namespace haptogram::live {
namespace {

constexpr double finger_radius_m = 8e-3;
constexpr double press_s = 1.0;

/// Cameras whose poses are seen from a mounting.
class MountedDepth final : public DepthSource {
public:
    MountedDepth(std::unique_ptr<DepthSource> source, const Pose& mounting)
        : source_(std::move(source)), cameras_(source_->cameras()) {
        for (DepthCamera& camera : cameras_)
            camera.pose = {mounting.outwards(camera.pose.origin), mounting.turned(camera.pose.x),
                           mounting.turned(camera.pose.y), mounting.turned(camera.pose.z)};
    }
    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return cameras_; }
    [[nodiscard]] double rate_hz() const override { return source_->rate_hz(); }
    [[nodiscard]] std::optional<DepthShot> next() override { return source_->next(); }
    [[nodiscard]] bool live() const override { return source_->live(); }
    [[nodiscard]] bool ready() override { return source_->ready(); }
    [[nodiscard]] std::pair<std::uint64_t, std::string> junk() const override { return source_->junk(); }

private:
    std::unique_ptr<DepthSource> source_;
    std::vector<DepthCamera> cameras_;
};

OpenedSource of_depth(std::unique_ptr<DepthSource> depth, const std::string& mounting = {}) {
    if (!mounting.empty())
        depth = std::make_unique<MountedDepth>(std::move(depth), mounting_from_toml(read_file(mounting), mounting));
    OpenedSource opened{std::make_unique<DepthFrames>(*depth)};
    opened.depth.push_back(std::move(depth));
    return opened;
}

}  // namespace

std::vector<DepthCamera> OpenedSource::cameras() const {
    std::vector<DepthCamera> all;
    for (const auto& source : depth) all.insert(all.end(), source->cameras().begin(), source->cameras().end());
    return all;
}

std::vector<DepthCamera> cameras_of(const CameraOptions& options) {
    if (options.count != 1) return cameras_around(options.target, options.distance_m, options.count);
    DepthCamera below = wide_depth_camera();
    below.pose = looking_at(options.target - Vec3{0, 0, options.distance_m}, options.target);
    return {below};
}

std::vector<RoundedBody> pressing_fingers(double time_s, Vec3 object, double half_m) {
    const double depth = 4.5e-3 - 5.5e-3 * std::cos(2.0 * std::numbers::pi * time_s / press_s);
    std::vector<RoundedBody> fingers;
    for (const double side : {-0.5, 0.5})
        fingers.push_back({object + Vec3{side * half_m, 0, half_m + finger_radius_m - depth + 25e-3},
                           {0, 0, 25e-3},
                           {},
                           finger_radius_m});
    return fingers;
}

OpenedSource open_source(const std::string& name, const CameraOptions& cameras, Vec3 object, double half_m) {
    const std::size_t colon = std::min(name.find(':'), name.size());
    const std::string kind = name.substr(0, colon), rest = colon < name.size() ? name.substr(colon + 1) : "";
    const auto [file, mounting] = without_mounting(rest);
    if (kind == "depth") return of_depth(std::make_unique<DepthFolder>(file), mounting);
    if (kind == "depth-pipe") return of_depth(std::make_unique<DepthPipe>(file), mounting);
    if (name == "fingers:press")
        return of_depth(std::make_unique<SyntheticDepth>(
            cameras_of(cameras), [=](double time_s) { return pressing_fingers(time_s, object, half_m); },
            cameras.rate_hz, cameras.seconds > 0.0 ? cameras.seconds : press_s, cameras.noise));
    if (kind == "leap-pipe" || kind == "joints-pipe") {
        HandPipe::LineReader read = frame_from_leap_message;
        if (kind == "joints-pipe")
            read = [lines = JointLines()](const std::string& line, const std::string& where) mutable {
                return lines.frame(line, where);
            };
        auto pipe = std::make_unique<HandPipe>(
            file, std::move(read), mounting.empty() ? Pose{} : mounting_from_toml(read_file(mounting), mounting));
        const HandPipe* const tracker = pipe.get();
        return {std::move(pipe), {}, {tracker}};
    }
    if (kind == "leap" || kind == "joints" || kind == "poses" || kind == "synthetic") {
        const std::string& recording = kind == "synthetic" ? name : rest;
        return {std::make_unique<RecordedHands>(open_hands(recording), recording, cameras.seconds)};
    }
    throw bad_argument(
        "from",
        fmt::format("found \"{}\", expected depth:FOLDER, depth-pipe:FILE, leap:FILE, "
                    "leap-pipe:FILE, joints:FILE, joints-pipe:FILE, poses:FILE, synthetic:SCRIPT or fingers:press",
                    name));
}

OpenedSource open_sources(const std::vector<std::string>& names, const CameraOptions& cameras, Vec3 object,
                          double half_m) {
    if (names.size() == 1) return open_source(names.front(), cameras, object, half_m);
    OpenedSource all;
    std::vector<CombinedSource::Part> parts;
    for (const std::string& name : names) {
        OpenedSource one = open_source(name, cameras, object, half_m);
        parts.push_back({std::move(one.frames), one.cameras().size()});
        std::move(one.depth.begin(), one.depth.end(), std::back_inserter(all.depth));
        all.trackers.insert(all.trackers.end(), one.trackers.begin(), one.trackers.end());
    }
    all.frames = std::make_unique<CombinedSource>(std::move(parts), link::machine_clock());
    return all;
}

bool has_simulated_cameras(std::string_view name) { return name.starts_with("fingers:"); }

namespace {

constexpr std::size_t most_sources = 8;
constexpr double same_hand_m = 80e-3;
constexpr double late_intervals = 1.5;  // of a source since its last frame: the next one is late
constexpr double old_intervals = 0.6;   // more than half, so that two that come in turn do not change places
constexpr double drift_part = 1e-2;     // of what a frame came later than expected is the clocks' drift
constexpr std::chrono::microseconds nap{300};

bool is_known(const std::vector<Hand>& hands, const Hand& hand) {
    return std::any_of(hands.begin(), hands.end(), [&](const Hand& other) {
        return other.right == hand.right && distance(other.palm, hand.palm) < same_hand_m;
    });
}

}  // namespace

CombinedSource::CombinedSource(std::vector<Part> parts, link::Clock& clock) : clock_(clock) {
    if (parts.empty() || parts.size() > most_sources) throw bad_argument("from", "expected one to eight sources");
    live_ = parts.front().frames->live();
    for (Part& part : parts) {
        if (part.frames->live() != live_)
            throw bad_argument("from", "a recording and what comes as it happens have no common time; take either");
        sources_.push_back({std::move(part)});
    }
}

double CombinedSource::rate_hz() const {
    double rate = HUGE_VAL, fastest = 0.0;
    for (const Source& source : sources_) {
        fastest = std::max(fastest, source.part.frames->rate_hz());
        if (!source.ended && !source.late) rate = std::min(rate, source.part.frames->rate_hz());
    }
    return std::min(rate, fastest);
}

void CombinedSource::look_ahead(Source& source) const {
    if (source.ended || source.coming) return;
    source.coming = source.part.frames->next();
    source.ended = !source.coming;
}

/// Of recordings, the one whose frame is next.
CombinedSource::Source* CombinedSource::earliest() {
    Source* first = nullptr;
    for (Source& source : sources_) {
        look_ahead(source);
        if (source.coming && (first == nullptr || source.coming->time_s < first->coming->time_s)) first = &source;
    }
    return first;
}

/// Whether all that is waited for has come.
bool CombinedSource::is_round(double now_s) {
    bool any = false;
    double newest_s = -HUGE_VAL;
    for (const Source& source : sources_)
        if (source.fresh) newest_s = std::max(newest_s, source.came_s);
    for (Source& source : sources_) {
        // Its next one comes sooner after the newest than this one was before it.
        if (source.fresh && !source.ended && newest_s - source.came_s > old_intervals / source.part.frames->rate_hz())
            source.fresh = false;
        any = any || source.fresh;
        if (source.fresh || source.ended) continue;
        if (source.coming && source.coming->time_s <= now_s) return false;
        if (source.last && now_s - source.came_s <= late_intervals / source.part.frames->rate_hz()) return false;
    }
    return any;
}

void CombinedSource::take(Source& source, Frame frame, double came_s) {
    // Frames that one source lost are lost ones of all.
    if (source.last && frame.number > source.last->number) number_ += frame.number - source.last->number - 1;
    // Of live sources each has a clock of its own, by which its frames are as far apart as they were seen; what came
    // with the least delay tells best how far that is from the common time. The clocks may drift.
    const double apart_s = live_ ? came_s - frame.time_s : 0.0;
    if (!source.apart_s || apart_s < *source.apart_s)
        source.apart_s = apart_s;
    else
        *source.apart_s += drift_part * (apart_s - *source.apart_s);
    source.last_s = frame.time_s + *source.apart_s;
    source.came_s = came_s;
    source.last = std::move(frame);
    source.fresh = true;
}

/// Of live sources: what there is of each, the newest.
void CombinedSource::take_what_came() {
    for (Source& source : sources_) {
        if (source.ended || !source.part.frames->ready()) continue;
        std::optional<Frame> frame = source.part.frames->next();
        source.ended = !frame;
        if (!frame) continue;
        const double now_s = clock_.now_s();
        if (!begin_s_) begin_s_ = now_s;
        take(source, *std::move(frame), now_s - *begin_s_);
    }
}

bool CombinedSource::ready() {
    if (!live_) return true;
    take_what_came();
    return is_round(begin_s_ ? clock_.now_s() - *begin_s_ : 0.0) ||
           std::all_of(sources_.begin(), sources_.end(), [](const Source& source) { return source.ended; });
}

Frame CombinedSource::together() {
    double time_s = -HUGE_VAL;
    for (const Source& source : sources_)
        if (source.fresh) time_s = std::max(time_s, source.last_s);
    Together seen;
    std::size_t cameras = 0;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        Source& source = sources_[i];
        cameras += source.part.cameras;
        seen.shot.pictures.resize(cameras);
        source.late = !source.fresh;
        if (!source.last || time_s - source.last_s > forget_s) continue;
        if (const auto* shot = std::get_if<DepthShot>(&source.last->seen)) {
            if (source.fresh)
                std::copy(shot->pictures.begin(), shot->pictures.end(),
                          seen.shot.pictures.end() - static_cast<std::ptrdiff_t>(source.part.cameras));
        } else {
            for (Hand hand : std::get<HandFrame>(source.last->seen).hands) {
                if (is_known(seen.hands.hands, hand)) continue;
                hand.id = hand.id * static_cast<std::int64_t>(most_sources) + static_cast<std::int64_t>(i);
                hand.seen_s = source.last_s;
                seen.hands.hands.push_back(hand);
            }
        }
        source.fresh = false;
    }
    seen.shot.number = number_;
    seen.shot.time_s = seen.hands.time_s = time_s;
    Frame frame{number_++, time_s, {}, {}};
    if (cameras > 0)
        frame.seen = std::move(seen);
    else
        frame.seen = std::move(seen.hands);
    return frame;
}

std::optional<Frame> CombinedSource::next() {
    if (live_) {
        while (!ready()) clock_.rest(nap);
    } else {
        for (Source* source = earliest(); source != nullptr; source = earliest()) {
            Frame frame = *std::exchange(source->coming, std::nullopt);
            const double time_s = frame.time_s;
            take(*source, std::move(frame), time_s);
            look_ahead(*source);
            if (is_round(time_s)) break;
        }
    }
    if (std::none_of(sources_.begin(), sources_.end(), [](const Source& source) { return source.fresh; })) return {};
    return together();
}

}  // namespace haptogram::live
