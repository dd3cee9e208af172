// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/combined_source.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::live {
namespace {

constexpr std::size_t most_sources = 8;
constexpr double same_hand_m = 80e-3;
constexpr double least_apart_s = 1e-6;  // two frames at one time are one after the other
constexpr std::chrono::microseconds nap{300};

double steady_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

bool is_known(const std::vector<Hand>& hands, const Hand& hand) {
    return std::any_of(hands.begin(), hands.end(), [&](const Hand& other) {
        return other.right == hand.right && distance(other.palm, hand.palm) < same_hand_m;
    });
}

}  // namespace

CombinedSource::CombinedSource(std::vector<Part> parts, std::function<double()> now_s)
    : now_s_(now_s ? std::move(now_s) : steady_s) {
    if (parts.empty() || parts.size() > most_sources) throw bad_argument("from", "expected one to eight sources");
    live_ = parts.front().frames->live();
    for (Part& part : parts) {
        if (part.frames->live() != live_)
            throw bad_argument("from", "a recording and what comes as it happens have no common time; take either");
        sources_.push_back({std::move(part)});
    }
}

double CombinedSource::rate_hz() const {
    double rate = 0.0;
    for (const Source& source : sources_) rate = std::max(rate, source.part.frames->rate_hz());
    return rate;
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

/// Of live sources, one that has a frame; those that have had none for longest come first.
CombinedSource::Source* CombinedSource::first_ready() {
    Source* first = nullptr;
    for (Source& source : sources_)
        if (!source.ended && source.part.frames->ready() && (first == nullptr || source.last_s < first->last_s))
            first = &source;
    return first;
}

bool CombinedSource::ready() {
    if (!live_) return true;
    return first_ready() != nullptr ||
           std::all_of(sources_.begin(), sources_.end(), [](const Source& source) { return source.ended; });
}

void CombinedSource::take(Source& source, Frame frame, double time_s) {
    // Frames that one source lost are lost ones of all.
    number_ += !begun_ ? 0 : source.last && frame.number > source.last->number ? frame.number - source.last->number : 1;
    begun_ = true;
    time_s_ = std::max(time_s, time_s_ + least_apart_s);
    source.last = std::move(frame);
    source.last_s = time_s_;
}

Frame CombinedSource::together(double time_s) const {
    Together seen;
    std::size_t cameras = 0;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const Source& source = sources_[i];
        cameras += source.part.cameras;
        seen.shot.pictures.resize(cameras);
        if (!source.last || time_s - source.last_s > forget_s) continue;
        if (const auto* shot = std::get_if<DepthShot>(&source.last->seen))
            std::copy(shot->pictures.begin(), shot->pictures.end(),
                      seen.shot.pictures.end() - static_cast<std::ptrdiff_t>(source.part.cameras));
        else
            for (Hand hand : std::get<HandFrame>(source.last->seen).hands) {
                if (is_known(seen.hands.hands, hand)) continue;
                hand.id = hand.id * static_cast<std::int64_t>(most_sources) + static_cast<std::int64_t>(i);
                seen.hands.hands.push_back(hand);
            }
    }
    seen.shot.number = number_;
    seen.shot.time_s = seen.hands.time_s = time_s;
    Frame frame{number_, time_s, {}, {}};
    if (cameras > 0)
        frame.seen = std::move(seen);
    else
        frame.seen = std::move(seen.hands);
    return frame;
}

std::optional<Frame> CombinedSource::next() {
    if (!live_) {
        Source* const source = earliest();
        if (source == nullptr) return {};
        Frame frame = *std::exchange(source->coming, std::nullopt);
        const double time_s = frame.time_s;
        take(*source, std::move(frame), time_s);
        return together(time_s_);
    }
    for (;;) {
        if (!ready()) {
            std::this_thread::sleep_for(nap);
            continue;
        }
        Source* const source = first_ready();
        if (source == nullptr) return {};
        std::optional<Frame> frame = source->part.frames->next();
        source->ended = !frame;
        if (!frame) continue;
        if (!begin_s_) begin_s_ = now_s_();
        take(*source, *std::move(frame), now_s_() - *begin_s_);
        return together(time_s_);
    }
}

}  // namespace haptogram::live
