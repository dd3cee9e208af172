// SPDX-License-Identifier: Apache-2.0
#include "tiles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::sim {
namespace {

constexpr std::uint32_t wander_clocks = 8192;  // between two small changes of a frequency
constexpr Femtoseconds uncertain =
    100 * 1'000;                             // by so much to either side an edge of the wire is seen earlier or later
constexpr Femtoseconds slice = microsecond;  // between two looks at a serial line

}  // namespace

void Tiles::add(std::unique_ptr<Board> board, const Oscillator& oscillator) {
    Tile tile;
    // In reset for as long as somebody else's time runs: a board begins when its first clock comes.
    tile.board = std::move(board);
    tile.oscillator = oscillator;
    const double nominal = 1e15 / tile.board->parameters().clock_hz;
    tile.period_fs = nominal / (1.0 + oscillator.offset_ppm * 1e-6);
    tile.next_fs = oscillator.phase * nominal;
    tiles_.push_back(std::move(tile));
}

void Tiles::see_wire(Tile& tile, Femtoseconds now) {
    while (!tile.arriving.empty() && tile.arriving.front().at <= now) {
        tile.level = tile.arriving.front().level;
        tile.arriving.pop_front();
    }
    tile.board->drive_sync(tile.connected && tile.level);
}

void Tiles::wander(Tile& tile) {
    const double limit = tile.oscillator.wander_ppm;
    const double step = std::uniform_real_distribution<double>(-0.1, 0.1)(random_) * limit;
    tile.wander_ppm = std::clamp(tile.wander_ppm + step, -limit, limit);
    tile.period_fs =
        1e15 / tile.board->parameters().clock_hz / (1.0 + (tile.oscillator.offset_ppm + tile.wander_ppm) * 1e-6);
    tile.clocks_to_wander = wander_clocks;
}

void Tiles::connect(std::size_t board, bool connected) { tiles_[board].connected = connected; }

void Tiles::drive_wire(Femtoseconds at, bool level) {
    for (Tile& tile : tiles_) {
        const auto delay = std::llround(tile.oscillator.wire_delay_s * 1e15);
        tile.arriving.push_back(
            {at + delay + std::uniform_int_distribution<Femtoseconds>(-uncertain, uncertain)(random_), level});
    }
}

SimulatedTiles::SimulatedTiles(std::string_view model, std::span<const Oscillator> boards, std::uint32_t seed)
    : Tiles(seed) {
    for (const Oscillator& oscillator : boards) {
        auto board = std::make_unique<SimulatedBoard>(
            model, SimulatedBoardOptions{.power_up_seed = static_cast<std::uint32_t>(random_() >> 1)});
        boards_.push_back(board.get());
        add(std::move(board), oscillator);
    }
}

void SimulatedTiles::clock(std::size_t i) {
    Tile& tile = tiles_[i];
    now_ = std::llround(tile.next_fs);
    see_wire(tile, now_);
    if (chained_) join(i);
    tile.board->run(1);
    if (i == 0 && tile.board->outputs().sync != wire_) {
        wire_ = !wire_;
        drive_wire(now_, wire_);
    }
    tile.next_fs += tile.period_fs;
    if (tile.oscillator.wander_ppm > 0.0 && tile.clocks_to_wander-- == 0) wander(tile);
}

/// What a board sees of its neighbours in a chain at its next clock.
void SimulatedTiles::join(std::size_t i) {
    SimulatedBoard& board = *boards_[i];
    if (i > 0) {
        board.force_line(tiles_[i].cut || boards_[i - 1]->outputs().next);
        // Nobody listens to this board's own end.
        if (board.received() > 4096) static_cast<void>(board.receive());
    }
    board.drive_next(i + 1 == size() || tiles_[i + 1].cut || boards_[i + 1]->outputs().tx);
}

void SimulatedTiles::run(Femtoseconds duration) {
    const auto end = static_cast<double>(now_ + duration);
    for (;;) {
        std::size_t first = 0;
        for (std::size_t i = 1; i < size(); ++i)
            if (tiles_[i].next_fs < tiles_[first].next_fs) first = i;
        if (tiles_[first].next_fs > end) break;
        clock(first);
    }
    now_ = std::llround(end);
}

ReferenceTiles::ReferenceTiles(std::string_view configuration, std::span<const Oscillator> boards, std::uint32_t seed)
    : Tiles(seed), begins_(boards.size()) {
    for (const Oscillator& oscillator : boards) add(std::make_unique<ReferenceBoard>(configuration), oscillator);
    if (boards.empty()) return;
    tiles_[0].board->on_sync([this](const SyncChange& change) { drive_wire(time_of(0, change.clock), change.level); });
}

Femtoseconds ReferenceTiles::time_of(std::size_t board, Clock clock) const {
    const Begin& begin = begins_[board];
    return std::llround(begin.fs + static_cast<double>(clock - begin.clock) * tiles_[board].period_fs);
}

void ReferenceTiles::run(Femtoseconds duration) {
    const auto end = static_cast<double>(now_ + duration);
    for (std::size_t i = 0; i < size(); ++i) run_to(i, end);
    now_ = std::llround(end);
}

void ReferenceTiles::run_to(std::size_t i, double end_fs) {
    Tile& tile = tiles_[i];
    while (tile.next_fs <= end_fs) {
        see_wire(tile, std::llround(tile.next_fs));
        double clocks = std::floor((end_fs - tile.next_fs) / tile.period_fs) + 1.0;
        if (!tile.arriving.empty()) {
            const double change = static_cast<double>(tile.arriving.front().at) - tile.next_fs;
            clocks = std::min(clocks, std::max(1.0, std::ceil(change / tile.period_fs)));
        }
        if (tile.oscillator.wander_ppm > 0.0) clocks = std::min(clocks, tile.clocks_to_wander + 1.0);
        begins_[i] = {tile.next_fs, tile.board->now()};
        tile.board->run(static_cast<std::uint64_t>(clocks));
        tile.next_fs += clocks * tile.period_fs;
        if (tile.oscillator.wander_ppm <= 0.0) continue;
        const auto passed = static_cast<std::uint32_t>(clocks);
        if (passed > tile.clocks_to_wander)
            wander(tile);
        else
            tile.clocks_to_wander -= passed;
    }
}

void ReferenceTiles::chain() {
    throw bad_argument("chain",
                       "reference boards do not pass the serial line on; give each a port of its own, or take the "
                       "Verilated cores (--model rtl)");
}

std::vector<std::uint8_t> TileTransport::read(std::chrono::microseconds patience) {
    while (!board_.line_idle() && board_.received() == 0) tiles_.run(slice);
    for (auto left = patience.count(); left > 0 && board_.received() == 0; --left) tiles_.run(slice);
    return board_.receive();
}

}  // namespace haptogram::sim
