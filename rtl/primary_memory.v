// SPDX-License-Identifier: Apache-2.0
//
// Every record of every focal point, in 16-bit words: one write port, one read port, data one clock after the address.
// A read of the word being written gives the old word. INIT_FILE, when not empty, is a $readmemh file.
`default_nettype none
module primary_memory #(
    parameter WORDS     = 41600,
    parameter INIT_FILE = ""
) (
    input  wire        clk,
    input  wire        i_write,
    input  wire [26:0] i_write_address,
    input  wire [15:0] i_write_word,
    input  wire [26:0] i_read_address,
    output reg  [15:0] o_word
);
    localparam BITS = $clog2(WORDS);
    reg [15:0] words [0:WORDS-1];

    generate
        if (INIT_FILE != "") begin : initialised
            initial $readmemh(INIT_FILE, words);
        end
    endgenerate

    always @(posedge clk) begin
        if (i_write) words[i_write_address[BITS-1:0]] <= i_write_word;
        o_word <= words[i_read_address[BITS-1:0]];
    end

    wire unused = &{1'b0, i_write_address[26:BITS], i_read_address[26:BITS]};
endmodule
`default_nettype wire
