// SPDX-License-Identifier: Apache-2.0
//
// Every record of every focal point, in 16-bit words: one write port, one read port. Data two clocks after the address: large
// memories are many block RAMs, whose words are chosen from in the first and kept in the second.
// A word must not be read in the clock in which it is written: the core makes the writer wait, which costs far less than
// what synthesis would add to a memory that promises an answer (no_rw_check). INIT_FILE, when not empty, is a $readmemh file.
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
