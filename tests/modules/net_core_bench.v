// SPDX-License-Identifier: Apache-2.0
//
// The instrument behind its Ethernet port, from GMII to the pins and to those of an SDRAM, as a board's top wires it. Its flash is blank.
`default_nettype none
module net_core_bench #(
    `include "parameters.vh"
    parameter PEER_CLOCKS = 125000000
) (
    input  wire                eth_clk,
    input  wire                i_dv,
    input  wire [7:0]          i_data,
    output wire                o_en,
    output wire [7:0]          o_data,
    input  wire                clk,
    input  wire                rst,
    input  wire                i_stop,
    output wire [CHANNELS-1:0] o_pins,
    output wire                o_enabled,
    output wire [15:0]         o_index,
    output wire                o_cycle_start,
    output wire [2:0]          o_sdram_command,
    output wire [1:0]          o_sdram_bank,
    output wire [10:0]         o_sdram_address,
    output wire [31:0]         o_sdram_data,
    output wire                o_sdram_drive,
    input  wire [31:0]         i_sdram_data
);
    wire        valid, network_lost, network_end, network_off, network_stop, core_off, reply_valid, reply_ready;
    wire [7:0]  data, reply;
    wire [4:0]  identity_place;
    wire [15:0] identity_word;
    wire [2:0]  net_old;
    wire        trigger, test, sync, tx, next, alive, playing, fault;
    wire [2:0]  flash;
    wire        unused = &{1'b0, flash, trigger, test, sync, tx, next, alive, playing, fault};
    udp_link #(.PEER_CLOCKS(PEER_CLOCKS)) network (
        .eth_clk(eth_clk), .i_dv(i_dv), .i_er(1'b0), .i_data(i_data), .o_en(o_en), .o_data(o_data),
        .clk(clk), .rst(rst), .o_valid(valid), .o_byte(data), .i_take(valid), .i_valid(reply_valid), .o_ready(reply_ready), .i_byte(reply),
        .o_old(net_old), .o_lost(network_lost), .o_end(network_end), .o_off(network_off), .o_stop(network_stop), .i_off(core_off), .i_enabled(o_enabled),
        .o_identity_place(identity_place), .i_identity_word(identity_word));
    haptogram_core #(
        `include "parameter_connections.vh"
        .PRIMARY_FILE(""), .SEQUENCE_FILE("")
    ) core (
        .clk(clk), .rst(rst), .i_rx(1'b1), .o_tx(tx), .i_stop(i_stop), .i_sync(1'b0), .i_trigger(1'b0), .o_trigger(trigger), .o_test(test), .o_sync(sync), .i_next(1'b1), .o_next(next),
        .i_net_valid(valid), .i_net_byte(data), .i_net_old(net_old), .i_net_lost(network_lost), .i_net_end(network_end), .i_net_off(network_off), .i_net_stop(network_stop), .o_net_off(core_off),
        .o_net_valid(reply_valid), .i_net_ready(reply_ready), .o_net_byte(reply),
        .i_identity_place(identity_place), .o_identity_word(identity_word),
        .o_sdram_command(o_sdram_command), .o_sdram_bank(o_sdram_bank), .o_sdram_address(o_sdram_address), .o_sdram_data(o_sdram_data),
        .o_sdram_drive(o_sdram_drive), .i_sdram_data(i_sdram_data),
        .o_flash_cs_n(flash[0]), .o_flash_clk(flash[1]), .o_flash_data(flash[2]), .i_flash_data(1'b1),
        .o_pins(o_pins), .o_enabled(o_enabled), .o_alive(alive), .o_playing(playing), .o_fault(fault), .o_index(o_index),
        .o_cycle_start(o_cycle_start));
endmodule
`default_nettype wire
