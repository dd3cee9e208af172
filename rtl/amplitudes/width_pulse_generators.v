// SPDX-License-Identifier: Apache-2.0
//
// One pulse generator a transducer whose pulses have a width of their own, and the register before its pin.
//
// A channel's word is {early, fall, rise}: the ticks of the cycle at which its pulse starts and ends, modulo the cycle, so a
// pulse may run into the next cycle. All ones as rise: no pulse. early: the pulse's middle is in this cycle, but its start in
// the one before. Words arrive in a chain of shadow registers, fed at the last channel's end, and a commit puts them to use. A
// pulse under way then finds its end in the shadow register, where the old fall is; so it completes, and overlapping ones merge.
// Words must not be shifted before o_settled.
// An early pulse starts while its word waits for its commit: in a tick with i_near and i_words, whose number in the coming cycle is
// i_ahead_count. So both halves of a pulse are of one word. What has not started by the end of a cycle does so in the next one's
// first tick; that is all that is left of an early pulse in a cycle without a commit.
// A pin is also high in a single tick between two pulses. To see that gap, pins wait for a tick: a pin follows its tick by one tick
// and two clocks. While i_allow is low, pins are low from the next clock on, and nothing waits to be settled; the first pulse
// afterwards is whole, unless it is early.
// Of a word: rise and fall differ, fall − rise modulo the cycle is at most i_longest, and 0 < fall < rise if early. In a cycle of
// more than 2^TIMING_BITS ticks fall is cut to its low bits, and no pulse may run into the next cycle.
// CHANNELS is the core's. TIMING_BITS (3 to 16) is how late in a cycle a pulse can start, and sets most of the cells.
// WIDTH_BITS (1 to TIMING_BITS) sets the longest pulse, 2^WIDTH_BITS − 1 ticks.
`default_nettype none
module width_pulse_generators #(
    parameter CHANNELS    = 100,
    parameter TIMING_BITS = 11,
    parameter WIDTH_BITS  = 10
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_allow,      // from output_guard
    input  wire                   i_shift,      // while settled; the last word may come with i_commit
    input  wire [2*TIMING_BITS:0] i_word,
    input  wire                   i_commit,     // in a cycle's last clock, while o_settled; a tick follows in the next clock
    input  wire                   i_tick,       // strobe at the start of each tick
    input  wire                   i_cycle_start,  // with a cycle's first tick
    input  wire                   i_can_match,  // the record has pulses, and i_count is one at which a pulse can start
    input  wire [TIMING_BITS-1:0] i_count,      // low bits of the tick's number
    input  wire                   i_near,       // at a tick: one of the cycle's last ones, in which all early pulses start
    input  wire                   i_words,      // all words wait, and the cycle's end commits them
    input  wire [WIDTH_BITS-1:0]  i_ahead_count,  // low bits of the tick's number, were it one of the cycle to come
    input  wire                   i_centred,    // a pulse of the present record, unless early, ends at most half of i_longest beyond its cycle
    input  wire [WIDTH_BITS-1:0]  i_longest,    // of the record's pulses, ticks, less than a cycle; 0: silence; changes with commits
    output wire                   o_settled,    // every pulse from before the last commit has ended
    output reg  [CHANNELS-1:0]    o_pins
);
    localparam [WIDTH_BITS-1:0] NONE = 0, ONE = 1;

    generate
        if (CHANNELS < 1) channels_out_of_range error();
        if (TIMING_BITS < 3 || TIMING_BITS > 16) timing_bits_out_of_range error();
        if (WIDTH_BITS < 1 || WIDTH_BITS > TIMING_BITS) width_bits_out_of_range error();
    endgenerate

    // What all channels compare with, one clock after the tick.
    reg                   tick_q, start_q, commit_q, first_q, ahead_q;
    wire ahead = i_near && i_words;
    reg [TIMING_BITS-1:0] count_q;
    reg [WIDTH_BITS-1:0]  old_count_q;  // ticks since the last commit, by which the pulses from before it end; ahead: i_ahead_count
    reg [WIDTH_BITS-1:0]  old_left_q;   // ticks until the last of them has ended, and its end has been seen
    wire moves = tick_q || commit_q;
    assign o_settled = old_left_q == NONE || (i_tick && old_left_q == ONE);

    always @(posedge clk) begin
        commit_q <= i_commit && !rst;
        tick_q   <= i_tick && !rst;
        start_q  <= i_tick && i_can_match && !rst;
        first_q  <= i_cycle_start && i_can_match && !rst;  // in a cycle's first tick
        if (rst) ahead_q <= 1'b0;
        else if (i_tick) ahead_q <= ahead;
        if (rst) old_left_q <= NONE;
        else if (i_commit) old_left_q <= i_centred ? (i_longest >> 1) + ONE : i_longest;
        else if (!i_allow) old_left_q <= NONE;
        else if (i_tick && old_left_q != NONE) old_left_q <= old_left_q - ONE;
        if (i_tick) begin
            count_q     <= i_count;
            old_count_q <= commit_q ? NONE : ahead ? i_ahead_count : old_count_q + ONE;
        end
    end

    // What waits is shifted through all channels, and a commit copies it. Of the old words a commit keeps the low bits of fall, which
    // is all that a pulse from before needs to find its end, in place of the rises. All channels are one vector, which a simulator
    // passes by in the clocks that leave it alone.
    reg  [CHANNELS*TIMING_BITS-1:0] rises_q, falls_q, next_rises_q, next_falls_q;
    reg  [CHANNELS-1:0]             early_q, coming_q;
    localparam [TIMING_BITS-1:0] LOW_BITS = {TIMING_BITS{1'b1}} >> (TIMING_BITS - WIDTH_BITS);
    localparam [CHANNELS*TIMING_BITS-1:0] LOW = {CHANNELS{LOW_BITS}};
    always @(posedge clk) begin
        if (commit_q) begin
            rises_q      <= next_rises_q;
            next_rises_q <= (next_rises_q & ~LOW) | (falls_q & LOW);
            falls_q      <= next_falls_q;
            early_q      <= coming_q;
        end else if (i_shift) begin
            next_rises_q <= next_rises_q >> TIMING_BITS;
            next_falls_q <= next_falls_q >> TIMING_BITS;
            coming_q     <= coming_q >> 1;
            {coming_q[CHANNELS-1], next_falls_q[CHANNELS*TIMING_BITS-1 -: TIMING_BITS], next_rises_q[CHANNELS*TIMING_BITS-1 -: TIMING_BITS]} <= i_word;
        end
    end

    reg [CHANNELS-1:0] new_q;  // the channel is in a pulse of the present record
    reg [CHANNELS-1:0] old_q;  // it is in a pulse from before the last commit, whose fall is in the shadow register; ahead: of the coming record
    // A comparison is made of pairs of bits, one lookup table each. (* keep *) keeps synthesis from joining them to wider ones and
    // from mixing the three comparisons, which would take a third more cells. In clocks in which a result is not used it is left
    // at x: that costs nothing in hardware, and a simulator can skip the comparison.
    localparam PAIRS = (TIMING_BITS + 1) / 2, OLD_PAIRS = (WIDTH_BITS + 1) / 2;
    (* keep *) reg [CHANNELS*PAIRS-1:0]     off_rise, off_fall;
    (* keep *) reg [CHANNELS*OLD_PAIRS-1:0] off_old_fall;
    reg [CHANNELS-1:0] begins, ends, old_hits;
    integer k;
    always @* begin
        {off_rise, off_fall, off_old_fall} = {CHANNELS*(2*PAIRS+OLD_PAIRS){1'bx}};
        {begins, ends, old_hits} = {3*CHANNELS{1'bx}};
        if (start_q) for (k = 0; k < CHANNELS; k = k + 1) begin
            off_rise[k*PAIRS +: PAIRS] = differ(rises_q[k*TIMING_BITS +: TIMING_BITS], count_q);
            begins[k] = off_rise[k*PAIRS +: PAIRS] == {PAIRS{1'b0}};
        end
        if (moves && new_q != {CHANNELS{1'b0}}) for (k = 0; k < CHANNELS; k = k + 1) begin
            off_fall[k*PAIRS +: PAIRS] = differ(falls_q[k*TIMING_BITS +: TIMING_BITS], count_q);
            ends[k] = off_fall[k*PAIRS +: PAIRS] == {PAIRS{1'b0}};
        end
        if (moves && (ahead_q || old_q != {CHANNELS{1'b0}})) for (k = 0; k < CHANNELS; k = k + 1) begin
            off_old_fall[k*OLD_PAIRS +: OLD_PAIRS] = differ_old(next_rises_q[k*TIMING_BITS +: WIDTH_BITS], old_count_q);
            old_hits[k] = off_old_fall[k*OLD_PAIRS +: OLD_PAIRS] == {OLD_PAIRS{1'b0}};
        end
    end
    // Which pairs of bits differ.
    function [PAIRS-1:0] differ(input [TIMING_BITS-1:0] a, input [TIMING_BITS-1:0] b);
        integer p;
        for (p = 0; p < PAIRS; p = p + 1)
            differ[p] = a[2*p] != b[2*p] || (2*p + 1 < TIMING_BITS && a[(2*p + 1) % TIMING_BITS] != b[(2*p + 1) % TIMING_BITS]);
    endfunction
    function [OLD_PAIRS-1:0] differ_old(input [WIDTH_BITS-1:0] a, input [WIDTH_BITS-1:0] b);
        integer p;
        for (p = 0; p < OLD_PAIRS; p = p + 1)
            differ_old[p] = a[2*p] != b[2*p] || (2*p + 1 < WIDTH_BITS && a[(2*p + 1) % WIDTH_BITS] != b[(2*p + 1) % WIDTH_BITS]);
    endfunction

    wire [CHANNELS-1:0] starts = (begins & {CHANNELS{start_q}} & ~early_q) | (early_q & {CHANNELS{first_q}});
    wire [CHANNELS-1:0] new_d  = (new_q & ~ends) | (~new_q & starts);
    wire [CHANNELS-1:0] old_d  = ahead_q ? old_q | (old_hits & coming_q & {CHANNELS{tick_q}}) : old_q & ~old_hits;
    wire [CHANNELS-1:0] now    = new_q | old_q;
    wire off = rst || !i_allow;
    initial {o_pins, new_q, old_q} = {3*CHANNELS{1'b0}};
    always @(posedge clk) begin
        if (off) new_q <= {CHANNELS{1'b0}};
        else if (moves) new_q <= commit_q ? old_d : new_d;
        if (off) old_q <= {CHANNELS{1'b0}};
        else if (moves) old_q <= commit_q ? new_d : old_d;
        if (off) o_pins <= {CHANNELS{1'b0}};
        else if (tick_q) o_pins <= now | (o_pins & (new_d | old_d));
    end

`ifdef FORMAL
    `include "formal/width_pulse_generators.vh"
`endif
endmodule
`default_nettype wire
