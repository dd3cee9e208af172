// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/focus_player.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/focus_image.hpp"

namespace haptogram::live {
namespace {

constexpr double least_frame_s = 2e-3;  ///< of playing, that a frame carries
constexpr double least_lead_s = 3e-3;   ///< beside what frames and answers take on the line
constexpr double most_lead_s = 50e-3;   ///< up to this it grows while the board runs dry
constexpr double lead_growth = 1.5;     ///< each time
constexpr double line_share = 0.85;     ///< of the line may be taken
constexpr double focus_share = 0.75;    ///< of that, at least, are foci; the rest is what stands around them
constexpr double frame_bytes = 16.0;    ///< beside the records: command, dwell, CRC and framing
constexpr double focus_bytes = 8.0;
constexpr double status_bytes = 64.0;     ///< of an answer to the question, which what plays must outlast
constexpr double status_pause_s = 20e-3;  ///< between questions whether the board has run dry
constexpr double fade_step_s = 20e-3;
constexpr std::size_t most_frames_unanswered = 2;

Timer timer_for(const link::Commands& device, const Array& array) {
    return choose_amplitude_timer(array, Core{device.identity().name, device.identity().core()});
}

}  // namespace

FocusPlayer::FocusPlayer(link::Commands& device, link::Clock& clock, const Array& array, const FocusPace& wanted,
                         const Line& line, std::uint16_t watchdog_ms, const std::vector<DevicePart>& parts)
    : Player(device, clock, timer_for(device, array), watchdog_ms) {
    choose_pace(wanted, line);
    Array rest = array;
    for (const DevicePart& part : parts.empty() ? one_part(device, array) : parts) {
        Array own = rest;
        own.elements.resize(part.elements);
        rest.elements.erase(rest.elements.begin(), rest.elements.begin() + static_cast<std::ptrdiff_t>(part.elements));
        upload(part, own);
    }
    const double bytes = status_bytes + frame_bytes + static_cast<double>(frame_ * ring_.each) * focus_bytes;
    lead_s_ = least_lead_s + bytes / line.bytes_s + line.trip_s;
}

/// Several foci a record if the line takes them so fast, else one, in turn.
void FocusPlayer::choose_pace(const FocusPace& wanted, const Line& line) {
    const double period_s = timer_.period_s();
    const auto most = std::min<std::size_t>(device_.identity().foci, most_record_foci);
    const double bytes_s = line_share * line.bytes_s;
    const auto periods_of = [&](std::size_t each) {
        return focus_bytes * static_cast<double>(each) / (focus_share * bytes_s) / period_s;
    };
    ring_.each = static_cast<std::uint32_t>(std::clamp<std::size_t>(wanted.foci, 1, most));
    if (periods_of(ring_.each) > wanted.periods) ring_.each = 1;
    // Foci that take turns do so within the time that each shall have.
    const double parts = std::ceil(static_cast<double>(wanted.foci) / ring_.each);
    const double periods = std::max({1.0, std::floor(wanted.periods / parts), std::ceil(periods_of(ring_.each))});
    dwell_ = static_cast<std::uint32_t>(std::min(periods, 65535.0));
    const link::Identity& board = device_.identity();
    const std::size_t room = std::min<std::size_t>((board.frame_bytes - 4) / (8 * ring_.each), board.live_depth / 4);
    const double frame_s = std::max(least_frame_s, frame_bytes / ((1.0 - focus_share) * bytes_s));
    frame_ = std::clamp<std::size_t>(static_cast<std::size_t>(std::round(frame_s / (dwell_ * period_s))), 1,
                                     std::max<std::size_t>(room, 1));
}

/// Writes what a board needs to compute foci for its elements. All have their ring in the same place.
void FocusPlayer::upload(const DevicePart& part, const Array& array) {
    const link::Identity& board = part.device.identity();
    PathStep step;
    constexpr double apart_m = 1e-3;  // records have as many foci as the image's step
    for (std::size_t i = 0; i < ring_.each; ++i)
        step.foci.push_back({{apart_m * static_cast<double>(i), 0.0, 0.2}, 1.0});
    Image image = focus_image_of({{step}, {}}, array, Core{board.name, board.core()}, 0).image;
    // A lone focus has all that the array can make; where several meet in phase, a channel has no more than that.
    image.foci->engine.gain = gain_word(1.0 / std::sin(std::numbers::pi * timer_.duty()));
    static_cast<void>(link::upload(part.device, image));
    const link::FocusRing ring = link::make_ring(part.device);
    if (ring_.count > 0 && ring != ring_)
        throw Error(ErrorCode::device, "rig",
                    fmt::format("its boards have the ring of foci in different places, from record {} on and from {}; "
                                "take boards with as many RECORDS",
                                ring_.first, ring.first));
    ring_ = ring;
}

void FocusPlayer::replace(const Path& path, std::uint64_t shot, double shot_s) {
    require_sound(path);
    if (!path.modulation.samples.empty()) throw bad_argument("path", "expected one without a modulation");
    const double share = path_ && !ends_.empty() ? at_ / ends_.back() : 0.0;
    path_ = path;
    ends_.clear();
    for (const PathStep& step : path.steps) ends_.push_back((ends_.empty() ? 0.0 : ends_.back()) + step.periods);
    at_ = share * ends_.back();
    about_ = {.shot = shot, .shot_s = shot_s};
    begun_ = false;
    late_s_ = clock_.now_s() + 2.0 * static_cast<double>(frame_ * dwell_) * timer_.period_s();
    faded_s_.reset();
}

void FocusPlayer::silence() {
    if (!path_) return;
    push(std::vector<std::uint16_t>{0}, 0);
    path_.reset();
    faded_s_.reset();
}

void FocusPlayer::fade() {
    if (path_ && !faded_s_) faded_s_ = 0.0;
}

const PathStep& FocusPlayer::step_now() const {
    const auto end = std::upper_bound(ends_.begin(), ends_.end() - 1, at_);
    return path_->steps[static_cast<std::size_t>(end - ends_.begin())];
}

/// The next record: where the path is in the middle of its dwell, or silence there.
std::vector<FocusWords> FocusPlayer::next_words() {
    at_ = std::fmod(at_ + 0.5 * dwell_, ends_.back());
    const std::vector<Focus>& foci = step_now().foci;
    const std::size_t parts = (foci.size() + ring_.each - 1) / ring_.each;
    const std::size_t first = parts > 1 ? ring_.each * (turn_++ % parts) : 0;
    double left = 1.0;
    if (faded_s_) {
        left = *faded_s_ < fade_step_s ? 2.0 / 3.0 : 1.0 / 3.0;
        *faded_s_ += dwell_ * timer_.period_s();
    }
    std::vector<FocusWords> words;
    for (std::size_t i = first; i < foci.size() && words.size() < ring_.each; ++i)
        words.push_back(last_ = pack_focus({foci[i].position, left * foci[i].amplitude}));
    last_[3] &= 0x00ffU;
    words.resize(ring_.each, last_);
    at_ = std::fmod(at_ + 0.5 * dwell_, ends_.back());
    return words;
}

void FocusPlayer::send(std::size_t count) {
    const double waiting = level();
    const std::uint64_t entry = fifo_->pushed;
    const auto dwell = static_cast<std::uint16_t>(dwell_);
    std::vector<std::uint16_t> indices, foci;
    std::optional<std::size_t> loud;
    for (std::size_t i = 0; i < count; ++i) {
        for (const FocusWords& words : next_words()) {
            if (words[3] >> 8U > 0 && !loud) loud = i;
            foci.insert(foci.end(), words.begin(), words.end());
        }
        indices.push_back(static_cast<std::uint16_t>(ring_.first + records_++ % ring_.count));
    }
    send_entries(link::push_foci_request(foci, dwell), indices, dwell);
    entry_s_ = dwell_ * timer_.period_s();
    if (begun_ || !loud) return;
    begun_ = true;
    about_.first_index = indices[*loud];
    begins(about_, entry + *loud, waiting + static_cast<double>(*loud));
}

bool FocusPlayer::service() {
    if (faded_s_ && *faded_s_ > 2.0 * fade_step_s) silence();
    if (!path_) return idle();
    const double entry = dwell_ * timer_.period_s();
    const auto wanted = static_cast<double>(std::min<std::size_t>(static_cast<std::size_t>(std::ceil(lead_s_ / entry)),
                                                                  device_.identity().live_depth - 1U));
    if (device_.unanswered() < most_frames_unanswered && level() + static_cast<double>(frame_) <= wanted + 1.0) {
        send(frame_);
        return true;
    }
    if (device_.unanswered() > 0) {
        device_.wait(device_.unanswered() - 1);
        return true;
    }
    // When the board has run dry, it shall have more in hand.
    if (std::exchange(underruns_, fifo_->underruns).value_or(fifo_->underruns) != fifo_->underruns)
        lead_s_ = std::min(most_lead_s, lead_growth * lead_s_);
    if (clock_.now_s() - asked_s_ < status_pause_s) return false;
    asked_s_ = clock_.now_s();
    ask();
    return true;
}

}  // namespace haptogram::live
