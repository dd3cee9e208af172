// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/players.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/interface.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/verbs/focus_image.hpp"

namespace haptogram::live {
namespace {

constexpr std::size_t most_banks = 4;
constexpr std::size_t most_unanswered = 1;  ///< one on the line while another is answered

/// FIFO entries that must be left when the next turn is pushed: what plays while two records are on the line before it,
/// 1 ms each in the paper's ring, and 2.2 ms each for a record of 100 channels at 1 Mbaud.
constexpr std::size_t most_low_water = 7;
constexpr double low_water_s = 7e-3;  ///< longer entries need not be so many

std::size_t low_water(double entry_s) {
    const double entries = std::max(1.0, std::ceil(low_water_s / entry_s));
    return entries < static_cast<double>(most_low_water) ? static_cast<std::size_t>(entries) : most_low_water;
}

/// The channels of a record that a part has. Those beyond its elements are silent.
Record part_of(const Record& record, std::size_t first, const DevicePart& part) {
    Record own = record;
    const auto begin = record.timings.begin() + static_cast<std::ptrdiff_t>(first);
    own.timings.assign(begin, begin + static_cast<std::ptrdiff_t>(part.elements));
    own.timings.resize(part.device.identity().channels, interface::silent_timing);
    return own;
}

link::Request write_of(const Record& record, std::uint16_t index) {
    Image image;
    image.channels = static_cast<std::uint32_t>(record.timings.size());
    image.records = {record};
    const std::uint32_t address = interface::primary_base + (index - 1U) * record_words(image.channels) * 2U;
    return link::write_request(address, primary_words(image));
}

/// A path in so many steps of equal length, which takes about as long. One that has them stays as it is.
Path in_steps(const Path& path, std::size_t count) {
    const auto is_other = [&](const PathStep& step) { return step.periods != path.steps.front().periods; };
    if (path.steps.size() == count && std::none_of(path.steps.begin(), path.steps.end(), is_other)) return path;
    const double periods = static_cast<double>(path.periods()) / static_cast<double>(count);
    const double dwell = std::clamp(std::round(periods), 1.0, 65535.0);
    Path even;
    std::size_t step = 0;
    auto end = static_cast<double>(path.steps.front().periods);
    for (std::size_t i = 0; i < count; ++i) {
        while (end <= (static_cast<double>(i) + 0.5) * periods) end += path.steps[++step].periods;
        even.steps.push_back({path.steps[step].foci, static_cast<std::uint32_t>(dwell)});
    }
    return even;
}

}  // namespace

RingPlayer::RingPlayer(link::Commands& device, link::Clock& clock, const Array& array, std::size_t steps, Method method,
                       std::uint16_t watchdog_ms, const std::vector<DevicePart>& parts)
    : Player(device, clock, choose_timer(array, Core{device.identity().name, device.identity().core()}), watchdog_ms),
      array_(array),
      parts_(parts.empty() ? one_part(device, array) : parts),
      steps_(steps),
      method_(method) {
    array.require_one_weight();
    const link::Identity& board = device.identity();
    for (const DevicePart& part : parts_)
        if (part.elements > part.device.identity().channels)
            throw bad_input("board", fmt::format("it has {} channels; the array {} has {} elements",
                                                 part.device.identity().channels, array.name, part.elements));
    free_at_.assign(std::min<std::size_t>(most_banks, board.records / steps), 0);
    if (free_at_.size() < 3)
        throw bad_input("board", fmt::format("it has {} records; rings of {} steps need three times as many",
                                             board.records, steps));
    if (board.live_depth < steps + most_low_water + 1)
        throw bad_input("board", fmt::format("its live FIFO has {} places; rings of {} steps need {}", board.live_depth,
                                             steps, steps + most_low_water + 1));
}

RingPlayer::Ring RingPlayer::made(const Path& path, std::uint64_t shot, double shot_s) const {
    require_sound(path);
    if (!path.modulation.samples.empty()) throw bad_argument("ring", "expected one without a modulation");
    Ring ring;
    ring.path = in_steps(path, steps_);
    ring.about.shot = shot;
    ring.about.shot_s = shot_s;
    ring.dwell = static_cast<std::uint16_t>(ring.path.steps.front().periods);
    return ring;
}

std::optional<std::size_t> RingPlayer::free_bank() const {
    for (std::size_t bank = 0; bank < free_at_.size(); ++bank)
        if ((!present_ || present_->bank != bank) && fifo_->left() >= free_at_[bank]) return bank;
    return {};
}

void RingPlayer::give_bank(Ring& ring, std::size_t bank) const {
    ring.bank = bank;
    std::vector<PathStep> loud;
    for (const PathStep& step : ring.path.steps)
        if (!step.foci.empty()) loud.push_back(step);
    const std::vector<double> full(loud.size(), 1.0);
    const auto elements = static_cast<std::uint32_t>(array_.elements.size());
    const std::vector<Record> records = records_of(array_, timer_, elements, loud, full, method_);
    std::size_t next = 0;
    for (std::size_t j = 0; j < steps_; ++j) {
        const auto index = static_cast<std::uint16_t>(bank * steps_ + j + 1);
        ring.indices.push_back(ring.path.steps[j].foci.empty() ? std::uint16_t{0} : index);
        if (ring.path.steps[j].foci.empty()) continue;
        std::size_t first = 0;
        for (std::size_t k = 0; k < parts_.size(); first += parts_[k++].elements)
            ring.writes.emplace_back(k, write_of(part_of(records[next], first, parts_[k]), index));
        ++next;
    }
    ring.about.first_index = ring.indices[ring.first_loud()];
    std::reverse(ring.writes.begin(), ring.writes.end());
}

void RingPlayer::replace(const Path& ring, std::uint64_t shot, double shot_s) {
    fades_.clear();
    next_ = made(ring, shot, shot_s);
}

void RingPlayer::silence() {
    fades_.clear();
    next_.reset();
    if (!present_) return;
    push(std::vector<std::uint16_t>{0}, 0);
    free_at_[present_->bank] = fifo_->pushed + 1;
    present_.reset();
}

void RingPlayer::fade() {
    if (fading() || !present_) return;
    next_.reset();
    for (const double part : {2.0 / 3.0, 1.0 / 3.0}) {
        Path weaker = present_->path;
        for (PathStep& step : weaker.steps)
            for (Focus& focus : step.foci) focus.amplitude *= part;
        fades_.push_back(std::move(weaker));
    }
}

void RingPlayer::push_turn() {
    const double waiting = level();
    entry_s_ = timer_.period_s() * present_->dwell;
    const std::size_t first = present_->first_loud();
    const std::uint64_t entry = fifo_->pushed + first;
    push(present_->indices, present_->dwell);
    if (time_) ask();  // which period it is in
    free_at_[present_->bank] = fifo_->pushed + 1;
    if (present_->begun) return;
    present_->begun = true;
    if (!present_->faded) begins(present_->about, entry, waiting + static_cast<double>(first));
}

bool RingPlayer::service() {
    if (present_ && level() <= static_cast<double>(low_water(timer_.period_s() * present_->dwell))) {
        push_turn();
        if (present_->faded && fades_.empty() && !next_) silence();  // the weakest copy plays one turn
        return true;
    }
    if (!fades_.empty() && !next_ && present_ && present_->begun) {
        next_ = made(fades_.front(), 0, 0.0);
        next_->faded = true;
    }
    if (!next_) return idle();
    bring();
    return true;
}

/// The next bit of bringing a ring onto the board.
void RingPlayer::bring() {
    if (next_->indices.empty()) {
        if (const std::optional<std::size_t> bank = free_bank()) {
            give_bank(*next_, *bank);
            return;
        }
        // The answers that are under way tell which bank has become free; if there are none, one is asked for.
        if (device_.unanswered() == 0) submit({interface::Command::status, {}});
        device_.wait(device_.unanswered() - 1);
    } else if (!next_->writes.empty()) {
        for (std::size_t i = 0; i < parts_.size(); ++i) {  // a record, of which each part has its own
            auto& [part, request] = next_->writes.back();
            submit_to(parts_[part].device, std::move(request));
            next_->writes.pop_back();
        }
        device_.wait(most_unanswered);
    } else if (device_.unanswered() > 0) {  // only what the board has acknowledged may be played
        device_.wait(device_.unanswered() - 1);
    } else {
        present_ = std::move(next_);
        next_.reset();
        if (present_->faded) fades_.pop_front();
    }
}

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

namespace {

constexpr double record_frame_bytes = 16.0;  // beside a record: command, address, CRC and framing
constexpr std::size_t fewest_steps = 6;      // that still draw something
constexpr std::size_t most_steps = 60;
constexpr std::size_t others_in_fifo = 8;  // beside a turn
constexpr std::size_t banks = 3;
constexpr double record_share = 0.8;        // may go into records
constexpr double usual_interval_s = 20e-3;  // between two paths: fewer steps that come faster do not feel better
constexpr double slack = 1.02;              // of what a line is measured to do
constexpr double longest_interval_s = 0.1;  // that still follows a hand

bool computes_foci(const std::vector<DevicePart>& parts) {
    return std::ranges::all_of(parts, [](const DevicePart& part) {
        const link::Identity& board = part.device.identity();
        return interface::has(board.features, interface::Feature::live_foci) && board.channels == part.elements;
    });
}

/// Boards with a role play nothing else.
void require_common_period(const Timer& timer, const link::Identity& board) {
    constexpr std::uint32_t common_hz = 40'000;
    const std::uint32_t wanted = board.clock_hz / common_hz, made = timer.prescaler * timer.cycle_ticks;
    if (made != wanted)
        throw bad_input("rig", fmt::format("its carrier period is {} clocks, but boards in step play only records of "
                                           "{}, which is a period of {} Hz; take arrays with that carrier",
                                           made, wanted, common_hz));
}

ChosenPlayer with_foci(link::Commands& device, link::Clock& clock, const Array& array, const PlayerOptions& options,
                       const Line& line) {
    auto player =
        std::make_unique<FocusPlayer>(device, clock, array, options.pace, line, options.watchdog_ms, options.parts);
    const FocusPace pace = player->pace();
    std::string about = fmt::format("the board computes foci: {} at a time, new ones every {:.2f} ms", pace.foci,
                                    1e3 * pace.periods * player->timer().period_s());
    if (pace.foci < options.pace.foci) about += fmt::format("; up to {} play in turn", options.pace.foci);
    const double wanted_s = options.pace.periods / array.carrier_hz;
    const double parts = std::ceil(static_cast<double>(options.pace.foci) / static_cast<double>(pace.foci));
    const double takes_s = parts * pace.periods * player->timer().period_s();
    std::string shortfall;
    if (takes_s > slack * wanted_s)
        shortfall = fmt::format(
            "the line cannot keep up: each place of {} is renewed every {:.2f} ms where {:.2f} ms are "
            "wanted, so paths have fewer places; take a faster line, at least {:.0f} baud",
            options.pace.foci, 1e3 * takes_s, 1e3 * wanted_s, 10.0 * line.bytes_s * takes_s / wanted_s);
    return {std::move(player), std::move(about), 0.0, std::move(shortfall)};
}

ChosenPlayer with_records(link::Commands& device, link::Clock& clock, const Array& array, const PlayerOptions& options,
                          const Line& line) {
    const link::Identity& board = device.identity();
    if (options.slow)
        throw Error(ErrorCode::device, "board",
                    "it plays records, too few for a pass of this algorithm, which takes seconds; take a board that "
                    "computes foci, or another algorithm");
    // Each board has a line of its own.
    std::uint32_t most_channels = 0;
    for (const DevicePart& part : options.parts)
        most_channels = std::max(most_channels, part.device.identity().channels);
    const double record_s =
        (2.0 * static_cast<double>(record_words(most_channels)) + record_frame_bytes) / line.bytes_s;
    std::size_t steps = options.steps;
    if (steps == 0) {
        const double interval_s = std::max(1.0 / options.rate_hz, usual_interval_s);
        const std::size_t room =
            std::min<std::size_t>({board.records / banks, board.live_depth - others_in_fifo, most_steps});
        steps = std::clamp<std::size_t>(static_cast<std::size_t>(record_share * interval_s / record_s), fewest_steps,
                                        std::max(room, fewest_steps));
    }
    const double path_s = static_cast<double>(steps) * record_s;
    if (path_s > longest_interval_s)
        throw Error(ErrorCode::device, "board",
                    fmt::format("the {} records of a path take {:.0f} ms on this line, which is too slow to follow a "
                                "hand; take a board that computes foci, or a line of at least {:.0f} baud",
                                steps, 1e3 * path_s, 10.0 * line.bytes_s * path_s / longest_interval_s));
    std::string shortfall;
    if (path_s * options.rate_hz > slack)
        shortfall = fmt::format(
            "the line cannot keep up with {:.0f} frames a second, and the rest are skipped; take a "
            "board that computes foci, or at least {:.0f} baud",
            options.rate_hz, 10.0 * line.bytes_s * path_s * options.rate_hz);
    return {
        std::make_unique<RingPlayer>(device, clock, array, steps, options.method, options.watchdog_ms, options.parts),
        fmt::format("the board plays records: {} a path, which take {:.1f} ms on the line, so it follows {:.0f} "
                    "frames a second",
                    steps, 1e3 * path_s, std::min(options.rate_hz, 1.0 / path_s)),
        path_s, std::move(shortfall)};
}

}  // namespace

ChosenPlayer choose_player(link::Commands& device, link::Clock& clock, const Array& array,
                           const PlayerOptions& options) {
    PlayerOptions all = options;
    if (all.parts.empty()) all.parts = one_part(device, array);
    const Line line = measured_line(device, clock);
    ChosenPlayer chosen = computes_foci(all.parts) ? with_foci(device, clock, array, all, line)
                                                   : with_records(device, clock, array, all, line);
    if (all.parts.size() > 1) require_common_period(chosen.player->timer(), device.identity());
    return chosen;
}

}  // namespace haptogram::live
