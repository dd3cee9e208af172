// SPDX-License-Identifier: Apache-2.0
//
// Gathers the words that a frame writes into a run of whole words of an SDRAM, because the chip cannot write halves of a word.
//
// Addresses are those of 16-bit words, two of which make a word of the chip. A word is taken in each clock with i_write, unless o_hold is
// high. Each word goes behind the one before it, until the run ends: i_more falls, or after a word with i_ends. Then the words are written as
// one run. If the run begins or ends within a word of the chip, the other half is read first; no other module writes to the chip.
// o_busy: something is not written yet. o_pending: a run has ended and waits, or is being written.
// i_ask and the rest of the run's ports are those of sdram_controller. There must be room for the longest frame: 2^RUN_BITS words of the chip.
`default_nettype none
module record_store #(
    parameter RUN_BITS     = 9,
    parameter WORD_BITS    = 21,
    parameter ADDRESS_BITS = 22  // of 16-bit words, at most WORD_BITS + 1
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_more,     // a word to write is here
    input  wire                    i_write,    // and taken
    input  wire                    i_ends,     // as the last one of its run
    input  wire [ADDRESS_BITS-1:0] i_address,
    input  wire [15:0]             i_half,
    output wire                    o_hold,
    output wire                    o_busy,
    output wire                    o_pending,
    output wire                    o_ask,
    output wire                    o_write,
    output wire [WORD_BITS-1:0]    o_first,
    output wire [RUN_BITS-1:0]     o_last,
    input  wire                    i_take,
    input  wire                    i_next,
    output reg  [31:0]             o_word,
    input  wire                    i_valid,
    input  wire [31:0]             i_word,
    input  wire                    i_done
);
    localparam [1:0] GATHER = 2'd0, FILL_LOW = 2'd1, FILL_HIGH = 2'd2, WRITE = 2'd3;

    reg [1:0]              state_q;
    reg                    asked_q;              // the run has been taken
    reg                    filled_q, ended_q;    // there are words; the last one of the run has come
    reg                    low_q, fetched_q;     // half_q is the lower half of the next word; it was read
    reg [15:0]             half_q;
    reg [WORD_BITS-1:0]    first_q;
    reg [WORD_BITS-1:0]    last_q;
    reg [RUN_BITS-1:0]     place_q;              // of the word that is being written
    (* no_rw_check *) reg [31:0] words [0:(1 << RUN_BITS)-1];

    wire [WORD_BITS:0]   address = {{(WORD_BITS+1-ADDRESS_BITS){1'b0}}, i_address};
    wire [RUN_BITS-1:0]  count = last_q[RUN_BITS-1:0] - first_q[RUN_BITS-1:0];  // less one
    wire [RUN_BITS-1:0]  place_d = state_q != WRITE || !asked_q ? first_q[RUN_BITS-1:0] : place_q + {{(RUN_BITS-1){1'b0}}, i_next};
    wire ends  = filled_q && (ended_q || !i_more);
    wire lacks = !filled_q && i_address[0] && !fetched_q;
    wire fills = state_q == FILL_HIGH && i_valid;
    wire puts  = (i_write && i_address[0]) || fills;
    assign o_hold    = state_q != GATHER || ends || lacks;
    assign o_busy    = state_q != GATHER || filled_q;
    assign o_pending = state_q[1] || (state_q == GATHER && ends);
    assign o_ask     = state_q != GATHER && !asked_q;
    assign o_write   = state_q == WRITE;
    assign o_first   = state_q == FILL_LOW ? address[WORD_BITS:1] : state_q == FILL_HIGH ? last_q : first_q;
    assign o_last    = state_q == WRITE ? count : {RUN_BITS{1'b0}};

    always @(posedge clk) begin
        if (puts) words[fills ? last_q[RUN_BITS-1:0] : address[RUN_BITS:1]] <= {fills ? i_word[31:16] : i_half, half_q};
        o_word  <= words[place_d];
        place_q <= place_d;
    end

    always @(posedge clk) begin
        if (i_take) asked_q <= 1'b1;
        case (state_q)
            GATHER: begin
                asked_q <= 1'b0;
                if (ends) state_q <= low_q ? FILL_HIGH : WRITE;
                else if (i_more && lacks) state_q <= FILL_LOW;
            end
            WRITE: if (i_done) {state_q, filled_q, ended_q} <= {GATHER, 2'b00};
            default: if (i_valid) begin
                state_q <= state_q == FILL_LOW ? GATHER : WRITE;
                asked_q <= 1'b0;
                fetched_q <= state_q == FILL_LOW;
                if (state_q == FILL_LOW) half_q <= i_word[15:0];
            end
        endcase
        if (i_write) begin
            {filled_q, ended_q, fetched_q} <= {1'b1, i_ends, 1'b0};
            {low_q, last_q} <= {!i_address[0], address[WORD_BITS:1]};
            if (!i_address[0]) half_q <= i_half;
            if (!filled_q) first_q <= address[WORD_BITS:1];
        end
        if (rst) {state_q, filled_q, ended_q, fetched_q} <= {GATHER, 3'b000};
    end

    wire unused = &{1'b0, address};
endmodule
`default_nettype wire
