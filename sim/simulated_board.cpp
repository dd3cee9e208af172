// SPDX-License-Identifier: Apache-2.0
#include "simulated_board.hpp"

#include <bit>
#include <cmath>
#include <utility>

namespace haptogram::sim {
namespace {

double clocks_per_bit(const interface::CoreParameters& p) {
    return static_cast<double>(p.clock_hz) / static_cast<double>(p.baud);
}

}  // namespace

SimulatedBoard::SimulatedBoard(std::string_view model, const SimulatedBoardOptions& options)
    : model_(make_model(model, options.power_up_seed)),
      sender_(clocks_per_bit(parameters())),
      receiver_(clocks_per_bit(parameters())) {
    const std::size_t words = (parameters().channels + 31) / 32;
    outputs_.pins.assign(words, 0);
    last_pins_.assign(words, 0);
    reset(options.reset_clocks);
}

void SimulatedBoard::reset(unsigned clocks) {
    in_reset_ = true;
    run(clocks);
    in_reset_ = false;
}

void SimulatedBoard::clock() {
    const bool line = sender_.level(now_), was_sync = outputs_.sync, was_trigger = outputs_.trigger;
    const bool broken = std::exchange(net_break_, false), stops = std::exchange(net_stop_, false),
               lost = std::exchange(net_lost_, false), off = outputs_.net_off;
    const std::uint8_t old = net_.old();
    model_->clock({.reset = in_reset_,
                   .rx = forced_line_.value_or(line),
                   .stop = stop_,
                   .sync = sync_,
                   .trigger = trigger_,
                   .next = next_,
                   .net = next_net(),
                   .net_lost = lost,
                   .net_end = broken || std::exchange(net_end_, false),
                   .net_off = broken,
                   .net_stop = stops,
                   .net_old = old},
                  outputs_);
    if (broken || off) net_.mark(PortBytes::off);
    if (stops) net_.mark(PortBytes::stop);
    if (broken || lost || in_reset_) net_.mark(PortBytes::end);
    if (outputs_.cycle_start && on_cycle_start_) on_cycle_start_({now_, outputs_.index, outputs_.enabled});
    for (std::size_t word = 0; word < last_pins_.size(); ++word) {
        std::uint32_t changed = outputs_.pins[word] ^ last_pins_[word];
        if (changed == 0) continue;
        last_pins_[word] = outputs_.pins[word];
        while (changed != 0 && on_edge_) {
            const int bit = std::countr_zero(changed);
            changed &= changed - 1;
            const auto channel = static_cast<std::uint32_t>(word * 32 + static_cast<std::size_t>(bit));
            on_edge_({now_, channel, outputs_.index, ((outputs_.pins[word] >> bit) & 1U) != 0});
        }
    }
    if (outputs_.sync != was_sync && on_sync_) on_sync_({now_, outputs_.sync});
    if (outputs_.trigger != was_trigger && on_trigger_) on_trigger_({now_, outputs_.trigger});
    const auto serial = receiver_.sample(now_, outputs_.tx);
    if (const auto byte = has_net() ? outputs_.net : serial) {
        arrived_.push_back(*byte);
        if (on_arrival_) on_arrival_({now_, *byte});
    }
    ++now_;
}

void SimulatedBoard::send(std::span<const std::uint8_t> bytes) {
    if (has_net())
        net_.add(bytes);
    else
        sender_.send(bytes);
}

void SimulatedBoard::unplug() {
    sender_.drop();
    net_.clear();
}

/// What comes from a network waits there for the end of a reset.
std::optional<std::uint8_t> SimulatedBoard::next_net() {
    if (net_.empty() || in_reset_) return {};
    return net_.take();
}

void SimulatedBoard::run(std::uint64_t clocks) {
    for (std::uint64_t i = 0; i < clocks; ++i) clock();
}

std::vector<std::uint8_t> SimulatedBoard::receive() { return std::exchange(arrived_, {}); }

std::optional<std::string_view> find_model(std::span<const interface::CoreConfiguration> models, double clock_hz,
                                           std::uint32_t channels, std::uint32_t records, std::uint32_t sequence_words,
                                           std::uint32_t timing_bits) {
    for (const auto& [name, p] : models)
        if (std::abs(p.clock_hz - clock_hz) < 0.5 && p.channels == channels && p.records >= records &&
            p.sequence_depth >= sequence_words && p.timing_bits >= timing_bits)
            return name;
    return {};
}

}  // namespace haptogram::sim
