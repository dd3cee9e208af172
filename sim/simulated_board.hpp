// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "model.hpp"
#include "serial_line.hpp"

namespace haptogram::sim {

/// A pin changed its level. `clock` counts from the first clock of the simulation; `index` is the record that played.
struct Edge {
    std::uint64_t clock;
    std::uint32_t channel;
    std::uint16_t index;
    bool rises;
};

/// A carrier cycle began at the pins: tick 0 of a cycle of record `index`.
struct CycleStart {
    std::uint64_t clock;
    std::uint16_t index;
    bool enabled;
};

struct SimulatedBoardOptions {
    std::optional<std::uint32_t> power_up_seed;  ///< random registers at power-up
    unsigned reset_clocks = 4;
};

/// The simulated FPGA board: a Verilated core, its clock and reset, a serial line at its baud rate, and observers.
class SimulatedBoard {
public:
    /// @param model  name of a configuration in available_models(), such as "tile-100"
    explicit SimulatedBoard(std::string_view model, const SimulatedBoardOptions& options = {});

    /// Runs this many clocks.
    void run(std::uint64_t clocks);
    /// Runs until `done`, asked every 16 clocks, says so. @return false when `limit` clocks passed first
    bool run_until(const std::function<bool()>& done, std::uint64_t limit);
    void reset(unsigned clocks = 4);

    [[nodiscard]] std::uint64_t now() const { return now_; }
    /// Name of the configuration, as it was asked for.
    [[nodiscard]] std::string_view name() const { return model_->configuration().name; }
    [[nodiscard]] const interface::CoreParameters& parameters() const { return model_->configuration().parameters; }
    [[nodiscard]] const Model::Outputs& outputs() const { return outputs_; }
    [[nodiscard]] bool pin(std::uint32_t channel) const {
        return ((outputs_.pins[channel / 32] >> (channel % 32)) & 1U) != 0;
    }
    [[nodiscard]] bool any_pin() const;

    /// Queues bytes for the board's receiver.
    void send(std::span<const std::uint8_t> bytes) { sender_.send(bytes); }
    /// The bytes that have arrived from the board since the last call.
    [[nodiscard]] std::vector<std::uint8_t> receive();
    [[nodiscard]] std::size_t received() const { return arrived_.size(); }
    [[nodiscard]] bool line_idle() const { return sender_.idle(); }
    /// Holds the receiver's line at a level, as noise or a broken cable would; an empty value lets go.
    void force_line(std::optional<bool> level) { forced_line_ = level; }
    void unplug() { sender_.drop(); }
    /// Presses the stop switch, or releases it.
    void press_stop(bool pressed) { stop_ = pressed; }

    void on_edge(std::function<void(const Edge&)> callback) { on_edge_ = std::move(callback); }
    void on_cycle_start(std::function<void(const CycleStart&)> callback) { on_cycle_start_ = std::move(callback); }

    /// Empty where the memories can only be reached over the link.
    [[nodiscard]] std::span<std::uint16_t> primary_memory() { return model_->primary_memory(); }
    [[nodiscard]] std::span<std::uint32_t> sequence_memory() { return model_->sequence_memory(); }
    void trace(const std::filesystem::path& file) { model_->trace(file); }
    /// Ends the trace; its file is complete after this.
    void end_trace() { model_->end_trace(); }

private:
    void clock();

    std::unique_ptr<Model> model_;
    Model::Outputs outputs_;
    std::vector<std::uint32_t> last_pins_;
    SerialSender sender_;
    SerialReceiver receiver_;
    std::optional<bool> forced_line_;
    std::vector<std::uint8_t> arrived_;
    std::function<void(const Edge&)> on_edge_;
    std::function<void(const CycleStart&)> on_cycle_start_;
    std::uint64_t now_ = 0;
    bool in_reset_ = true;
    bool stop_ = false;
};

/// Name of the first model that has this clock and these channels, and enough records, sequence words and timing bits.
[[nodiscard]] std::optional<std::string_view> find_model(double clock_hz, std::uint32_t channels, std::uint32_t records,
                                                         std::uint32_t sequence_words, std::uint32_t timing_bits);

}  // namespace haptogram::sim
