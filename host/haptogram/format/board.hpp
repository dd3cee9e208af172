// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/format/core.hpp"

namespace haptogram {

/// A board file of constraints/: an FPGA, the instrument that is built into it, and which ball goes where.
struct Board {
    struct Fpga {
        std::string family;  ///< "ecp5" or "ice40"
        std::string device, package;
        std::optional<std::uint32_t> speed;  ///< grade; an ecp5 has one
        std::string top;                     ///< Verilog module in rtl/boards/
    };
    /// Arguments of openFPGALoader. The name of the bitstream comes after them.
    struct Flash {
        std::vector<std::string> load;                           ///< until power is cut
        std::vector<std::string> write;                          ///< it stays when power is cut
        std::string note;                                        ///< what a person must connect first
        std::optional<std::string> load_jumpers, write_jumpers;  ///< how the board's jumpers must be for each
    };
    struct Pins {
        std::string clk;
        std::optional<std::string> rx, tx;  ///< the serial line, of boards without a network
        std::optional<std::string> led;
        std::optional<std::string> stop;           ///< input of a switch that disables the outputs
        std::uint32_t stop_level = 0;              ///< at which it does so
        std::optional<std::string> driver_enable;  ///< output for the enable inputs of the transducers' drivers
        std::uint32_t driver_enable_level = 1;     ///< at which they are on
        std::optional<std::string> alive;          ///< output that changes as long as there is a clock
        std::optional<std::string> sync_in;        ///< input of SYNC, of a slave
        std::optional<std::string> sync_out;       ///< output of SYNC, of a master
        std::optional<std::string> trigger_in;     ///< input of a trigger from elsewhere
        std::optional<std::string> trigger_out;    ///< output of the trigger
        std::optional<std::string> test;           ///< output for an oscilloscope
        std::optional<std::string> next_rx;        ///< input of a chain: the line from the next tile
        std::optional<std::string> next_tx;        ///< output of a chain: the line to it
        bool active_low = false;                   ///< a transducer's driver is on while its pin is low
        std::optional<std::uint32_t> drive_ma;     ///< strength of the outputs; only an ecp5 has a choice
        std::optional<std::string> slew;           ///< "slow" or "fast"; only an ecp5 has a choice
        std::vector<std::string> high;             ///< held high, which the rest of the board needs in order to work
    };
    /// A gigabit PHY (RGMII), and what the board is called on its network.
    struct Network {
        std::string mac, ip;                         ///< such as "02:48:47:00:00:01", "169.254.71.1"
        std::uint32_t rx_delay = 0, tx_delay = 0;    ///< steps of 25 ps
        std::string rx_clk, rx_ctl, tx_clk, tx_ctl;  ///< balls; rx is from the PHY
        std::vector<std::string> rx, tx;             ///< four each, bit 0 first
    };
    /// The chip that the records lie in, of boards with SDRAM.
    struct Sdram {
        std::string clk, ras_n, cas_n, we_n;           ///< balls
        std::vector<std::string> bank, address, data;  ///< bit 0 first
        std::vector<std::string> flash;                ///< chip select, to, and from the flash that fills it
    };
    /// What a person wires beside the outputs.
    struct Wiring {
        std::string ground;  ///< pins that are ground
        std::string power;   ///< what feeds the FPGA board
        std::string serial;  ///< how the serial line gets to it, of what levels
        bool driven =
            false;  ///< its connectors drive the drivers before the FPGA is configured: a resistor does not help
        std::map<std::string, std::string> places;  ///< of balls that are no outputs
    };
    struct Output {
        std::string connector, pin, net, ball;
    };

    std::string name;  ///< of the file, without ".toml"
    std::string file;  ///< where it was read from, for messages
    std::string description;
    std::vector<std::string> sources;  ///< where the pins are published
    std::string array;                 ///< name or path of the array that it drives unless told otherwise
    Fpga fpga;
    interface::CoreParameters parameters;
    Flash flash;
    Pins pins;
    std::optional<Network> network;  ///< in the place of the serial line
    std::optional<Sdram> sdram;
    std::optional<Wiring> wiring;
    std::vector<Output> outputs;  ///< output k is channel k; those beyond CHANNELS are spare

    /// Where a wire reaches a ball, such as "J1 pin 36"; empty when the file does not say it.
    [[nodiscard]] std::string place_of(const std::string& ball) const;

    /// What the compiler must know of it.
    [[nodiscard]] Core core() const { return {name, parameters}; }
};

/// Reads a board file (TOML), given by its path, or by the name of a shipped board ("ice40-hx8k-breakout").
/// @throws Error{bad_input} naming the file, the line and the key: what is missing, unknown, of another type or out of
/// range, a ball used twice, or fewer outputs than channels
[[nodiscard]] Board load_board(const std::string& name);

/// What the file of a board's bitstream is called: its name, with ".bin" for an iCE40 and ".bit" for an ECP5.
[[nodiscard]] std::string bitstream_file(const Board& board);

/// Names of the shipped boards, sorted.
[[nodiscard]] std::vector<std::string> shipped_boards();

}  // namespace haptogram
