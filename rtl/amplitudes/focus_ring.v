// SPDX-License-Identifier: Apache-2.0
//
// The ring in primary memory into which PUSH_FOCI writes focus records: where the next one goes, and which index it has.
//
// A record is free again when its index and the next index have been taken out of the live FIFO, because the record may still be read until then. So a ring of more records than
// the FIFO has places never overwrites a waiting record, and the FIFO's free places are those of the ring. A refused frame has written to free places only, and its records do
// not count: the ring's end moves with i_keep.
// o_usable and o_fits judge a frame: the ring is as the ring block in INTERFACE.md demands, and the frame's words find room. They are valid two clocks after their inputs:
// settings of an earlier frame, i_tail_words and i_live_free. From i_settle on o_address is the place of the frame's first word. With each i_write the next word goes to the
// next address, or to o_start after o_wraps. o_complete says that the word of i_write is the last one of its record, whose index is o_index; o_split says that the frame ended
// within a record.
// PRIMARY_WORDS, RECORDS and LIVE_DEPTH are the core's. WORD_BITS is as wide as the address of a 16-bit word in the largest region.
`default_nettype none
`include "interface.vh"
module focus_ring #(
    parameter PRIMARY_WORDS = 41600,
    parameter RECORDS       = 400,
    parameter LIVE_DEPTH    = 256,
    parameter WORD_BITS     = 16
) (
    input  wire        clk,
    input  wire        i_set,          // strobe: i_set_word is for word i_set_address of the ring block
    input  wire [4:0]  i_set_address,
    input  wire [15:0] i_set_word,
    input  wire [4:0]  i_read_address,
    output reg  [15:0] o_word,         // a clock later
    input  wire [2:0]  i_foci_last,    // the foci of each record, less one
    input  wire [15:0] i_top_index,
    input  wire [15:0] i_live_free,
    input  wire [15:0] i_tail_words,
    output reg         o_usable,
    output wire        o_fits,
    input  wire        i_settle,       // strobe: a frame begins
    input  wire        i_write,
    input  wire [WORD_BITS-1:0] i_address,  // of the word after the last one that was written
    input  wire        i_keep,         // strobe: what was written counts
    output wire [WORD_BITS-1:0] o_address,
    output wire [WORD_BITS-1:0] o_start,
    output wire        o_wraps,
    output wire        o_complete,
    output reg  [15:0] o_index,
    output wire        o_split
);
    localparam integer ALL_WORDS = PRIMARY_WORDS;
    localparam [22:0] WORDS = ALL_WORDS[22:0];
    localparam [15:0] LEAST = LIVE_DEPTH[15:0];
    localparam [15:0] TOP_RECORD = RECORDS[15:0];

    reg [15:0] base_q, first_q, count_q;
    reg        begins_q;
    reg [WORD_BITS-1:0] address_q;   // where the ring's end is, and the index of the record there
    reg [15:0] index_q;
    reg [4:0]  word_q;               // of the present record
    reg [22:0] room_q;
    reg [22:0] beyond_q;             // the word after the ring
    wire [3:0]  foci  = {1'b0, i_foci_last} + 4'd1;
    wire [19:0] all   = count_q * {16'd0, foci};     // foci in the ring
    wire [19:0] free  = i_live_free * {16'd0, foci};
    wire [16:0] last  = {1'b0, first_q} + {1'b0, count_q} - 17'd1;
    wire [27:0] start = {10'd0, base_q, 2'b00};
    wire        at_last = {1'b0, o_index} == last;

    assign o_fits     = {7'd0, i_tail_words} <= room_q;
    assign o_address  = address_q;
    assign o_start    = start[WORD_BITS-1:0];
    assign o_complete = word_q == {i_foci_last, 2'b11};
    assign o_wraps    = o_complete && at_last;
    assign o_split    = word_q != 5'd0;

    initial count_q = 16'd0;
    always @(posedge clk) begin
        if (i_set) case (i_set_address)
            `HG_RING_BASE:  base_q  <= i_set_word;
            `HG_RING_FIRST: first_q <= i_set_word;
            default:        count_q <= i_set_word;
        endcase
        o_word   <= i_read_address == `HG_RING_BASE ? base_q : i_read_address == `HG_RING_FIRST ? first_q : count_q;
        beyond_q <= start[22:0] + {1'b0, all, 2'b00};
        o_usable <= count_q > LEAST && first_q > TOP_RECORD && last <= {1'b0, i_top_index} && beyond_q <= WORDS;
        room_q   <= {1'b0, free, 2'b00};

        begins_q <= i_set;
        if (begins_q) {address_q, index_q} <= {o_start, first_q};
        else if (i_keep) {address_q, index_q} <= {i_address, o_index};
        if (i_settle) {o_index, word_q} <= {index_q, 5'd0};
        else if (i_write) begin
            word_q <= o_complete ? 5'd0 : word_q + 5'd1;
            if (o_complete) o_index <= at_last ? first_q : o_index + 16'd1;
        end
    end

    wire unused = &{1'b0, start};
endmodule
`default_nettype wire
