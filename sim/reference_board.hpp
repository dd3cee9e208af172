// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string_view>
#include <vector>

#include "board.hpp"

namespace haptogram::sim {

class ReferenceCore;

/// What the Verilog of rtl/ does, computed from events instead of clock by clock: a byte has arrived, a frame is
/// carried out, a record is committed, a pulse begins. Its replies and its pins are those of the Verilated core, at the
/// same clocks (tests/reference compares them). Time in which nothing happens costs nothing, and pulses only cost
/// something while somebody looks at them, or while they could merge to what the guard must notice.
///
/// Each event is worked out in the order in which the core's registers see each other: what reads a value comes before
/// what changes it in the same clock.
class ReferenceBoard final : public Board {
public:
    /// @param configuration  a name in tools/interface.toml, such as "tile-100"
    /// @throws Error{bad_argument} when there is none of that name
    explicit ReferenceBoard(std::string_view configuration, unsigned reset_clocks = 4);
    /// @param configuration  parameters in the ranges of interface::core_parameters
    explicit ReferenceBoard(const interface::CoreConfiguration& configuration, unsigned reset_clocks = 4);
    ~ReferenceBoard() override;

    void run(std::uint64_t clocks) override;
    void reset(unsigned clocks = 4) override;
    [[nodiscard]] std::uint64_t now() const override;
    [[nodiscard]] const interface::CoreConfiguration& configuration() const override;
    [[nodiscard]] const Model::Outputs& outputs() const override;
    [[nodiscard]] Present present() const override;
    void send(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::vector<std::uint8_t> receive() override;
    [[nodiscard]] std::size_t received() const override;
    [[nodiscard]] bool line_idle() const override;
    void force_line(std::optional<bool> level) override;
    void unplug() override;
    void network_break() override;
    void network_stop() override;
    void press_stop(bool pressed) override;
    void drive_sync(bool level) override;
    void drive_trigger(bool level) override;
    void on_edge(std::function<void(const Edge&)> callback) override;
    void on_cycle_start(std::function<void(const CycleStart&)> callback) override;
    void on_arrival(std::function<void(const Arrival&)> callback) override;
    void on_sync(std::function<void(const SyncChange&)> callback) override;
    void on_trigger(std::function<void(const TriggerChange&)> callback) override;
    [[nodiscard]] std::span<std::uint16_t> primary_memory() override;
    [[nodiscard]] std::span<std::uint32_t> sequence_memory() override;

private:
    std::unique_ptr<ReferenceCore> core_;
};

}  // namespace haptogram::sim
