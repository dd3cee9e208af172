// SPDX-License-Identifier: Apache-2.0
//
// The top of every board with an ECP5: 25 MHz in, 50 MHz from the PLL, reset, LED and pins around the core.
//
// tools/bitstream.py sets the parameters to the configuration that the board's file in constraints/ names. It also defines
// HG_LED when the board has an LED, HG_HIGH as the number of pins that must be held high for the rest of the board to work, and:
//   HG_STOP           the level of the stop input at which outputs are off, 0 or 1, when the board has one
//   HG_DRIVER_ENABLE  the level, 0 or 1, at which the drivers are on, when it has a pin for their enable input: they are while
//                     outputs are enabled and the clock runs
//   HG_SYNC_IN, HG_SYNC_OUT  when it has a pin for SYNC from a master, or to slaves
//   HG_TRIGGER_IN, HG_TRIGGER_OUT, HG_TEST  when it has a pin for a trigger from elsewhere, for one to elsewhere, for an oscilloscope
//   HG_CHAIN          when it has two for the serial line of the next tile
//   HG_ALIVE          when it has a pin that changes as long as there is a clock
//   HG_ACTIVE_LOW     when a transducer's driver is on while its pin is low
//   HG_NET            when a gigabit PHY is in the place of the serial line, with HG_NET_MAC, HG_NET_IP, HG_NET_RX_DELAY, HG_NET_TX_DELAY
//   HG_SDRAM          when the records lie in a chip beside the FPGA, of SDRAM MiB, which is filled from the FPGA's flash
// The enable is taken away by clock_watch, which has a clock of its own, when this one stops.
`default_nettype none
module ecp5_board #(
    `include "parameters.vh"
    parameter PRIMARY_FILE = "",
    parameter SEQUENCE_FILE = ""
) (
    input  wire                i_clk,
`ifdef HG_NET
    input  wire                i_net_rx_clk,
    input  wire                i_net_rx_ctl,
    input  wire [3:0]          i_net_rx,
    output wire                o_net_tx_clk,
    output wire                o_net_tx_ctl,
    output wire [3:0]          o_net_tx,
`else
    input  wire                i_rx,
    output wire                o_tx,
`endif
`ifdef HG_SDRAM
    output wire                o_sdram_clk,
    output wire                o_sdram_ras_n,
    output wire                o_sdram_cas_n,
    output wire                o_sdram_we_n,
    output wire [SDRAM/8:0]    o_sdram_bank,
    output wire [10:0]         o_sdram_address,
    inout  wire [31:0]         io_sdram_data,
    output wire                o_flash_cs_n,
    output wire                o_flash_data,
    input  wire                i_flash_data,
`endif
`ifdef HG_STOP
    input  wire                i_stop,
`endif
`ifdef HG_SYNC_IN
    input  wire                i_sync,
`endif
`ifdef HG_SYNC_OUT
    output wire                o_sync,
`endif
`ifdef HG_TRIGGER_IN
    input  wire                i_trigger,
`endif
`ifdef HG_TRIGGER_OUT
    output wire                o_trigger,
`endif
`ifdef HG_TEST
    output wire                o_test,
`endif
`ifdef HG_CHAIN
    input  wire                i_next,
    output wire                o_next,
`endif
`ifdef HG_DRIVER_ENABLE
    output wire                o_driver_enable,
`endif
`ifdef HG_ALIVE
    output wire                o_alive,
`endif
`ifdef HG_LED
    output wire                o_led,
`endif
`ifdef HG_HIGH
    output wire [`HG_HIGH-1:0] o_high,
`endif
    output wire [CHANNELS-1:0] o_pins
);
`ifdef HG_STOP
    wire stop = i_stop == 1'b`HG_STOP;
`else
    wire stop = 1'b0;
`endif
`ifdef HG_SYNC_IN
    wire sync_in = i_sync;
`else
    wire sync_in = 1'b0;
`endif
`ifdef HG_TRIGGER_IN
    wire trigger_in = i_trigger;
`else
    wire trigger_in = 1'b0;
`endif
`ifdef HG_CHAIN
    wire next_in = i_next;
`else
    wire next_in = 1'b1;
`endif
    wire sync_out, next_out, trigger_out, test_out, rx, tx;
`ifdef HG_TRIGGER_OUT
    assign o_trigger = trigger_out;
`endif
`ifdef HG_TEST
    assign o_test = test_out;
`endif
`ifdef HG_CHAIN
    assign o_next = next_out;
`endif
`ifdef HG_SYNC_OUT
    assign o_sync = sync_out;
`endif
    wire clk, locked, starting, enabled, alive, running, playing, fault, cycle_start, led;
    wire [CHANNELS-1:0] pins;
    wire late;
    ecp5_50mhz pll (.i_clk(i_clk), .clk(clk), .o_late(late), .o_locked(locked));
    power_on start (.clk(clk), .i_locked(locked), .rst(starting));
    // A register of its own: the way to all that is reset is the longest there is.
    reg rst;
    initial rst = 1'b1;
    always @(posedge clk) rst <= starting;

    wire       net_valid, net_lost, net_end, net_off, net_stop, core_off, reply_valid, reply_ready;
    wire [7:0] net_byte, reply_byte;
    wire [4:0] identity_place;
    wire [15:0] identity_word;
    wire [2:0]  net_old;
`ifdef HG_NET
    wire       net_clk, net_dv, net_er, net_en;
    wire [7:0] net_data, net_sent;
    ecp5_rgmii #(.RX_DELAY(`HG_NET_RX_DELAY), .TX_DELAY(`HG_NET_TX_DELAY)) phy (
        .i_rx_clk(i_net_rx_clk), .i_rx_ctl(i_net_rx_ctl), .i_rx(i_net_rx), .o_tx_clk(o_net_tx_clk), .o_tx_ctl(o_net_tx_ctl), .o_tx(o_net_tx),
        .clk(net_clk), .o_dv(net_dv), .o_er(net_er), .o_data(net_data), .i_en(net_en), .i_data(net_sent));
    udp_link #(.MAC(48'h`HG_NET_MAC), .IP(32'h`HG_NET_IP)) network (
        .eth_clk(net_clk), .i_dv(net_dv), .i_er(net_er), .i_data(net_data), .o_en(net_en), .o_data(net_sent),
        .clk(clk), .rst(rst), .o_valid(net_valid), .o_byte(net_byte), .i_take(net_valid), .i_valid(reply_valid), .o_ready(reply_ready),
        .i_byte(reply_byte), .o_old(net_old), .o_lost(net_lost), .o_end(net_end), .o_off(net_off), .o_stop(net_stop), .i_off(core_off), .i_enabled(enabled),
        .o_identity_place(identity_place), .i_identity_word(identity_word));
    assign rx = 1'b1;
`else
    assign {net_valid, net_byte, net_old, net_lost, net_end, net_off, net_stop, reply_ready, identity_place} = 22'd0;
    assign rx = i_rx;
    assign o_tx = tx;
`endif
    wire [2:0]  sdram_command;
    wire [1:0]  sdram_bank;
    wire [10:0] sdram_address;
    wire [31:0] sdram_data, sdram_word;
    wire        sdram_drive;
    wire        flash_cs_n, flash_clk, to_flash, from_flash;
`ifdef HG_SDRAM
    ecp5_sdram #(.BANK_BITS(SDRAM / 8 + 1)) chip (
        .clk(clk), .i_late(late), .i_command(sdram_command), .i_bank(sdram_bank[SDRAM/8:0]), .i_address(sdram_address),
        .i_data(sdram_data), .i_drive(sdram_drive), .o_data(sdram_word),
        .o_clk(o_sdram_clk), .o_ras_n(o_sdram_ras_n), .o_cas_n(o_sdram_cas_n), .o_we_n(o_sdram_we_n), .o_bank(o_sdram_bank),
        .o_address(o_sdram_address), .io_data(io_sdram_data));
    assign {o_flash_cs_n, o_flash_data, from_flash} = {flash_cs_n, to_flash, i_flash_data};
    USRMCLK flash_pin (.USRMCLKI(flash_clk), .USRMCLKTS(1'b0));  // its clock's ball is the configuration's own
`else
    assign {sdram_word, from_flash} = 33'd0;
`endif
    haptogram_core #(
        `include "parameter_connections.vh"
        .PRIMARY_FILE(PRIMARY_FILE), .SEQUENCE_FILE(SEQUENCE_FILE)
    ) core (
        .clk(clk), .rst(rst), .i_rx(rx), .i_stop(stop), .i_sync(sync_in), .o_sync(sync_out), .i_trigger(trigger_in), .o_trigger(trigger_out), .o_test(test_out), .o_tx(tx), .i_next(next_in), .o_next(next_out),
        .i_net_valid(net_valid), .i_net_byte(net_byte), .i_net_old(net_old), .i_net_lost(net_lost), .i_net_end(net_end), .i_net_off(net_off), .i_net_stop(net_stop), .o_net_off(core_off), .o_net_valid(reply_valid),
        .i_net_ready(reply_ready), .o_net_byte(reply_byte), .i_identity_place(identity_place), .o_identity_word(identity_word),
        .o_sdram_command(sdram_command), .o_sdram_bank(sdram_bank), .o_sdram_address(sdram_address), .o_sdram_data(sdram_data),
        .o_sdram_drive(sdram_drive), .i_sdram_data(sdram_word), .o_flash_cs_n(flash_cs_n), .o_flash_clk(flash_clk), .o_flash_data(to_flash), .i_flash_data(from_flash), .o_pins(pins), .o_enabled(enabled), .o_alive(alive),
        .o_playing(playing), .o_fault(fault), .o_index(), .o_cycle_start(cycle_start));
    clock_watch watch (.i_alive(alive), .o_running(running));
`ifdef HG_DRIVER_ENABLE
    assign o_driver_enable = (enabled && running) == 1'b`HG_DRIVER_ENABLE;
`endif
`ifdef HG_ALIVE
    assign o_alive = alive;
`endif
`ifdef HG_ACTIVE_LOW
    assign o_pins = ~pins;
`else
    assign o_pins = pins;
`endif
    status_led status (
        .clk(clk), .rst(rst), .i_alive(alive), .i_cycle_start(cycle_start), .i_playing(playing), .i_fault(fault), .o_led(led));
`ifdef HG_LED
    assign o_led = led;
`endif
`ifdef HG_HIGH
    assign o_high = {`HG_HIGH{1'b1}};
`endif
endmodule
`default_nettype wire
