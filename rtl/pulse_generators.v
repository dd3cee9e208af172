// SPDX-License-Identifier: Apache-2.0
//
// One pulse generator a transducer, and the register before its pin: high for i_pulse_length ticks, once a cycle, from the tick
// that equals the channel's timing.
//
// Channels have no counters of their own, which would not fit a small FPGA. A low channel compares its timing with the tick
// count, and rises on a match. A high channel compares its timing with fall_q, the same count delayed by one pulse length, and
// falls on a match. Timings arrive in a chain of shadow registers, fed at the last channel's end. A commit swaps them with the
// compared ones in one clock; a pulse that is under way then finds its end by its old timing in the shadow registers, so it
// completes, and a new pulse that overlaps it merges with it. Until o_settled the shadow registers must not change.
// While i_allow is low the pins are low, from the next clock on, and no pulse starts, so the first one after enabling is whole.
// At a change of focus a new pulse can begin one tick after the old one has ended. A driver cannot follow such a short gap, so it
// is filled, as long as pulses from before the change can have ended just now; gaps between pulses of one record stay. To know the
// tick ahead, all pins are one tick late: a pin follows its tick by one tick and two clocks.
// CHANNELS is the core's. TIMING_BITS (4 to 16) is how late in a cycle a pulse can start, in ticks, and sets most of the cells.
// PULSE_BITS (1 to 8, at most TIMING_BITS) sets the longest pulse: every channel compares so many bits to find its end.
`default_nettype none
module pulse_generators #(
    parameter CHANNELS    = 100,
    parameter TIMING_BITS = 16,
    parameter PULSE_BITS  = 8
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_allow,         // from output_guard
    input  wire                   i_shift,         // while settled; the last timing may come with i_commit
    input  wire [TIMING_BITS-1:0] i_timing,
    input  wire                   i_commit,        // in a cycle's last clock, while o_settled
    input  wire                   i_tick,          // strobe at the start of each tick
    input  wire                   i_cycle_start,   // with the first tick of a cycle
    input  wire                   i_can_match,     // the record has pulses, and i_count is one that a timing can equal
    input  wire [TIMING_BITS-1:0] i_count,
    input  wire [PULSE_BITS-1:0]  i_pulse_length,  // ticks, less than a cycle; changes with commits
    output wire                   o_settled,
    output reg  [CHANNELS-1:0]    o_pins
);
    localparam [PULSE_BITS-1:0] NONE = 0, ONE = 1;
    localparam [TIMING_BITS-1:0] NEVER = {TIMING_BITS{1'b1}};  // the timing of a silent channel

    // What all channels compare with, one clock after the tick. fall_q is the count delayed by one pulse length: NEVER until the
    // first pulse of a record can end; then it keeps counting over the cycle's end. A commit hands its value to old_fall_q, by
    // which the pulses from before that commit end.
    // After the outputs were off, they stay so for a clock more: then no pulse begins in a tick that is not its record's any more.
    reg                   allowed_q;
    wire                  off = rst || !i_allow || !allowed_q;
    initial allowed_q = 1'b0;
    always @(posedge clk) allowed_q <= i_allow && !rst;

    reg                   start_q, commit_q, tick_q, moves_q;
    reg [TIMING_BITS-1:0] count_q, fall_q;
    reg [PULSE_BITS-1:0]  old_fall_q;  // its low bits are enough: those pulses end within 2^PULSE_BITS ticks
    reg [PULSE_BITS-1:0]  old_left_q;  // ticks until the last of them has ended
    reg [PULSE_BITS-1:0]  lead_q;      // ticks until the first pulse of this cycle can end
    reg                   ending_q, fills_q;  // in the last tick, and in the one before it, such a pulse could still be high
    wire [TIMING_BITS-1:0] fall_next = fall_q + 1'b1;
    assign o_settled = old_left_q == NONE || (i_tick && old_left_q == ONE);

    always @(posedge clk) begin
        commit_q <= i_commit && !rst;
        tick_q   <= i_tick;
        moves_q  <= i_tick || i_commit;
        start_q  <= i_tick && i_can_match && !rst;
        if (rst) {ending_q, fills_q} <= 2'b00;
        else if (i_commit) {ending_q, fills_q} <= 2'b11;
        else if (off) {ending_q, fills_q} <= 2'b00;
        else if (tick_q && !commit_q) {ending_q, fills_q} <= {old_left_q != NONE, ending_q};
        if (rst) old_left_q <= NONE;
        else if (i_commit) old_left_q <= i_pulse_length;
        else if (off) old_left_q <= NONE;
        else if (i_tick && old_left_q != NONE) old_left_q <= old_left_q - ONE;
        if (i_tick) begin  // commit_q is high in the first tick of a record
            count_q    <= i_count;
            lead_q     <= i_cycle_start ? i_pulse_length : lead_q == NONE ? NONE : lead_q - ONE;
            old_fall_q <= commit_q ? fall_next[PULSE_BITS-1:0] : old_fall_q + ONE;
            if (commit_q) fall_q <= NEVER;
            else if (lead_q == ONE && !i_cycle_start) fall_q <= {TIMING_BITS{1'b0}};
            else if (fall_q != NEVER) fall_q <= fall_next;
        end
    end

    reg [CHANNELS*TIMING_BITS-1:0] shadow_q;
    reg [CHANNELS*TIMING_BITS-1:0] timings_q;
    // Only the low bits, by which a pulse finds its end, are swapped. The others are not needed any more after a commit.
    localparam [TIMING_BITS-1:0] LOW_BITS = {TIMING_BITS{1'b1}} >> (TIMING_BITS - PULSE_BITS);
    localparam [CHANNELS*TIMING_BITS-1:0] LOW = {CHANNELS{LOW_BITS}};
    always @(posedge clk) begin
        if (commit_q) {timings_q, shadow_q} <= {shadow_q, (shadow_q & ~LOW) | (timings_q & LOW)};
        else if (i_shift) shadow_q <= {i_timing, shadow_q[CHANNELS*TIMING_BITS-1:TIMING_BITS]};
    end

    reg  [CHANNELS-1:0] new_q;  // the channel is in a pulse of the present record
    reg  [CHANNELS-1:0] old_q;  // it is in a pulse from before the last commit, whose timing is in the shadow register
    // (* keep *) stops synthesis from mixing the three comparisons, which would take a fifth more cells. In clocks in which a
    // result is not used it is left at x: that costs nothing in hardware, and a simulator can skip the comparison.
    (* keep *) reg [CHANNELS-1:0] begins, ends, old_ends;
    integer k;
    always @* begin
        {begins, ends, old_ends} = {3*CHANNELS{1'bx}};
        if (start_q) for (k = 0; k < CHANNELS; k = k + 1)
            begins[k] = timings_q[k*TIMING_BITS +: TIMING_BITS] == count_q;
        if (moves_q && new_q != {CHANNELS{1'b0}}) for (k = 0; k < CHANNELS; k = k + 1)
            ends[k] = timings_q[k*TIMING_BITS +: TIMING_BITS] == fall_q;
        if (moves_q && old_q != {CHANNELS{1'b0}}) for (k = 0; k < CHANNELS; k = k + 1)
            old_ends[k] = shadow_q[k*TIMING_BITS +: PULSE_BITS] == old_fall_q;
    end
    wire [CHANNELS-1:0] new_d = (new_q & ~ends) | (~new_q & begins & {CHANNELS{start_q}});
    wire [CHANNELS-1:0] old_d = old_q & ~old_ends;
    // new_q and old_q are the state in the last tick, new_d and old_d in this one.
    initial {o_pins, new_q, old_q} = {3*CHANNELS{1'b0}};
    always @(posedge clk) begin
        if (off || commit_q) new_q <= {CHANNELS{1'b0}};
        else if (moves_q) new_q <= new_d;
        if (off) {o_pins, old_q} <= {2*CHANNELS{1'b0}};
        else if (moves_q) begin
            old_q <= commit_q ? new_d : old_d;
            if (tick_q) o_pins <= new_q | old_q | (o_pins & (new_d | old_d) & {CHANNELS{fills_q}});
        end
    end

`ifdef FORMAL
    `include "formal/pulse_generators.vh"
`endif
endmodule
`default_nettype wire
