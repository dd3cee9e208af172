// SPDX-License-Identifier: Apache-2.0
//
// Keeps the patterns of a stream until their turn: the pattern for carrier period p in slot p mod 2^i_slot_bits, a record of primary memory.
//
// Each slot has one bit here: its pattern is whole and waits. The bit is set behind the pattern's last word, and cleared at the slot's turn. A
// pattern whose slot is full, or whose turn has been, is not written. So no pattern plays torn or in another period than its own.
// At i_settle, i_period is the period of the frame's first pattern. o_wait holds the frame's words until the pattern is judged. Then o_place says
// that its first word goes to o_address, and o_keeps that its words count. i_take: a word is taken. o_split: the words end within a pattern.
// i_go strobes once a carrier period, when period i_count + 2 is decided. Two clocks later o_turn strobes, also with i_forget: o_full says whether
// that period has a pattern, o_index which record the pattern is. o_jump comes with i_go when periods have not followed each other.
// i_forget empties all slots. While it lasts, patterns are dropped, and so is the pattern that is under way then.
// SLOTS is the core's STREAM; the other parameters are the core's, too.
`default_nettype none
`include "interface.vh"
module pattern_slots #(
    parameter SLOTS     = 256,
    parameter CHANNELS  = 100,
    parameter RECORDS   = 400,
    parameter FOCI      = 8,
    parameter WORD_BITS = 16,
    parameter PERIOD_BITS = 48  // of a period's number; less only makes proofs shorter
) (
    input  wire        clk,
    input  wire        i_forget,
    input  wire [15:0] i_first,       // settings, not to change within a frame
    input  wire [3:0]  i_slot_bits,
    input  wire [15:0] i_foci_base,   // from parameter_registers
    input  wire [15:0] i_foci_count,
    input  wire [2:0]  i_foci_last,
    output reg         o_usable,      // the slots lie within memory; three clocks after the settings
    input  wire        i_settle,      // strobe
    input  wire [PERIOD_BITS-1:0] i_period,
    input  wire        i_take,        // strobe
    input  wire        i_close,       // strobe: the frame has ended
    output wire        o_wait,
    output wire        o_place,       // strobe
    output wire [WORD_BITS-1:0] o_address,
    output wire        o_keeps,
    output wire        o_split,
    output wire        o_late,        // strobes, one of them for each pattern that is not kept
    output wire        o_early,
    output wire        o_repeated,
    input  wire        i_go,          // strobe
    input  wire [PERIOD_BITS-1:0] i_count,
    output wire        o_jump,
    output wire        o_turn,        // strobe
    output wire        o_full,
    output wire [15:0] o_index
);
    localparam BITS = $clog2(SLOTS);
    localparam RECORD_WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam PATTERN_BITS = $clog2(CHANNELS > 4 * FOCI ? CHANNELS : 4 * FOCI);
    localparam [PATTERN_BITS-1:0] LAST_CHANNEL = CHANNELS[PATTERN_BITS-1:0] - 1'b1;
    localparam [PERIOD_BITS-1:0] NONE = 0, ONE = 1;
    localparam [15:0] TOP_RECORD = RECORDS[15:0];
    localparam [3:0]  MOST_BITS = BITS[3:0];
    localparam [26:0] STRIDE = RECORD_WORDS[26:0], HEADER = `HG_RECORD_HEADER_WORDS;

    wire [PERIOD_BITS-1:0] mask = ~({PERIOD_BITS{1'b1}} << i_slot_bits);  // a period's bits that name its slot
    wire [16:0] last_index = {1'b0, i_first} + {1'b0, ~(16'hffff << i_slot_bits)};
    wire        foci = FOCI != 0 && i_first > TOP_RECORD;

    // ---- The present pattern: steps from its period to its place, then its words

    reg [PERIOD_BITS-1:0] period_q;
    reg [15:0] index_q;
    reg [4:1]  steps_q;
    reg [26:0] record_q;
    reg [PATTERN_BITS-1:0] word_q;
    reg        full_q, swept_q, keeps_q, late_q, early_q, repeated_q;
    reg [PERIOD_BITS-1:0] decided_q;    // the last period whose turn has been
    reg [1:0]  turn_q;
    wire [BITS-1:0] slot = period_q[BITS-1:0] & mask[BITS-1:0], turn_slot = decided_q[BITS-1:0] & mask[BITS-1:0];
    wire [31:0] last_focus_word = {27'd0, i_foci_last, 2'b11};
    wire [PATTERN_BITS-1:0] last_word = foci ? last_focus_word[PATTERN_BITS-1:0] : LAST_CHANNEL;
    wire       ends   = i_take && word_q == last_word;
    wire       judges = steps_q[4] && (swept_q || i_forget);
    wire [PERIOD_BITS-1:0] ahead = period_q - decided_q;
    wire       late   = ahead[PERIOD_BITS-1] || ahead == NONE;
    wire       early  = (ahead & ~mask) != NONE;
    wire       begins = i_take && word_q == {PATTERN_BITS{1'b0}};
    wire       fills  = ends && keeps_q && !late && !i_forget;
    assign o_wait     = steps_q != 4'd0;
    assign o_place    = judges;
    assign o_keeps    = keeps_q;
    assign o_split    = word_q != {PATTERN_BITS{1'b0}};
    assign o_late     = (begins && late_q) || (ends && keeps_q && late);
    assign o_early    = begins && early_q;
    assign o_repeated = begins && repeated_q;

    wire [27:0] focus_word;
    wire        no_foci;
    generate
        if (FOCI != 0) begin : with_foci
            focus_place #(.RECORDS(RECORDS), .PRIMARY_WORDS(RECORDS * RECORD_WORDS)) place (
                .clk(clk), .i_index(o_wait ? index_q : last_index[15:0]), .i_base(i_foci_base), .i_count(i_foci_count), .i_last(i_foci_last),
                .o_first(focus_word), .o_refused(no_foci));
        end else begin : without_foci
            assign {focus_word, no_foci} = 29'd0;
            wire unused_foci = &{1'b0, i_foci_base, i_foci_count};
        end
    endgenerate
    assign o_address = foci ? focus_word[WORD_BITS-1:0] : record_q[WORD_BITS-1:0];

    initial steps_q = 4'd0;
    always @(posedge clk) begin
        if (!o_wait) o_usable <= i_slot_bits != 4'd0 && i_slot_bits <= MOST_BITS && i_first != 16'd0 && !last_index[16]
                                 && (foci ? !no_foci : last_index[15:0] <= TOP_RECORD);
        if (i_settle || ends) begin
            period_q <= i_settle ? i_period : period_q + ONE;
            word_q   <= {PATTERN_BITS{1'b0}};
            steps_q  <= 4'd1;
        end else begin
            if (i_take) word_q <= word_q + 1'b1;
            // The slot's bit is looked at in the third step, the pattern judged in the fourth.
            if (judges || i_close) steps_q <= 4'd0;
            else if (!steps_q[4] && !(steps_q[3] && turn_q[0])) steps_q <= {steps_q[3:1], 1'b0};
        end
        if (steps_q[1]) index_q <= i_first + {{(16-BITS){1'b0}}, slot};
        record_q <= {11'd0, index_q - 16'd1} * STRIDE + HEADER;
        if (i_forget) {keeps_q, late_q, early_q, repeated_q} <= 4'd0;
        else if (judges) {keeps_q, late_q, early_q, repeated_q} <= {!late && !early && !full_q, late, !late && early, !late && !early && full_q};
    end

    // ---- The slots' bits

    // The slot that is written is not the slot that is read, except for late and early patterns, which do not depend on their slot's bit.
    (* no_rw_check *) reg waits [0:SLOTS-1];
    integer s;
    initial for (s = 0; s < SLOTS; s = s + 1) waits[s] = 1'b0;
    reg  [BITS:0]   sweep_q;  // slots are emptied one by one, as long as the upper bit is 0
    reg             clears_q;
    wire            sweeps = !sweep_q[BITS];
    initial {sweep_q, swept_q, turn_q, clears_q} = 0;
    always @(posedge clk) begin
        if (sweeps) waits[sweep_q[BITS-1:0]] <= 1'b0;
        else if (fills) waits[slot] <= 1'b1;
        else if (clears_q) waits[turn_slot] <= 1'b0;
        full_q <= waits[turn_q[0] ? turn_slot : slot];
        sweep_q  <= i_forget ? {(BITS+1){1'b0}} : sweeps ? sweep_q + 1'b1 : sweep_q;
        swept_q  <= !sweeps && !i_forget;
        clears_q <= turn_q[0] || (clears_q && fills);
    end

    // ---- The turn of a period

    assign o_jump  = i_go && i_count + ONE != decided_q;
    assign o_turn  = turn_q[1];
    assign o_full  = full_q && swept_q;
    assign o_index = i_first + {{(16-BITS){1'b0}}, turn_slot};
    always @(posedge clk) begin
        if (i_go) decided_q <= i_count + ONE + ONE;
        turn_q <= i_forget ? 2'b00 : {turn_q[0], i_go};
    end

    wire unused = &{1'b0, focus_word, record_q, last_focus_word};

`ifdef FORMAL
    `include "formal/pattern_slots.vh"
`endif
endmodule
`default_nettype wire
