// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "haptogram/link/transport.hpp"
#include "simulated_board.hpp"

namespace haptogram::sim {

/// Time that all boards share, in femtoseconds from the beginning: 2.5 hours fit.
using Femtoseconds = std::int64_t;
inline constexpr Femtoseconds microsecond = 1'000'000'000;

/// The oscillator of one board.
struct Oscillator {
    double offset_ppm = 0.0;    ///< how much faster it is than its nominal frequency
    double wander_ppm = 0.0;    ///< it changes by up to so much to either side, at random, within milliseconds
    double phase = 0.0;         ///< of its first edge, in periods after the beginning
    double wire_delay_s = 0.0;  ///< from the master's pin to its own
};

/// Several Verilated boards, each with an oscillator of its own, and the wire SYNC from one of them to the others. They
/// live in one time; each clock of a board is simulated when its time has come.
class Tiles {
public:
    /// @param model    of all boards, such as "small-16-sync"
    /// @param boards   one for each board; board 0 drives the wire
    /// @param seed     of wandering, of what the registers hold at power-up, and of how an edge of the wire is seen
    /// that comes
    ///                 together with a clock
    Tiles(std::string_view model, std::span<const Oscillator> boards, std::uint32_t seed);

    [[nodiscard]] std::size_t size() const { return tiles_.size(); }
    [[nodiscard]] SimulatedBoard& board(std::size_t i) { return *tiles_[i].board; }
    /// Of the clock that is being simulated, or was the last one.
    [[nodiscard]] Femtoseconds now() const { return now_; }
    /// Runs all boards for so long.
    void run(Femtoseconds duration);

    /// Wires each board's serial line behind the one before it, instead of to a host of its own.
    void chain() { chained_ = true; }
    [[nodiscard]] bool chained() const { return chained_; }
    /// Cuts the wires of a chain between this board and the one before it, or joins them again.
    void cut_chain(std::size_t board, bool cut) { tiles_[board].cut = cut; }
    /// Plugs a board's end of the wire in, or out: then it sees a low level.
    void connect(std::size_t board, bool connected);
    /// Drives the wire from elsewhere at a time that has not come yet, as a function generator does. Times must not go
    /// back.
    void drive_wire(Femtoseconds at, bool level);

private:
    struct Change {
        Femtoseconds at;
        bool level;
    };
    struct Tile {
        std::unique_ptr<SimulatedBoard> board;
        Oscillator oscillator;
        double period_fs;
        double next_fs;  // its next rising edge
        std::uint32_t clocks_to_wander = 0;
        double wander_ppm = 0.0;
        std::deque<Change> arriving;
        bool level = false, connected = true, cut = false;
    };

    void clock(Tile& tile);
    void join(Tile& tile);
    void wander(Tile& tile);

    std::vector<Tile> tiles_;
    std::mt19937 random_;
    Femtoseconds now_ = 0;
    bool wire_ = false, chained_ = false;
};

/// The serial line of one of several boards: waiting for bytes runs all of them.
class TileTransport final : public link::Transport {
public:
    TileTransport(Tiles& tiles, std::size_t board) : tiles_(tiles), board_(tiles.board(board)) {}

    void write(std::span<const std::uint8_t> bytes) override { board_.send(bytes); }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;
    [[nodiscard]] std::chrono::microseconds patience() const override { return std::chrono::milliseconds(50); }

private:
    Tiles& tiles_;
    SimulatedBoard& board_;
};

}  // namespace haptogram::sim
