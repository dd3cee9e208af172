// SPDX-License-Identifier: Apache-2.0
//
// Primary and sequence memory, and who may use them: what plays comes first, a reply waits for its word (o_granted), and a
// writer waits for the one clock in which its word is being read (o_hold). Words arrive two clocks after their address.
`default_nettype none
`include "interface.vh"
module address_space #(
    parameter PRIMARY_WORDS  = 41600,
    parameter SEQUENCE_DEPTH = 1024,
    parameter WORD_BITS      = 16,  // of a 16-bit word's address in any region
    parameter PRIMARY_FILE   = "",
    parameter SEQUENCE_FILE  = "",
    parameter PRIMARY_BITS   = $clog2(PRIMARY_WORDS),  // follow from the others
    parameter SEQUENCE_BITS  = $clog2(SEQUENCE_DEPTH)
) (
    input  wire                     clk,
    input  wire [3:0]               i_region,           // of both writes and replies
    input  wire                     i_write,            // only while not o_hold
    input  wire [WORD_BITS-1:0]     i_write_address,
    input  wire [15:0]              i_write_word,
    output wire                     o_hold,
    input  wire [WORD_BITS-1:0]     i_read_address,     // for a reply
    input  wire [15:0]              i_register_word,    // of the identity and status blocks
    output wire                     o_granted,
    output wire [15:0]              o_read_word,
    input  wire                     i_loading,          // a record: i_load_address is in use
    input  wire [PRIMARY_BITS-1:0]  i_load_address,
    output wire [15:0]              o_primary_word,
    input  wire                     i_fetching,         // a sequence entry
    input  wire [SEQUENCE_BITS-1:0] i_sequence_address,
    output wire [31:0]              o_sequence_word
);
    wire in_primary  = i_region == `HG_REGION_PRIMARY;
    wire in_sequence = i_region == `HG_REGION_SEQUENCE;
    reg  [1:0]  high_half_q;
    reg  [15:0] register_q;
    always @(posedge clk) {high_half_q, register_q} <= {high_half_q[0], i_read_address[0], i_register_word};

    assign o_hold      = in_primary ? i_loading && i_load_address == i_write_address[PRIMARY_BITS-1:0] : in_sequence && i_fetching;
    assign o_granted   = in_primary ? !i_loading : !in_sequence || !i_fetching;
    assign o_read_word = in_primary ? o_primary_word
                       : !in_sequence ? register_q
                       : high_half_q[1] ? o_sequence_word[31:16] : o_sequence_word[15:0];

    primary_memory #(.WORDS(PRIMARY_WORDS), .INIT_FILE(PRIMARY_FILE)) primary (
        .clk(clk), .i_write(i_write && in_primary), .i_write_address(i_write_address[PRIMARY_BITS-1:0]), .i_write_word(i_write_word),
        .i_read_address(i_loading ? i_load_address : i_read_address[PRIMARY_BITS-1:0]), .o_word(o_primary_word));
    sequence_memory #(.WORDS(SEQUENCE_DEPTH), .INIT_FILE(SEQUENCE_FILE)) sequence_words (
        .clk(clk), .i_write(i_write && in_sequence), .i_write_address(i_write_address[SEQUENCE_BITS:0]), .i_write_half(i_write_word),
        .i_read_address(i_fetching ? i_sequence_address : i_read_address[SEQUENCE_BITS:1]), .o_word(o_sequence_word));
endmodule
`default_nettype wire
