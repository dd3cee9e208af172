// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/rig_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/rig_tiles.hpp"

namespace haptogram::link {
namespace {

using namespace std::chrono_literals;
using interface::Command;

constexpr std::uint64_t push_on_the_way = 80;  // carrier periods, 2 ms

bool pushes(const Request& request) {
    return request.command == Command::push || request.command == Command::push_foci;
}

std::uint16_t dwell_of(const Request& request) {
    return static_cast<std::uint16_t>(request.payload.at(0) | request.payload.at(1) << 8);
}

/// One device with the channels of all, and no more of anything else than each has.
Identity identity_of(std::span<const Tile> tiles) {
    Identity all = tiles.front().device.identity();
    all.channels = 0;
    for (const Tile& tile : tiles) {
        Identity one = tile.device.identity();
        all.channels += one.channels;
        all.records = std::min(all.records, one.records);
        all.live_depth = std::min(all.live_depth, one.live_depth);
        all.frame_bytes = std::min(all.frame_bytes, one.frame_bytes);
        const Identity& first = tiles.front().device.identity();
        if (one.clock_hz != first.clock_hz || one.timing_bits != first.timing_bits ||
            one.pulse_bits != first.pulse_bits || one.width_bits != first.width_bits || one.foci != first.foci ||
            one.features != first.features)
            throw Error(ErrorCode::device, tile.name,
                        fmt::format("it is a {}, and {} is a {}; a rig plays on boards that are alike but for their "
                                    "channels",
                                    one.name, tiles.front().name, first.name));
    }
    return all;
}

}  // namespace

/// What the tiles' last statuses said.
struct RigCommands::Heard {
    bool together = false;                 ///< all play the same, and what is pushed follows without a gap
    bool on = false;                       ///< the outputs shall be on
    std::vector<std::uint16_t> underruns;  ///< of each tile, when all began together
    std::string trouble;                   ///< a tile has turned its outputs off

    void hear(const Tile& tile, std::size_t place, const Status& status) {
        if (underruns[place] != status.underruns) together = false;
        if (on && !status.enabled && trouble.empty()) trouble = tile.name;
    }
};

/// One request to all tiles.
struct RigCommands::Asked {
    std::size_t left = 0;
    std::uint16_t level = 0, underruns = 0;
    Reply first;
    std::function<void(const Reply&)> done;

    /// @param status  of the tile, if that was asked for
    void answer(std::size_t place, const Reply& reply, const Status* status) {
        level = std::max(level, reply.live_level);
        if (status != nullptr) underruns = static_cast<std::uint16_t>(underruns + status->underruns);
        if (place == 0) first = reply;
        if (--left > 0 || !done) return;
        first.live_level = level;
        // A rig has run dry wherever one of its tiles has.
        if (status != nullptr) interface::status_field::underruns.set(first.data, underruns);
        done(first);
    }
};

RigCommands::RigCommands(std::span<const Tile> tiles, const RigSettings& settings)
    : tiles_(tiles), settings_(settings), heard_(std::make_shared<Heard>()) {
    if (tiles.empty()) throw bad_argument("rig", "it has no tiles; name at least one");
    identity_ = identity_of(tiles);
    keep_together(tiles);
    playing_ = std::make_unique<PlayingTiles>(tiles_, settings_);
    for (const auto& status : playing_->statuses()) heard_->underruns.push_back(status->underruns);
}

RigCommands::~RigCommands() = default;

void RigCommands::submit(Request request, std::function<void(const Reply&)> done) {
    require_on();
    const bool status = request.command == Command::status;
    if (request.command == Command::enable) heard_->on = true;
    if (pushes(request)) {
        const std::uint16_t dwell = dwell_of(request);
        const bool follows = heard_->together;
        if (!follows) begin(request);
        heard_->together = dwell > 0;  // what comes behind silence would end it when it arrives
        last_dwell_ = dwell;
        if (!follows) {
            if (done) done(begun_);
            return;
        }
    }
    const auto asked = std::make_shared<Asked>();
    asked->left = tiles_.size();
    asked->done = std::move(done);
    for (std::size_t i = 0; i < tiles_.size(); ++i)
        with(tiles_[i], [&](Client& device) {
            device.submit(request, [asked, i, status, heard = heard_, tile = &tiles_[i]](const Reply& reply) {
                if (!status) return asked->answer(i, reply, nullptr);
                const Status told = to_status(reply.data);
                heard->hear(*tile, i, told);
                asked->answer(i, reply, &told);
            });
        });
}

/// Has all tiles begin with this push.
void RigCommands::begin(const Request& request) {
    playing_->ask();
    while (!playing_->all([](const Status& status) { return status.live_level == 0; })) {
        playing_->wait(1ms);
        playing_->ask();
    }
    begun_ = {};
    const auto arm = [&](const Tile& tile, When when) { begun_ = tile.device.request(request, when); };
    // Each tile may have the last entry before it.
    playing_->begin_together(arm, playing_->period() + last_dwell_ + push_on_the_way, heard_->on);
    heard_->on = true;
    ++beginnings_;
    for (std::size_t i = 0; i < tiles_.size(); ++i)
        if (const auto& status = playing_->statuses()[i]) heard_->underruns[i] = status->underruns;
}

void RigCommands::require_on() {
    if (heard_->trouble.empty()) return;
    const std::string tile = std::exchange(heard_->trouble, {});
    playing_->ask();  // says why, once they have begun
    throw Error(ErrorCode::device, tile, "it has turned its outputs off; all tiles are switched off");
}

void RigCommands::tell(Request request) {
    for (const Tile& tile : tiles_) tile.device.tell(request);
}

void RigCommands::flush() {
    for (const Tile& tile : tiles_) with(tile, [](Client& device) { device.flush(); });
}

void RigCommands::wait(std::size_t most_unanswered) {
    for (const Tile& tile : tiles_) with(tile, [&](Client& device) { device.wait(most_unanswered); });
    require_on();
}

std::size_t RigCommands::unanswered() const {
    std::size_t most = 0;
    for (const Tile& tile : tiles_) most = std::max(most, tile.device.unanswered());
    return most;
}

void RigCommands::drop() {
    for (const Tile& tile : tiles_) tile.device.drop();
}

std::uint64_t RigCommands::retransmissions() const {
    std::uint64_t all = 0;
    for (const Tile& tile : tiles_) all += tile.device.retransmissions();
    return all;
}

bool RigCommands::turn_off() {
    heard_->on = heard_->together = false;
    heard_->trouble.clear();
    const std::string trouble = playing_->off();
    if (!trouble.empty() && settings_.warn) settings_.warn(trouble);
    return trouble.empty();
}

void RigCommands::keep_alive_every(std::chrono::milliseconds pause) {
    for (const Tile& tile : tiles_) tile.device.keep_alive_every(pause);
}

}  // namespace haptogram::link
