// SPDX-License-Identifier: Apache-2.0
//
// What the open port answers, byte by byte: INTERFACE.md has its fields. o_byte is that of i_place two clocks later.
//
// The counters are of datagrams: taken from the peer, refused from others, and damaged, as udp_receiver says.
`default_nettype none
`include "interface.vh"
module about_block (
    input  wire        clk,
    input  wire [5:0]  i_place,
    input  wire [7:0]  i_command,
    input  wire [7:0]  i_flags,
    output wire [4:0]  o_identity_place,
    input  wire [15:0] i_identity_word,  // constants: combinational
    input  wire        i_accepted,       // strobes
    input  wire        i_refused,
    input  wire        i_damaged,
    output reg  [7:0]  o_byte
);
    localparam [5:0] COUNTERS = 6'd2 + `HG_IDENTITY_WORDS;
    reg [15:0] accepted_q, refused_q, damaged_q, own_q, identity_q;
    reg        high_q, is_own_q;
    wire [5:0] word = {1'b0, i_place[5:1]};
    initial {accepted_q, refused_q, damaged_q} = 48'd0;
    assign o_identity_place = i_place[5:1] - 5'd2;
    always @(posedge clk) begin
        if (i_accepted) accepted_q <= accepted_q + 16'd1;
        if (i_refused) refused_q <= refused_q + 16'd1;
        if (i_damaged) damaged_q <= damaged_q + 16'd1;
        case (word)
            6'd0:            own_q <= 16'h4748;  // HG
            6'd1:            own_q <= {i_flags, i_command | 8'h80};
            COUNTERS:        own_q <= accepted_q;
            COUNTERS + 6'd1: own_q <= refused_q;
            default:         own_q <= damaged_q;
        endcase
        is_own_q   <= word < 6'd2 || word >= COUNTERS;
        identity_q <= i_identity_word;
        high_q     <= i_place[0];
        o_byte     <= is_own_q ? (high_q ? own_q[15:8] : own_q[7:0]) : high_q ? identity_q[15:8] : identity_q[7:0];
    end
endmodule
`default_nettype wire
