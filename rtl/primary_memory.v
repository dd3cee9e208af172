// SPDX-License-Identifier: Apache-2.0
//
// Holds all records, in 16-bit words, with one port to write and one to read.
//
// A word arrives two clocks after its address. A large memory is made of many block RAMs; the second clock leaves time to
// choose between their outputs.
// A word must not be read in the clock in which it is written. address_space makes the writer wait, which costs far fewer cells
// than what synthesis adds to a memory that must answer rightly in that case; no_rw_check says that it need not.
// WORDS is RECORDS · (CHANNELS + 4). INIT_FILE is a $readmemh file for power-up; empty leaves the contents open.
`default_nettype none
module primary_memory #(
    parameter WORDS     = 41600,
    parameter INIT_FILE = "",
    parameter BITS      = $clog2(WORDS)  // follows from WORDS
) (
    input  wire        clk,
    input  wire        i_write,
    input  wire [BITS-1:0] i_write_address,
    input  wire [15:0] i_write_word,
    input  wire [BITS-1:0] i_read_address,
    output reg  [15:0] o_word
);
    (* no_rw_check *) reg [15:0] words [0:WORDS-1];
    reg [15:0] read_q;

    generate
        if (INIT_FILE != "") begin : initialised
            initial $readmemh(INIT_FILE, words);
        end
    endgenerate

    always @(posedge clk) begin
        if (i_write) words[i_write_address] <= i_write_word;
        read_q <= words[i_read_address];
        o_word <= read_q;
    end
endmodule
`default_nettype wire
