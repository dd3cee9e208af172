// SPDX-License-Identifier: Apache-2.0
//
// What a board has for SYNC, as board_sync wires it; the number of the period can be set.
`default_nettype none
module sync_tile_bench #(
    parameter PERIOD_CLOCKS = 256
) (
    input  wire        clk,
    input  wire        rst,
    input  wire [1:0]  i_role,
    input  wire        i_sync,
    output wire        o_sync,
    input  wire        i_last,
    output wire        o_ends,
    output wire        o_in_step,
    output wire        o_agreed,
    input  wire        i_set,
    input  wire [47:0] i_number,
    output wire [47:0] o_number
);
    wire [1:0]  symbol, sent;
    wire [47:0] heard;
    wire        load, hold, missed, lost;
    wire        unused = &{1'b0, hold, missed, lost};
    reg         begins_q;
    always @(posedge clk) begins_q <= o_ends && !rst;
    carrier_sync #(.PERIOD_CLOCKS(PERIOD_CLOCKS)) steps (
        .clk(clk), .rst(rst), .i_role(i_role), .i_sync(i_sync), .o_sync(o_sync), .i_last(i_last), .o_hold(hold), .i_symbol(sent),
        .o_symbol(symbol), .o_ends(o_ends), .o_in_step(o_in_step), .o_missed(missed), .o_lost(lost));
    sync_number number (
        .clk(clk), .rst(rst || (i_role == 2'd2 && !o_in_step)), .i_count(o_number), .o_symbol(sent), .i_valid(o_ends && i_role == 2'd2),
        .i_symbol(symbol), .o_load(load), .o_value(heard), .o_agreed(o_agreed));
    period_count periods (
        .clk(clk), .rst(rst), .i_period(begins_q), .i_load(load || i_set), .i_value(i_set ? i_number : heard), .o_count(o_number));
endmodule
`default_nettype wire
