// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// One Verilated core, without Verilator's types.
class Model {
public:
    /// What is at the ports after a clock's rising edge.
    struct Outputs {
        bool tx = true, enabled = false, alive = false, playing = false, fault = false, cycle_start = false,
             sync = false, trigger = false, test = false,
             next = true;                 ///< the serial line to the next tile of a chain
        std::optional<std::uint8_t> net;  ///< a byte for the network port, which takes it in this clock
        bool net_off = false;             ///< for the network port: outputs are switched off in the clock that follows
        std::uint16_t index = 0;
        std::vector<std::uint32_t> pins;  ///< channel k is bit k % 32 of word k / 32
    };

    Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;
    virtual ~Model() = default;

    /// What is at the ports before it.
    struct Inputs {
        bool reset = false, rx = true, stop = false, sync = false, trigger = false;
        bool next = true;                   ///< the serial line from the next tile
        std::optional<std::uint8_t> net{};  ///< a byte from the network port
        /// What the port says beside it, see rtl/haptogram_core.v.
        bool net_lost = false, net_end = false, net_off = false, net_stop = false;
        std::uint8_t net_old = 0;
    };

    /// One rising clock edge with these inputs; `outputs` is what follows it.
    virtual void clock(const Inputs& inputs, Outputs& outputs) = 0;
    /// Its name and the parameters that it was built with.
    [[nodiscard]] virtual const interface::CoreConfiguration& configuration() const = 0;
    /// The memories' words, to read and to write beside the link; empty where they cannot be reached, as in a netlist.
    [[nodiscard]] virtual std::span<std::uint16_t> primary_memory() = 0;
    [[nodiscard]] virtual std::span<std::uint32_t> sequence_memory() = 0;
    /// What the flash holds from an address on, of a core that reads one.
    virtual void write_flash(std::uint32_t address, const std::vector<std::uint8_t>& bytes) = 0;
    /// Writes every signal of every further clock to an FST file.
    virtual void trace(const std::filesystem::path& file) = 0;
    virtual void end_trace() = 0;
};

/// Every core that was Verilated into this build (sim/models.cmake); images are tried on them in this order.
[[nodiscard]] const std::vector<interface::CoreConfiguration>& available_models();

/// @param name           of a configuration in available_models(), such as "tile-100"
/// @param power_up_seed  when given, every register without an initial value starts at random
/// @throws std::invalid_argument when no model has this name
[[nodiscard]] std::unique_ptr<Model> make_model(std::string_view name, std::optional<std::uint32_t> power_up_seed = {});

}  // namespace haptogram::sim
