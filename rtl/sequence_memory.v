// SPDX-License-Identifier: Apache-2.0
//
// Holds the order of play, in 32-bit words: word 0 is the header, the others are entries (INTERFACE.md says their fields).
//
// The link writes halves, low half first; the word changes when its high half arrives, so a reader never sees half a change.
// A word arrives two clocks after its address. It must not be read in the clock in which it changes; address_space makes the
// writer wait.
// WORDS is the core's SEQUENCE_DEPTH, 2 to 32768: the header's length has 15 bits. INIT_FILE is a $readmemh file for power-up;
// empty means all zeros.
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
        end else begin : empty  // so that a bitstream without an image cannot have the autostart bit
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
