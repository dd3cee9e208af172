// SPDX-License-Identifier: Apache-2.0
//
// Holds primary and sequence memory and shares each between its three users: what plays, replies, and writes. The memory of the
// modulation's samples, which is where it is played, is shared by the same rules.
//
// Each memory has one port to read and one to write. The player's reads always go first. A reply waits until o_granted. A write
// waits while o_hold is high, that is in a clock in which its word is being read, because the memories do not say what such a
// read returns. A word arrives two clocks after its address.
// With SDRAM, primary memory is beside the core: what i_sdram_hold, i_sdram_granted and i_sdram_word say takes the place of it.
// PRIMARY_WORDS is RECORDS · (CHANNELS + 4) of the core. WORD_BITS is as wide as the address of a 16-bit word in the largest
// region. PRIMARY_FILE and SEQUENCE_FILE fill the memories at power-up ($readmemh); empty leaves them as the device does.
`default_nettype none
`include "interface.vh"
module address_space #(
    parameter PRIMARY_WORDS  = 41600,
    parameter SEQUENCE_DEPTH = 1024,
    parameter WORD_BITS      = 16,
    parameter HAS_SAMPLES    = 0,
    parameter SDRAM          = 0,
    parameter PRIMARY_FILE   = "",
    parameter SEQUENCE_FILE  = "",
    parameter PRIMARY_BITS   = $clog2(PRIMARY_WORDS),  // these two follow from the others
    parameter SEQUENCE_BITS  = $clog2(SEQUENCE_DEPTH)
) (
    input  wire                     clk,
    input  wire [3:0]               i_region,           // of the write and of the reply
    input  wire                     i_write,            // held off while o_hold is high
    input  wire [WORD_BITS-1:0]     i_write_address,
    input  wire [15:0]              i_write_word,
    output wire                     o_hold,
    input  wire [WORD_BITS-1:0]     i_read_address,     // of a reply's word
    input  wire [15:0]              i_register_word,    // a reply's word, when it is of a block
    input  wire [15:0]              i_sample_word,      // or of the modulation's samples
    output wire                     o_granted,
    output wire [15:0]              o_read_word,
    input  wire                     i_loading,          // a record is being read, at i_load_address
    input  wire [PRIMARY_BITS-1:0]  i_load_address,
    output wire [15:0]              o_primary_word,
    input  wire                     i_fetching,         // a sequence entry is being read, at i_sequence_address
    input  wire [SEQUENCE_BITS-1:0] i_sequence_address,
    output wire [31:0]              o_sequence_word,
    input  wire                     i_sampling,         // a sample is being read
    input  wire                     i_sdram_hold,
    input  wire                     i_sdram_granted,
    input  wire [15:0]              i_sdram_word        // of a reply
);
    wire in_primary  = i_region == `HG_REGION_PRIMARY;
    wire in_sequence = i_region == `HG_REGION_SEQUENCE;
    wire in_samples  = HAS_SAMPLES != 0 && i_region == `HG_REGION_MODULATION;
    wire unused = &{1'b0, i_write_address, i_read_address};  // in the smallest cores not all bits name a word
    reg  [1:0]  high_half_q;
    reg  [15:0] register_q;
    always @(posedge clk) {high_half_q, register_q} <= {high_half_q[0], i_read_address[0], i_register_word};

    wire        primary_hold, primary_granted;
    wire [15:0] primary_word;
    assign o_hold      = in_primary ? primary_hold : (in_sequence && i_fetching) || (in_samples && i_sampling);
    assign o_granted   = in_primary ? primary_granted : !((in_sequence && i_fetching) || (in_samples && i_sampling));
    assign o_read_word = in_primary ? primary_word
                       : in_samples ? i_sample_word
                       : !in_sequence ? register_q
                       : high_half_q[1] ? o_sequence_word[31:16] : o_sequence_word[15:0];

    generate
        if (SDRAM != 0) begin : in_sdram
            assign {primary_hold, primary_granted, primary_word} = {i_sdram_hold, i_sdram_granted, i_sdram_word};
            assign o_primary_word = 16'd0;
            wire unused_load = &{1'b0, i_loading, i_load_address};
        end else begin : in_block_ram
            primary_memory #(.WORDS(PRIMARY_WORDS), .INIT_FILE(PRIMARY_FILE)) primary (
                .clk(clk),
                .i_write(i_write && in_primary), .i_write_address(i_write_address[PRIMARY_BITS-1:0]), .i_write_word(i_write_word),
                .i_read_address(i_loading ? i_load_address : i_read_address[PRIMARY_BITS-1:0]), .o_word(o_primary_word));
            assign {primary_hold, primary_granted} = {i_loading && i_load_address == i_write_address[PRIMARY_BITS-1:0], !i_loading};
            assign primary_word = o_primary_word;
            wire unused_beside = &{1'b0, i_sdram_hold, i_sdram_granted, i_sdram_word};
        end
    endgenerate
    sequence_memory #(.WORDS(SEQUENCE_DEPTH), .INIT_FILE(SEQUENCE_FILE)) sequence_words (
        .clk(clk),
        .i_write(i_write && in_sequence), .i_write_address(i_write_address[SEQUENCE_BITS:0]), .i_write_half(i_write_word),
        .i_read_address(i_fetching ? i_sequence_address : i_read_address[SEQUENCE_BITS:1]), .o_word(o_sequence_word));
endmodule
`default_nettype wire
