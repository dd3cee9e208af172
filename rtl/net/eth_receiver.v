// SPDX-License-Identifier: Apache-2.0
//
// Finds the Ethernet frames in what a PHY receives, and says at the end of each whether it is whole.
//
// i_dv, i_er and i_data are GMII. The bytes from the destination to the FCS come out on o_valid and o_byte, two clocks later. o_end strobes
// in a clock after the last one, together with o_good: right FCS, 64 to 1,518 bytes, and no error of the PHY in any of them.
`default_nettype none
module eth_receiver (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_dv,
    input  wire       i_er,
    input  wire [7:0] i_data,
    output reg        o_valid,
    output reg  [7:0] o_byte,
    output reg        o_end,
    output reg        o_good
);
    localparam [1:0]  QUIET = 2'd0, PREAMBLE = 2'd1, FRAME = 2'd2, SKIP = 2'd3;
    localparam [10:0] SHORTEST = 64, LONGEST = 1518, MOST = 11'h7ff;
    `include "crc32.vh"

    reg [1:0]  state_q;
    reg        dv_q, er_q, wrong_q, enough_q, over_q;
    reg [7:0]  data_q;
    reg [31:0] crc_q;
    reg [10:0] count_q;  // bytes of the frame, up to MOST
    initial {state_q, dv_q, o_valid, o_end} = {SKIP, 3'd0};
    wire in_frame = state_q == FRAME;

    always @(posedge clk) begin
        {dv_q, er_q, data_q} <= {i_dv, i_er, i_data};
        {o_valid, o_byte}    <= {in_frame && dv_q && !rst, data_q};
        o_end    <= in_frame && !dv_q && !rst;
        o_good   <= crc_q == 32'hdebb20e3 && enough_q && !over_q && !wrong_q;
        // These compare what has come until the clock before, because the FCS leaves no time for it.
        enough_q <= count_q >= SHORTEST - 11'd1;
        over_q   <= count_q >= LONGEST;
        if (!in_frame) {crc_q, count_q, wrong_q} <= {32'hffffffff, 12'd0};
        else if (dv_q) begin
            crc_q   <= crc32(crc_q, data_q);
            wrong_q <= wrong_q || er_q;
            if (count_q != MOST) count_q <= count_q + 11'd1;
        end
        case (state_q)
            QUIET:    if (dv_q) state_q <= data_q == 8'h55 ? PREAMBLE : SKIP;
            PREAMBLE: if (!dv_q) state_q <= QUIET;
                      else if (data_q != 8'h55) state_q <= data_q == 8'hd5 && !er_q ? FRAME : SKIP;
            default:  if (!dv_q) state_q <= QUIET;
        endcase
        if (rst) state_q <= SKIP;  // what is left of a frame is none
    end
endmodule
`default_nettype wire
