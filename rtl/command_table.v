// Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file.
// SPDX-License-Identifier: Apache-2.0
//
// The shape of each command: how many argument words it has, whether data words follow, what its reply
// carries (0 nothing, 1 identity block, 2 status block, 3 memory or its digest). Combinational.
`default_nettype none
module command_table (
    input  wire [7:0] i_command,
    output reg  [5:0] o_shape  // {known, arguments, tail, reply}
);
    always @* begin
        case (i_command)
            8'h01: o_shape = {1'b1, 2'd0, 1'b0, 2'd1};  // identify
            8'h02: o_shape = {1'b1, 2'd2, 1'b1, 2'd0};  // write
            8'h03: o_shape = {1'b1, 2'd3, 1'b0, 2'd3};  // read
            8'h04: o_shape = {1'b1, 2'd0, 1'b0, 2'd0};  // enable
            8'h05: o_shape = {1'b1, 2'd0, 1'b0, 2'd0};  // disable
            8'h06: o_shape = {1'b1, 2'd2, 1'b0, 2'd0};  // select
            8'h07: o_shape = {1'b1, 2'd1, 1'b1, 2'd0};  // push
            8'h08: o_shape = {1'b1, 2'd3, 1'b0, 2'd0};  // start
            8'h09: o_shape = {1'b1, 2'd0, 1'b0, 2'd0};  // stop
            8'h0a: o_shape = {1'b1, 2'd1, 1'b0, 2'd0};  // watchdog
            8'h0b: o_shape = {1'b1, 2'd0, 1'b0, 2'd2};  // status
            8'h0c: o_shape = {1'b1, 2'd3, 1'b0, 2'd3};  // digest
            8'h0d: o_shape = {1'b1, 2'd0, 1'b0, 2'd0};  // keep_alive
            8'h0e: o_shape = {1'b1, 2'd0, 1'b0, 2'd0};  // reset
            8'h0f: o_shape = {1'b1, 2'd3, 1'b0, 2'd0};  // modulate
            8'h10: o_shape = {1'b1, 2'd3, 1'b0, 2'd0};  // gate
            8'h11: o_shape = {1'b1, 2'd1, 1'b1, 2'd0};  // push_foci
            8'h12: o_shape = {1'b1, 2'd3, 1'b1, 2'd0};  // stream
            8'h18: o_shape = {1'b1, 2'd1, 1'b0, 2'd0};  // sync
            default: o_shape = 6'd0;
        endcase
    end
endmodule
`default_nettype wire
