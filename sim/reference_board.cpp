// SPDX-License-Identifier: Apache-2.0
#include "reference_board.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "haptogram/base/error.hpp"
#include "reference_core.hpp"

namespace haptogram::sim {
namespace {

const interface::CoreConfiguration& configuration_named(std::string_view name) {
    for (const auto& configuration : interface::core_configurations)
        if (configuration.name == name) return configuration;
    std::string known;
    for (const auto& configuration : interface::core_configurations)
        known += fmt::format("{}{}", known.empty() ? "" : ", ", configuration.name);
    throw bad_argument("configuration", fmt::format("there is none called {}; there are {}", name, known));
}

}  // namespace

ReferenceBoard::ReferenceBoard(std::string_view configuration, unsigned reset_clocks)
    : ReferenceBoard(configuration_named(configuration), reset_clocks) {}
ReferenceBoard::ReferenceBoard(const interface::CoreConfiguration& configuration, unsigned reset_clocks)
    : core_(std::make_unique<ReferenceCore>(configuration, reset_clocks)) {}
ReferenceBoard::~ReferenceBoard() = default;

void ReferenceBoard::run(std::uint64_t clocks) { core_->run(clocks); }
void ReferenceBoard::reset(unsigned clocks) { core_->reset(clocks); }
std::uint64_t ReferenceBoard::now() const { return core_->now; }
const interface::CoreConfiguration& ReferenceBoard::configuration() const { return core_->configuration; }
const Model::Outputs& ReferenceBoard::outputs() const { return core_->outputs(); }
Board::Present ReferenceBoard::present() const { return core_->present(); }
void ReferenceBoard::send(std::span<const std::uint8_t> bytes) { core_->line_in.send(bytes); }
std::vector<std::uint8_t> ReferenceBoard::receive() { return std::exchange(core_->arrived, {}); }
std::size_t ReferenceBoard::received() const { return core_->arrived.size(); }
bool ReferenceBoard::line_idle() const { return core_->line_in.idle(); }
void ReferenceBoard::force_line(std::optional<bool> level) { core_->line_in.force(core_->now, level); }
void ReferenceBoard::unplug() { core_->line_in.unplug(core_->now); }
void ReferenceBoard::network_break() { core_->line_in.break_network(core_->now); }
void ReferenceBoard::network_stop() { core_->line_in.stop_network(core_->now); }
void ReferenceBoard::drive_sync(bool level) { core_->drive_sync(level); }
void ReferenceBoard::drive_trigger(bool level) { core_->drive_trigger(level); }
void ReferenceBoard::press_stop(bool pressed) { core_->press_stop(pressed); }
void ReferenceBoard::on_edge(std::function<void(const Edge&)> callback) { core_->on_edge(std::move(callback)); }
void ReferenceBoard::on_cycle_start(std::function<void(const CycleStart&)> callback) {
    core_->on_cycle_start = std::move(callback);
}
void ReferenceBoard::on_arrival(std::function<void(const Arrival&)> callback) {
    core_->on_arrival = std::move(callback);
}
void ReferenceBoard::on_sync(std::function<void(const SyncChange&)> callback) { core_->on_sync = std::move(callback); }
void ReferenceBoard::on_trigger(std::function<void(const TriggerChange&)> callback) {
    core_->on_trigger = std::move(callback);
}
std::span<std::uint16_t> ReferenceBoard::primary_memory() { return core_->primary; }
std::span<std::uint32_t> ReferenceBoard::sequence_memory() { return core_->sequence; }

}  // namespace haptogram::sim
