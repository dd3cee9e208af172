// SPDX-License-Identifier: Apache-2.0
#include "tiles.hpp"

#include <algorithm>
#include <cmath>

namespace haptogram::sim {
namespace {

constexpr std::uint32_t wander_clocks = 8192;  // between two small changes of a frequency
constexpr Femtoseconds uncertain =
    100 * 1'000;                             // by so much to either side an edge of the wire is seen earlier or later
constexpr Femtoseconds slice = microsecond;  // between two looks at a serial line

}  // namespace

Tiles::Tiles(std::string_view model, std::span<const Oscillator> boards, std::uint32_t seed) : random_(seed) {
    for (const Oscillator& oscillator : boards) {
        Tile tile;
        // In reset for as long as somebody else's time runs: a board begins when its first clock comes.
        tile.board = std::make_unique<SimulatedBoard>(
            model, SimulatedBoardOptions{.power_up_seed = static_cast<std::uint32_t>(random_() >> 1)});
        tile.oscillator = oscillator;
        const double nominal = 1e15 / tile.board->parameters().clock_hz;
        tile.period_fs = nominal / (1.0 + oscillator.offset_ppm * 1e-6);
        tile.next_fs = oscillator.phase * nominal;
        tiles_.push_back(std::move(tile));
    }
}

void Tiles::wander(Tile& tile) {
    const double limit = tile.oscillator.wander_ppm;
    const double step = std::uniform_real_distribution<double>(-0.1, 0.1)(random_) * limit;
    tile.wander_ppm = std::clamp(tile.wander_ppm + step, -limit, limit);
    tile.period_fs =
        1e15 / tile.board->parameters().clock_hz / (1.0 + (tile.oscillator.offset_ppm + tile.wander_ppm) * 1e-6);
    tile.clocks_to_wander = wander_clocks;
}

void Tiles::clock(Tile& tile) {
    now_ = std::llround(tile.next_fs);
    while (!tile.arriving.empty() && tile.arriving.front().at <= now_) {
        tile.level = tile.arriving.front().level;
        tile.arriving.pop_front();
    }
    tile.board->drive_sync(tile.connected && tile.level);
    if (chained_) join(tile);
    tile.board->run(1);
    if (&tile == tiles_.data() && tile.board->outputs().sync != wire_) {
        wire_ = !wire_;
        drive_wire(now_, wire_);
    }
    tile.next_fs += tile.period_fs;
    if (tile.oscillator.wander_ppm > 0.0 && tile.clocks_to_wander-- == 0) wander(tile);
}

/// What a board sees of its neighbours in a chain at its next clock.
void Tiles::join(Tile& tile) {
    Tile* const next = &tile + 1;
    if (&tile != tiles_.data()) {
        tile.board->force_line(tile.cut || (&tile - 1)->board->outputs().next);
        // Nobody listens to this board's own end.
        if (tile.board->received() > 4096) static_cast<void>(tile.board->receive());
    }
    tile.board->drive_next(next == tiles_.data() + tiles_.size() || next->cut || next->board->outputs().tx);
}

void Tiles::run(Femtoseconds duration) {
    const auto end = static_cast<double>(now_ + duration);
    for (;;) {
        Tile* first = tiles_.data();
        for (Tile& tile : tiles_)
            if (tile.next_fs < first->next_fs) first = &tile;
        if (first->next_fs > end) break;
        clock(*first);
    }
    now_ = std::llround(end);
}

void Tiles::connect(std::size_t board, bool connected) { tiles_[board].connected = connected; }

void Tiles::drive_wire(Femtoseconds at, bool level) {
    for (Tile& tile : tiles_) {
        const auto delay = std::llround(tile.oscillator.wire_delay_s * 1e15);
        tile.arriving.push_back(
            {at + delay + std::uniform_int_distribution<Femtoseconds>(-uncertain, uncertain)(random_), level});
    }
}

std::vector<std::uint8_t> TileTransport::read(std::chrono::microseconds patience) {
    while (!board_.line_idle() && board_.received() == 0) tiles_.run(slice);
    for (auto left = patience.count(); left > 0 && board_.received() == 0; --left) tiles_.run(slice);
    return board_.receive();
}

}  // namespace haptogram::sim
