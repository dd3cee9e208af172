// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/rig_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/live_feed.hpp"
#include "haptogram/link/rig_tiles.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

using namespace std::chrono_literals;

/// What one frame carries: entries of one dwell.
struct Entries {
    std::vector<std::uint16_t> indices;
    std::uint16_t dwell = 0;
    bool silence = false;  ///< the silence for good behind the source's last entry

    [[nodiscard]] std::uint64_t periods() const { return indices.size() * std::max<std::uint64_t>(1, dwell); }
};

/// Cuts a source into frames; silence for good comes last, because running out of entries would count as an underrun.
class Frames {
public:
    Frames(StreamSource& source, const Image& image, std::size_t most) : source_(source), image_(image), most_(most) {}

    /// The next frame, waiting for its first entry at most so long; empty when there is none yet, or none any more.
    std::optional<Entries> next(std::chrono::milliseconds patience) {
        Entries frame;
        while (frame.indices.size() < most_ && fill(frame.indices.empty() ? patience : 0ms) &&
               (frame.indices.empty() || ahead_->dwell == frame.dwell)) {
            frame.indices.push_back(ahead_->index);
            frame.dwell = std::exchange(ahead_, {})->dwell;
        }
        if (!frame.indices.empty()) return frame;
        if (ended_ || !source_.ended()) return {};
        ended_ = true;
        return Entries{{0}, 0, true};
    }
    [[nodiscard]] bool ended() const { return ended_; }

private:
    bool fill(std::chrono::milliseconds patience) {
        if (ahead_) return true;
        ahead_ = source_.next(patience);
        if (ahead_ && ahead_->index != 0 && !place_of(image_, ahead_->index))
            throw bad_input("stream", fmt::format("found index {}, expected 0 for silence or {}", ahead_->index,
                                                  records_in_words(image_)));
        return ahead_.has_value();
    }

    StreamSource& source_;
    const Image& image_;
    std::size_t most_;
    std::optional<SequenceEntry> ahead_;
    bool ended_ = false;
};

/// The live FIFOs of all tiles, which get the same entries.
class RigFeed {
public:
    RigFeed(std::span<const Tile> tiles, PlayingTiles& playing) : tiles_(tiles), playing_(playing) {
        for (const Tile& tile : tiles)
            with(tile, [&](Client& device) { feeds_.emplace_back(device, device.identity()); });
    }

    [[nodiscard]] std::size_t frame() const { return std::ranges::min_element(feeds_, {}, &LiveFeed::frame)->frame(); }
    /// Asks all tiles how far they are. That also keeps the watchdogs quiet.
    void ask() {
        playing_.ask();
        for (std::size_t i = 0; i < tiles_.size(); ++i)
            if (const auto& status = playing_.statuses()[i]) feeds_[i].learn(*status);
        if (together_ && strayed()) together_ = ends_known_ = false;
        if (ends_known_ || !empty()) return;
        // Each tile may have the last entry before it and the one before that.
        playing_until_ = playing_.period() + last_two_.first + last_two_.second + 1;
        ends_known_ = true;
    }
    /// Whether what is pushed now plays at the same time on all tiles.
    [[nodiscard]] bool goes_on() const { return together_ && playing_.period() + on_the_way < playing_until_; }
    /// Whether all tiles have played what they had, and hold the last of it.
    [[nodiscard]] bool holds() const {
        return ends_known_ && empty() && playing_.all([&](const Status& status) {
            return status.period.value_or(0) > playing_until_ + 1 || playing_until_ == 0;
        });
    }
    /// Whether the fullest FIFO has room for a frame.
    [[nodiscard]] bool has_room() const {
        std::size_t least = frame();
        for (std::size_t i = 0; i < tiles_.size(); ++i)
            if (!playing_.is_lost(i)) least = std::min(least, feeds_[i].room());
        return least == frame();
    }
    /// To all tiles, without waiting for their answers.
    void push(const Entries& entries) {
        playing_.each([&](const Tile& tile) { push_to(tile, entries); });
        count(entries);
    }
    /// Has the tiles begin with these frames in a period that they agree on.
    void begin(std::span<const Entries> frames) {
        const bool outputs_on = begun_;
        underruns_.clear();
        for (const auto& status : playing_.statuses()) underruns_.push_back(status ? status->underruns : 0);
        const auto arm = [&](const Tile& tile, When when) {
            if (!outputs_on) begin_modulation(tile, when);
            tile.device.push(frames[0].indices, frames[0].dwell, when);
            for (const Entries& entries : frames.subspan(1)) push_to(tile, entries);  // they wait behind the first
        };
        const std::uint64_t soonest = playing_.period() + on_the_way + frames.size() * frame_on_the_way;
        playing_until_ = playing_.begin_together(arm, soonest, outputs_on);
        begun_ = together_ = true;
        for (const Entries& entries : frames) count(entries);
    }

private:
    void push_to(const Tile& tile, const Entries& entries) {
        feeds_[static_cast<std::size_t>(&tile - tiles_.data())].push(entries.indices, entries.dwell);
    }
    void count(const Entries& entries) {
        playing_until_ += entries.periods();
        const std::uint64_t each = entries.periods() / entries.indices.size();
        last_two_ = {entries.indices.size() > 1 ? each : last_two_.second, each};
        if (entries.dwell == 0) together_ = false;  // what comes next would end it when it arrives
    }
    [[nodiscard]] bool empty() const {
        return playing_.all([](const Status& status) { return status.live_level == 0; });
    }
    /// Whether a tile has run out of entries in the midst of them. At their end all do.
    [[nodiscard]] bool strayed() const {
        for (std::size_t i = 0; i < tiles_.size(); ++i) {
            const auto& status = playing_.statuses()[i];
            if (!status) continue;
            const int at_the_end = status->period.value_or(0) + 1 >= playing_until_ ? 1 : 0;
            if (static_cast<std::uint16_t>(status->underruns - underruns_[i]) > at_the_end) return true;
        }
        return false;
    }

    /// What takes longer than this to arrive at the last tile could come too late there.
    static constexpr std::uint64_t on_the_way = 80;        // carrier periods, 2 ms
    static constexpr std::uint64_t frame_on_the_way = 20;  // of one of many to all tiles

    std::span<const Tile> tiles_;
    PlayingTiles& playing_;
    std::vector<LiveFeed> feeds_;
    std::vector<std::uint16_t> underruns_;  // before the tiles began together
    bool begun_ = false;
    bool together_ = false;            // all play the same, and what is pushed follows without a gap
    bool ends_known_ = true;           // what all have ends with playing_until_; an entry of dwell 0 is held for longer
    std::uint64_t playing_until_ = 0;  // period
    std::pair<std::uint64_t, std::uint64_t> last_two_{0, 0};  // periods that the last two entries last
};

/// What is there already to begin with: enough to play for a while, but so few frames that all tiles soon have them.
std::vector<Entries> first_frames(Entries first, Frames& frames, std::size_t most) {
    constexpr std::uint64_t enough = 400;  // carrier periods, 10 ms
    constexpr std::size_t most_frames = 32;
    std::vector<Entries> found;
    std::size_t entries = 0;
    std::uint64_t periods = 0;
    std::optional<Entries> next = std::move(first);
    while (next) {
        entries += next->indices.size();
        periods += next->periods();
        found.push_back(std::move(*next));
        const bool full = entries + most > 4 * most || periods >= enough || found.size() == most_frames;
        next = full || found.back().dwell == 0 ? std::nullopt : frames.next(0ms);
    }
    return found;
}

}  // namespace

std::uint32_t highest_index(const Image& image) {
    return image.record_count() == 0 ? 0 : index_of(image, image.record_count() - 1);
}

std::string records_in_words(const Image& image) {
    return fmt::format("one of the {} records of the images, from {} to {}", image.record_count(), index_of(image, 0),
                       highest_index(image));
}

RigPlayed stream(std::span<const Tile> tiles, const RigSettings& settings, StreamSource& source,
                 const RigWatch& watch) {
    prepare(tiles);
    PlayingTiles playing(tiles, settings);
    RigFeed feed(tiles, playing);
    Frames frames(source, tiles[0].image, feed.frame());
    RigTeller tell(watch, tiles.front().device.clock());
    const auto stream_on = [&] {
        const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
        bool going = true;
        const auto go_on = [&] {
            going = tell(playing) && (settings.seconds == 0.0 || tell.seconds() < settings.seconds);
            return going;
        };
        const auto has_gone = [&](const Entries& entries) {
            if (!entries.silence) tell.sent += entries.indices.size();
        };
        std::optional<Entries> next;
        while (go_on()) {
            if (!next) next = frames.next(pause);
            if (!next && frames.ended()) break;
            feed.ask();
            if (!next) continue;
            if (!feed.goes_on() && feed.holds()) {
                const std::vector<Entries> first = first_frames(*std::exchange(next, {}), frames, feed.frame());
                feed.begin(first);
                for (const Entries& entries : first) has_gone(entries);
            } else if (!feed.goes_on() || !feed.has_room()) {
                playing.wait(1ms);
            }
            while (next && feed.goes_on() && feed.has_room()) {
                feed.push(*next);
                has_gone(*next);
                next = frames.next(0ms);
            }
        }
        while (going && !playing.all(is_over)) {
            playing.wait(pause);
            feed.ask();
            if (playing.all(is_over)) feed.ask();  // as sure_status() does
            static_cast<void>(go_on());
        }
    };
    if (then_off(stream_on, [&] { return playing.off(); })) tell.interrupt();
    return tell.outcome(playing);
}

RigPlayed stream(std::span<const Tile> tiles, const RigSettings& settings, std::uint64_t loops,
                 const Progress& progress, const RigWatch& watch) {
    if (tiles.empty()) throw bad_argument("rig", "it has no tiles; name at least one");
    // As for one device: the sequence that is there would play other records from now on.
    std::vector<Image> images;
    for (const Tile& tile : tiles) images.push_back(tile.image);
    std::vector<SequenceEntry> entries;
    std::vector<Tile> emptied;
    const double part = 1.0 / static_cast<double>(tiles.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        entries = std::exchange(images[i].sequence, {});
        emptied.push_back({tiles[i].device, images[i], tiles[i].name});
        require_fits(images[i], tiles[i].device.identity(), tiles[i].name);
        with(tiles[i], [&](Client& device) {
            upload(
                device, images[i],
                progress.in_stage("upload").between(part * static_cast<double>(i), part * static_cast<double>(i + 1)));
        });
    }
    RepeatedEntries source(std::move(entries), loops);
    return stream(emptied, settings, source, watch);
}

}  // namespace haptogram::link
