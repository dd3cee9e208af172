// SPDX-License-Identifier: Apache-2.0
//
// Plays a pattern for each carrier period: where STREAM writes its patterns, and which record each period plays.
//
// pattern_slots keeps the patterns; this module plays them. i_go strobes at each period's go point, when the record of the next period has been
// taken over. A record that was loaded and not taken over by then is dropped (o_drop). Two clocks later the record of the period after that is
// offered. So each record plays in its own period or not at all. For a period without a pattern nothing is offered, and the last record plays
// on. After i_hold such periods the stream ends: o_streams falls, and the last record fades (o_fades, for the slew limiter).
// o_begins: the turn of the first pattern has come, so whatever else plays must end. o_entry/i_take_entry is valid/ready.
// i_forget ends the stream and empties all slots: something else is to play, outputs are off, or another session has begun.
// The settings are written one word a strobe; o_word follows i_read_address by one clock. The parameters are those of pattern_slots.
`default_nettype none
`include "interface.vh"
module pattern_stream #(
    parameter SLOTS     = 256,
    parameter CHANNELS  = 100,
    parameter RECORDS   = 400,
    parameter FOCI      = 8,
    parameter WORD_BITS = 16
) (
    input  wire        clk,
    input  wire        i_forget,
    input  wire        i_set,         // strobe
    input  wire [4:0]  i_set_address,
    input  wire [15:0] i_set_word,
    input  wire [4:0]  i_read_address,
    output reg  [15:0] o_word,
    input  wire [15:0] i_foci_base,   // from parameter_registers
    input  wire [15:0] i_foci_count,
    input  wire [2:0]  i_foci_last,
    // From and to command_unit
    output wire        o_usable,
    input  wire        i_settle,      // strobe
    input  wire [47:0] i_period,
    input  wire        i_take,        // strobe
    input  wire        i_close,       // strobe
    output wire        o_wait,
    output wire        o_place,       // strobe
    output wire [WORD_BITS-1:0] o_address,
    output wire        o_keeps,
    output wire        o_split,
    output wire        o_late,        // strobes
    output wire        o_early,
    output wire        o_repeated,
    output wire        o_lost,
    // What plays
    input  wire        i_go,          // strobe
    input  wire [47:0] i_count,
    output wire        o_begins,      // strobe
    output reg         o_streams,
    output reg         o_drop,        // strobe
    output reg         o_entry,
    output reg  [15:0] o_index,
    input  wire        i_take_entry,
    output reg         o_fades,
    output reg  [15:0] o_fade         // per period
);
    reg  [15:0] first_q, hold_q, missed_q;
    reg  [3:0]  slot_bits_q;
    wire        fits, jump, decided, full;
    wire        forget = i_forget || i_set || jump;
    wire        turn = decided && !i_forget && !i_set;  // a jump, which takes long to find, comes with no turn
    wire [15:0] index;
    assign o_usable = fits && o_fade != 16'd0;

    initial slot_bits_q = 4'd0;
    always @(posedge clk) begin
        if (i_set) case (i_set_address)
            `HG_STREAM_FIRST:     first_q     <= i_set_word;
            `HG_STREAM_SLOT_FORM: slot_bits_q <= i_set_word[3:0];
            `HG_STREAM_HOLD:      hold_q      <= i_set_word;
            default:              o_fade      <= i_set_word;
        endcase
        case (i_read_address)
            `HG_STREAM_FIRST:     o_word <= first_q;
            `HG_STREAM_SLOT_FORM: o_word <= {12'd0, slot_bits_q};
            `HG_STREAM_HOLD:      o_word <= hold_q;
            default:              o_word <= o_fade;
        endcase
    end

    pattern_slots #(
        .SLOTS(SLOTS), .CHANNELS(CHANNELS), .RECORDS(RECORDS), .FOCI(FOCI), .WORD_BITS(WORD_BITS)
    ) slots (
        .clk(clk), .i_forget(forget), .i_first(first_q), .i_slot_bits(slot_bits_q),
        .i_foci_base(i_foci_base), .i_foci_count(i_foci_count), .i_foci_last(i_foci_last), .o_usable(fits),
        .i_settle(i_settle), .i_period(i_period), .i_take(i_take), .i_close(i_close), .o_wait(o_wait), .o_place(o_place), .o_address(o_address),
        .o_keeps(o_keeps), .o_split(o_split), .o_late(o_late), .o_early(o_early), .o_repeated(o_repeated),
        .i_go(i_go), .i_count(i_count), .o_jump(jump), .o_turn(decided), .o_full(full), .o_index(index));

    wire ends = turn && !full && o_streams && missed_q == hold_q;
    assign o_begins = turn && full && !o_streams;
    assign o_lost   = turn && !full && o_streams;
    initial {o_streams, o_entry, o_drop, o_fades} = 4'd0;
    always @(posedge clk) begin
        o_drop <= o_streams && (i_go || forget);
        if (forget) {o_streams, o_fades} <= 2'b00;
        else if (o_begins) {o_streams, o_fades} <= 2'b10;
        else if (ends) {o_streams, o_fades} <= 2'b01;
        if (forget || i_go || i_take_entry) o_entry <= 1'b0;
        else if (turn && full) o_entry <= 1'b1;
        if (turn && full) o_index <= index;
        if (turn) missed_q <= full ? 16'd0 : missed_q + 16'd1;
    end

`ifdef FORMAL
    always @(posedge clk) if (decided) begin
        assert (!i_go);
    end
`endif
endmodule
`default_nettype wire
