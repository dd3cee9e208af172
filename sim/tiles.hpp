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

#include "clock.hpp"
#include "haptogram/link/transport.hpp"
#include "reference_board.hpp"
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

/// Several boards, each with an oscillator of its own, and the wire SYNC from one of them to the others. They live in
/// one time: SimulatedTiles are Verilated cores, ReferenceTiles reference boards.
class Tiles {
public:
    Tiles(const Tiles&) = delete;
    Tiles& operator=(const Tiles&) = delete;
    virtual ~Tiles() = default;

    [[nodiscard]] std::size_t size() const { return tiles_.size(); }
    [[nodiscard]] Board& board(std::size_t i) { return *tiles_[i].board; }
    [[nodiscard]] Femtoseconds now() const { return now_; }
    /// When this clock of a board comes, in the time of all boards; for a board's observers.
    [[nodiscard]] virtual Femtoseconds time_of(std::size_t board, Clock clock) const = 0;
    /// Runs all boards for so long.
    virtual void run(Femtoseconds duration) = 0;

    /// Wires each board's serial line behind the one before it, instead of to a host of its own.
    /// @throws Error{bad_argument} when these boards cannot be chained
    virtual void chain() = 0;
    [[nodiscard]] bool chained() const { return chained_; }
    /// Cuts the wires of a chain between this board and the one before it, or joins them again.
    void cut_chain(std::size_t board, bool cut) { tiles_[board].cut = cut; }
    /// Plugs a board's end of the wire in, or out: then it sees a low level.
    void connect(std::size_t board, bool connected);
    /// Drives the wire from elsewhere at a time that has not come yet, as a function generator does. Times must not go
    /// back.
    void drive_wire(Femtoseconds at, bool level);

protected:
    struct Change {
        Femtoseconds at;
        bool level;
    };
    struct Tile {
        std::unique_ptr<Board> board;
        Oscillator oscillator;
        double period_fs = 0.0;
        double next_fs = 0.0;  // its next rising edge
        std::uint32_t clocks_to_wander = 0;
        double wander_ppm = 0.0;
        std::deque<Change> arriving;
        bool level = false, connected = true, cut = false;
    };

    explicit Tiles(std::uint32_t seed) : random_(seed) {}
    void add(std::unique_ptr<Board> board, const Oscillator& oscillator);
    /// Its level at the board's end, as it is at this time.
    static void see_wire(Tile& tile, Femtoseconds now);
    /// Its frequency changes after this many clocks.
    void wander(Tile& tile);

    std::vector<Tile> tiles_;
    std::mt19937 random_;
    Femtoseconds now_ = 0;
    bool chained_ = false;
};

/// Verilated boards: each clock of a board is simulated when its time has come.
class SimulatedTiles final : public Tiles {
public:
    /// @param model    of all boards, such as "small-16-sync"
    /// @param boards   one for each board; board 0 drives the wire
    /// @param seed     of wandering, of what the registers hold at power-up, and of how an edge of the wire is seen
    ///                 that comes together with a clock
    SimulatedTiles(std::string_view model, std::span<const Oscillator> boards, std::uint32_t seed);

    /// While boards run, now() is the time of the clock that is being simulated.
    void run(Femtoseconds duration) override;
    [[nodiscard]] Femtoseconds time_of(std::size_t, Clock) const override { return now_; }
    void chain() override { chained_ = true; }

private:
    void clock(std::size_t i);
    void join(std::size_t i);

    std::vector<SimulatedBoard*> boards_;
    bool wire_ = false;
};

/// Reference boards. Nothing but the wire leads from one to another, and only away from board 0, so this one is run
/// ahead, and each of the others from one change of the wire to the next.
class ReferenceTiles final : public Tiles {
public:
    /// @param configuration  of all boards, such as "tile-100-sync"
    /// @param boards, seed   as those of SimulatedTiles; registers hold nothing at random
    ReferenceTiles(std::string_view configuration, std::span<const Oscillator> boards, std::uint32_t seed);

    /// While boards run, now() is the time from which they do; they run one after the other.
    void run(Femtoseconds duration) override;
    [[nodiscard]] Femtoseconds time_of(std::size_t board, Clock clock) const override;
    void chain() override;

private:
    void run_to(std::size_t i, double end_fs);

    struct Begin {
        double fs = 0.0;
        Clock clock = 0;
    };
    std::vector<Begin> begins_;  // of each board: the clock from which on it runs
};

/// The serial line of one of several boards: waiting for bytes runs all of them.
class TileTransport final : public link::Transport {
public:
    TileTransport(Tiles& tiles, std::size_t board) : tiles_(tiles), board_(tiles.board(board)) {}

    void write(std::span<const std::uint8_t> bytes) override { board_.send(bytes); }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;
    [[nodiscard]] link::Clock& clock() override { return clock_; }
    [[nodiscard]] std::chrono::microseconds patience() const override { return std::chrono::milliseconds(50); }

private:
    /// The time that all boards have, whatever their crystals make of it.
    class TilesClock final : public link::Clock {
    public:
        explicit TilesClock(Tiles& tiles) : tiles_(tiles) {}
        [[nodiscard]] Time now() const override { return Time(static_cast<std::int64_t>(tiles_.now() / nanosecond)); }
        void rest_until(Time until) override {
            const auto end = static_cast<Femtoseconds>(until.count()) * nanosecond;
            if (end > tiles_.now()) tiles_.run(end - tiles_.now());
        }

    private:
        static constexpr Femtoseconds nanosecond = 1'000'000;
        Tiles& tiles_;
    };

    Tiles& tiles_;
    Board& board_;
    TilesClock clock_{tiles_};
};

}  // namespace haptogram::sim
