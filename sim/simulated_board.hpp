// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "board.hpp"
#include "model.hpp"
#include "port_bytes.hpp"
#include "serial_line.hpp"

namespace haptogram::sim {

struct SimulatedBoardOptions {
    std::optional<std::uint32_t> power_up_seed;  ///< random registers at power-up
    unsigned reset_clocks = 4;
};

/// The simulated FPGA board: a Verilated core, its clock and reset, a serial line at its baud rate, and observers.
class SimulatedBoard final : public Board {
public:
    /// @param model  name of a configuration in available_models(), such as "tile-100"
    explicit SimulatedBoard(std::string_view model, const SimulatedBoardOptions& options = {});

    void run(std::uint64_t clocks) override;
    void reset(unsigned clocks = 4) override;
    [[nodiscard]] std::uint64_t now() const override { return now_; }
    [[nodiscard]] const interface::CoreConfiguration& configuration() const override { return model_->configuration(); }
    [[nodiscard]] const Model::Outputs& outputs() override { return outputs_; }
    [[nodiscard]] Present present() const override { return {outputs_.index, outputs_.enabled}; }

    void send(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::vector<std::uint8_t> receive() override;
    [[nodiscard]] std::size_t received() const override { return arrived_.size(); }
    [[nodiscard]] bool line_idle() const override { return sender_.idle() && net_.empty(); }
    void force_line(std::optional<bool> level) override { forced_line_ = level; }
    void unplug() override;
    void network_break() override { net_break_ = true; }
    void network_stop() override { net_stop_ = true; }
    void network_lost() override { net_lost_ = true; }
    void network_end() override { net_end_ = true; }
    void press_stop(bool pressed) override { stop_ = pressed; }
    void drive_sync(bool level) override { sync_ = level; }
    void drive_trigger(bool level) override { trigger_ = level; }
    /// The level at the serial line from the next tile of a chain.
    void drive_next(bool level) { next_ = level; }

    [[nodiscard]] std::span<std::uint16_t> primary_memory() override { return model_->primary_memory(); }
    [[nodiscard]] std::span<std::uint32_t> sequence_memory() override { return model_->sequence_memory(); }
    void write_flash(std::uint32_t address, const std::vector<std::uint8_t>& bytes) {
        model_->write_flash(address, bytes);
    }
    void trace(const std::filesystem::path& file) { model_->trace(file); }
    /// Ends the trace; its file is complete after this.
    void end_trace() { model_->end_trace(); }

private:
    void clock();
    [[nodiscard]] bool has_net() const { return parameters().net != 0; }
    [[nodiscard]] std::optional<std::uint8_t> next_net();

    std::unique_ptr<Model> model_;
    Model::Outputs outputs_;
    std::vector<std::uint32_t> last_pins_;
    SerialSender sender_;
    SerialReceiver receiver_;
    std::optional<bool> forced_line_;
    PortBytes net_;  // for the network port
    std::vector<std::uint8_t> arrived_;
    std::uint64_t now_ = 0;
    bool in_reset_ = true;
    bool stop_ = false, sync_ = false, trigger_ = false, next_ = true, net_break_ = false, net_stop_ = false,
         net_lost_ = false, net_end_ = false;
};

/// Name of the first of these configurations that has this clock and these channels, and enough records, sequence words
/// and timing bits.
[[nodiscard]] std::optional<std::string_view> find_model(std::span<const interface::CoreConfiguration> models,
                                                         double clock_hz, std::uint32_t channels, std::uint32_t records,
                                                         std::uint32_t sequence_words, std::uint32_t timing_bits);

}  // namespace haptogram::sim
