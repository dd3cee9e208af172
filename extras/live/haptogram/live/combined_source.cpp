// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/combined_source.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::live {
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
