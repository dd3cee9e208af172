// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

#include <cmath>
#include <utility>

namespace haptogram::test {
namespace {

constexpr double clock_fs = 20e6;  // of 50 MHz

}  // namespace

PinWatch::PinWatch(sim::Tiles& tiles, std::uint32_t channels, std::uint32_t cycle, std::uint32_t length)
    : tiles_(tiles),
      pins_(channels, std::vector<Pin>(tiles.size())),
      left_out_(tiles.size(), 0),
      cycle_(cycle),
      length_(length) {
    for (std::size_t i = 0; i < tiles.size(); ++i)
        tiles.board(i).on_edge([this, i](const sim::Edge& edge) { on_edge(i, edge); });
}

void PinWatch::begin() {
    for (auto& boards : pins_)
        for (Pin& pin : boards) pin.known = false;
    judging_ = true;
}

void PinWatch::leave_out(std::size_t board, bool out) {
    left_out_[board] = out ? 1 : 0;
    for (auto& boards : pins_) boards[board].known = false;
}

void PinWatch::on_edge(std::size_t board, const sim::Edge& edge) {
    if (!judging_ || left_out_[board] != 0) return;
    Pin& pin = pins_[edge.channel][board];
    if (edge.rises) {
        const std::uint64_t apart = edge.clock - pin.rise_clock;
        if (pin.known && apart > cycle_ + 8) ++lost;
        if (pin.known && apart < cycle_) ++doubled;
        pin.known = pin.high = true;
        pin.rise_clock = edge.clock;
        pin.rise = tiles_.time_of(board, edge.clock);
        return compare(board, edge.channel, &Pin::rise);
    }
    if (!pin.high || !pin.known) return;
    pin.high = false;
    pin.fall = tiles_.time_of(board, edge.clock);
    const auto clocks = static_cast<std::uint32_t>(edge.clock - pin.rise_clock);
    ++pulses;
    cut += clocks < length_ ? 1 : 0;
    stretched += clocks > length_ ? 1 : 0;
    longest = std::max(longest, clocks);
    compare(board, edge.channel, &Pin::fall);
}

void PinWatch::compare(std::size_t board, std::uint32_t channel, Femtoseconds Pin::*edge) {
    const std::vector<Pin>& boards = pins_[channel];
    const Femtoseconds now = boards[board].*edge;
    for (std::size_t other = 0; other < boards.size(); ++other) {
        if (left_out_[other] != 0 || !boards[other].known || boards[other].*edge < 0) continue;
        const double apart = std::abs(static_cast<double>(now - boards[other].*edge)) / clock_fs;
        // The other's edge of this period may be still to come, and will then be compared with this one.
        if (apart < cycle_ / 2.0) worst_clocks = std::max(worst_clocks, apart);
    }
}

TileBench::TileBench(std::unique_ptr<sim::Tiles> made) : boards(std::move(made)), tiles(*boards) {
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        lines.push_back(std::make_unique<sim::TileTransport>(tiles, i));
        hosts.push_back(std::make_unique<link::Client>(*lines.back()));
    }
}

void TileBench::load(std::size_t board, const std::vector<std::uint16_t>& words) {
    std::ranges::copy(words, tiles.board(board).primary_memory().begin());
    host(board).identify();
}

double TileBench::join() {
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        host(i).set_role(i == 0 ? Role::master : Role::slave);
        host(i).set_watchdog(0);
    }
    const Femtoseconds from = tiles.now();
    for (std::size_t i = 1; i < tiles.size(); ++i) wait_for_number(i);
    return static_cast<double>(tiles.now() - from) * 1e-15;
}

void TileBench::wait_for_number(std::size_t board) {
    const Femtoseconds end = tiles.now() + 40'000 * microsecond;
    link::Status status = host(board).status();
    for (; !status.in_step || !status.numbered; status = host(board).status()) REQUIRE(tiles.now() < end);
    CHECK(status.role == Role::slave);
}

void TileBench::play(std::uint16_t index) {
    for (auto& host : hosts) host->select(index);
    for (auto& host : hosts) host->enable();
    run_ms(0.2);
}

std::vector<sim::Oscillator> crystals(std::size_t boards, double ppm, double wander_ppm, std::mt19937& random) {
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    std::vector<sim::Oscillator> found;
    for (std::size_t i = 0; i < boards; ++i)
        found.push_back({.offset_ppm = (ppm - wander_ppm) * share(random),
                         .wander_ppm = wander_ppm,
                         .phase = 1250.0 * (1.0 + share(random)),
                         .wire_delay_s = i == 0 ? 0.0 : 2.5e-9 * (2.0 + share(random))});
    // The worst that crystals can do: the master at one end, slaves at both.
    const double sign = share(random) < 0.0 ? -1.0 : 1.0;
    if (boards > 1) found[0].offset_ppm = sign * (ppm - wander_ppm), found[1].offset_ppm = -found[0].offset_ppm;
    if (boards > 2) found[2].offset_ppm = found[0].offset_ppm;
    return found;
}

}  // namespace haptogram::test
