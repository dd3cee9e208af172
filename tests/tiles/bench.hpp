// SPDX-License-Identifier: Apache-2.0
// Several boards on one wire, a host for each, and an instrument at all of their pins.
#pragma once
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "haptogram/format/image.hpp"
#include "haptogram/link/client.hpp"
#include "tiles.hpp"

namespace haptogram::test {

using interface::Role;
using sim::Femtoseconds;
using sim::microsecond;

/// Watches pins with the same timings on several boards. A rise belongs with the nearest rise of the same channel on
/// another board; a pulse is lost or doubled when a board's rises are not a carrier period apart, and cut when it is
/// shorter than its record says.
class PinWatch {
public:
    /// @param length  of a pulse, clocks
    PinWatch(sim::Tiles& tiles, std::uint32_t channels, std::uint32_t cycle, std::uint32_t length);

    /// Begins to judge, with the next pulses.
    void begin();
    /// Stops to judge.
    void end() { judging_ = false; }
    /// Leaves one board out from now on, or takes it in.
    void leave_out(std::size_t board, bool out);

    double worst_clocks = 0.0;    ///< between two boards' rises or falls that belong together, in clocks of 20 ns
    std::uint64_t pulses = 0;     ///< that were judged
    std::uint64_t cut = 0;        ///< shorter than their record says
    std::uint64_t stretched = 0;  ///< longer, by the clocks that a cycle waited
    std::uint64_t lost = 0;       ///< two rises of a board further apart than a period and 8 clocks
    std::uint64_t doubled = 0;    ///< or nearer than a period
    std::uint32_t longest = 0;    ///< clocks

private:
    struct Pin {
        Femtoseconds rise = -1, fall = -1;
        std::uint64_t rise_clock = 0;
        bool known = false, high = false;
    };
    void on_edge(std::size_t board, const sim::Edge& edge);
    void compare(std::size_t board, std::uint32_t channel, Femtoseconds Pin::*edge);

    sim::Tiles& tiles_;
    std::vector<std::vector<Pin>> pins_;  // by channel, then board
    std::vector<char> left_out_;
    std::uint32_t cycle_, length_;
    bool judging_ = false;
};

struct TileBench {
    std::unique_ptr<sim::Tiles> boards;
    sim::Tiles& tiles;
    std::vector<std::unique_ptr<sim::TileTransport>> lines;
    std::vector<std::unique_ptr<link::Client>> hosts;

    explicit TileBench(std::unique_ptr<sim::Tiles> made);
    TileBench(std::string_view model, const std::vector<sim::Oscillator>& oscillators, std::uint32_t seed)
        : TileBench(std::make_unique<sim::SimulatedTiles>(model, oscillators, seed)) {}

    [[nodiscard]] link::Client& host(std::size_t i) { return *hosts[i]; }
    /// Puts words into a board's primary memory, and begins a session with it.
    void load(std::size_t board, const std::vector<std::uint16_t>& words);
    /// The same image for all.
    void load(const Image& image) {
        for (std::size_t i = 0; i < tiles.size(); ++i) load(i, primary_words(image));
    }
    /// Makes board 0 the master and the others slaves, and waits until all of these are in step and have its numbers.
    /// @return how long that took, seconds of the boards' time
    double join();
    /// Waits until a slave is in step and has the master's numbers.
    void wait_for_number(std::size_t board);
    /// Has all boards play a record with their outputs on.
    void play(std::uint16_t index);
    void run_ms(double milliseconds) { tiles.run(static_cast<Femtoseconds>(milliseconds * 1000.0) * microsecond); }
};

/// Oscillators with offsets up to `ppm` to either side, the extremes among them, at random phases, on some metres of
/// wire.
std::vector<sim::Oscillator> crystals(std::size_t boards, double ppm, double wander_ppm, std::mt19937& random);

}  // namespace haptogram::test
