// SPDX-License-Identifier: Apache-2.0
//
// The order of play, in 32-bit words: word 0 is {loops, length}, the others are {dwell, index}. Written in halves, low
// half first; the word changes when its high half arrives. Data two clocks after the address.
// A word must not be read in the clock in which it changes: the core makes the writer wait.
`default_nettype none
module sequence_memory #(
    parameter WORDS     = 1024,
    parameter INIT_FILE = "",
    parameter BITS      = $clog2(WORDS)  // follows from WORDS
) (
    input  wire        clk,
    input  wire        i_write,
    input  wire [BITS:0]   i_write_address,  // of 16-bit halves
    input  wire [15:0] i_write_half,
    input  wire [BITS-1:0] i_read_address,   // of 32-bit words
    output reg  [31:0] o_word
);
    (* no_rw_check *) reg [31:0] words [0:WORDS-1];
    reg [15:0] low_q;
    reg [31:0] read_q;

    generate
        if (INIT_FILE != "") begin : initialised
            initial $readmemh(INIT_FILE, words);
        end else begin : empty  // a bitstream without an image must not look like one that starts by itself
            integer i;
            initial for (i = 0; i < WORDS; i = i + 1) words[i] = 32'd0;
        end
        if (WORDS < 2 || WORDS > 32768) words_out_of_range error();
    endgenerate

    always @(posedge clk) begin
        if (i_write && !i_write_address[0]) low_q <= i_write_half;
        if (i_write && i_write_address[0]) words[i_write_address[BITS:1]] <= {i_write_half, low_q};
        read_q <= words[i_read_address];
        o_word <= read_q;
    end
endmodule
`default_nettype wire
