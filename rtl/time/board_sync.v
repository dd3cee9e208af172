// SPDX-License-Identifier: Apache-2.0
//
// Has all that a board needs for SYNC: its role, the wire to other boards, and the number of the present carrier period, which all boards share.
// Without SYNC the board is alone; with SCHEDULE it then counts periods by itself; without both nothing of this module is left.
//
// i_reset strobes when a command resets what plays. If i_takes_role comes with it, the command is SYNC, and the board has role i_role from the next
// clock on; otherwise it is ALONE. play_rst follows i_reset by a clock and restarts whatever counts. While o_hold is high, the cycle's last clock,
// i_last, is repeated; carrier_sync.v says why and how long. o_out_of_step: the board is a slave and not in step. o_numbered: o_period is also the
// master's number. o_missed and o_lost are carrier_sync's.
`default_nettype none
`include "interface.vh"
module board_sync #(
    parameter SYNC          = 0,
    parameter SCHEDULE      = 0,
    parameter PERIOD_CLOCKS = 1250
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        play_rst,
    input  wire        i_reset,
    input  wire        i_takes_role,
    input  wire [1:0]  i_role,
    input  wire        i_sync,         // not synchronous to clk
    output wire        o_sync,
    input  wire        i_last,
    output wire        o_hold,
    input  wire        i_cycle_start,  // counts when there is no SYNC
    output wire [1:0]  o_role,
    output wire        o_in_step,
    output wire        o_out_of_step,
    output wire        o_numbered,
    output wire        o_missed,
    output wire        o_lost,
    output wire [47:0] o_period
);
    generate
        if (SYNC != 0) begin : with_others
            wire [1:0]  symbol, sent;
            wire [47:0] master_period;
            wire        ends, load, agreed;
            reg         begins_q;
            always @(posedge clk) begins_q <= ends && !play_rst;
            reg  [1:0]  role_q;
            initial role_q = `HG_ROLE_ALONE;
            assign o_role = role_q;
            always @(posedge clk) if (rst || i_reset) role_q <= i_takes_role && !rst ? i_role : `HG_ROLE_ALONE;
            carrier_sync #(.PERIOD_CLOCKS(PERIOD_CLOCKS)) steps (
                .clk(clk), .rst(play_rst), .i_role(role_q),
                .i_sync(i_sync), .o_sync(o_sync), .i_last(i_last), .o_hold(o_hold), .i_symbol(sent), .o_symbol(symbol), .o_ends(ends),
                .o_in_step(o_in_step), .o_missed(o_missed), .o_lost(o_lost));
            assign o_out_of_step = role_q == `HG_ROLE_SLAVE && !o_in_step;
            sync_number number (
                .clk(clk), .rst(play_rst || o_out_of_step), .i_count(o_period), .o_symbol(sent),
                .i_valid(ends && role_q == `HG_ROLE_SLAVE), .i_symbol(symbol), .o_load(load), .o_value(master_period), .o_agreed(agreed));
            period_count periods (
                .clk(clk), .rst(play_rst), .i_period(begins_q), .i_load(load), .i_value(master_period), .o_count(o_period));
            assign o_numbered = role_q == `HG_ROLE_MASTER || agreed;
            wire unused = &{1'b0, i_cycle_start};
        end else begin : alone
            assign o_role = `HG_ROLE_ALONE;
            assign {o_sync, o_hold, o_in_step, o_out_of_step, o_numbered, o_missed, o_lost} = 7'd0;
            if (SCHEDULE != 0) begin : counts
                period_count periods (.clk(clk), .rst(play_rst), .i_period(i_cycle_start), .i_load(1'b0), .i_value(48'd0), .o_count(o_period));
            end else begin : counts_nothing
                assign o_period = 48'd0;
                wire unused_clock = &{1'b0, clk, play_rst, i_cycle_start};
            end
            wire unused = &{1'b0, rst, i_reset, i_takes_role, i_role, i_sync, i_last};
        end
    endgenerate
endmodule
`default_nettype wire
