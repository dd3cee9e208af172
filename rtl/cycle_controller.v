// SPDX-License-Identifier: Apache-2.0
//
// Counts the ticks of the carrier cycle, and decides at each cycle's last clock whether the present record goes on or the next
// one is committed. It has a 24-bit counter and a 24-bit prescaler, as in Haptogram III-C.
//
// A cycle is i_cycle_length ticks of i_prescaler clocks. o_tick is high in the first clock of each tick. o_commit is high in
// the last clock of a cycle; the next clock is tick 0 of the new record, so a change of focus takes no time.
// A record plays for i_dwell cycles; 0 repeats it until the next one is ready. i_preempt asks for a change at the end of this
// cycle, whatever is left of the dwell. o_underrun strobes once for each change that is due but cannot happen: because the next
// record is not ready, or because a pulse from before the last change still runs, which takes a cycle shorter than that pulse.
// While i_allow is low there are no pulses to complete, so a change that i_preempt asked for does not wait for the cycle's end.
// Where words are made anew in each cycle, i_refresh says that those of the present record are there; o_refresh then puts them to use at
// the cycle's end, as o_commit does the next record's, with their i_pulse_length. Never both at once.
// While i_hold is high a cycle does not end: its last clock, o_last, is repeated, with no tick. So carrier_sync keeps boards in step.
// PULSE_BITS and TIMING_BITS are the core's. IDLE_CLOCKS is the length of the cycle before the first record, in clocks.
`default_nettype none
module cycle_controller #(
    parameter PULSE_BITS   = 8,
    parameter TIMING_BITS  = 16,
    parameter IDLE_CLOCKS  = 1250
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_allow,    // from output_guard: pulses may reach the pins
    input  wire                   i_preempt,  // strobe
    input  wire                   i_hold,
    output wire                   o_last,
    input  wire                   i_settled,  // every pulse from before the last commit has ended
    input  wire                   i_ready,    // the next record: its fields below, and its timings in the shadow registers
    input  wire [15:0]            i_index,
    input  wire [15:0]            i_dwell,
    input  wire [1:0]             i_tag,      // of its first cycle
    input  wire                   i_silent,   // it has no pulses, and keeps the present cycle length and prescaler
    input  wire [23:0]            i_cycle_length,
    input  wire [23:0]            i_prescaler,
    input  wire [PULSE_BITS-1:0]  i_pulse_length,
    input  wire                   i_refresh,  // not with i_ready
    output wire                   o_follows,  // the next record is wanted at the end of this cycle
    output wire                   o_asked,    // a preempt asked for it
    output wire                   o_commit,
    output wire                   o_refresh,
    output reg                    o_tick,
    output wire [TIMING_BITS-1:0] o_count,
    output wire                   o_can_match,
    output wire                   o_near,       // at a tick: this is the cycle's last quarter, clock by clock, and no longer than PULSE_BITS count
    output wire [PULSE_BITS-1:0]  o_ahead_count,  // low bits of this tick's number, were it one of the next record's cycle
    output reg  [PULSE_BITS-1:0]  o_pulse_length,
    output reg  [15:0]            o_index,
    output reg  [1:0]             o_tag,      // of this cycle
    output reg                    o_cycle_start,
    output wire                   o_underrun  // strobe
);
    localparam [23:0] IDLE_CYCLE = IDLE_CLOCKS[23:0];
    localparam [PULSE_BITS-1:0] ONE = 1;

    reg [23:0] last_count_q;  // the cycle length less one
    reg [23:0] quarter_q;     // of the cycle length
    reg [23:0] last_phase_q;  // the prescaler less one
    reg [23:0] count_q;
    reg [23:0] phase_q;      // clocks into the present tick
    reg [15:0] dwell_q;      // cycles left to play; 0 repeats
    reg        preempt_q;
    reg        late_q;       // the underrun that is under way has been counted

    wire due       = dwell_q == 16'd1;
    wire ready     = i_ready && i_settled;
    wire at_once   = !i_allow && preempt_q && ready;
    wire held      = o_last && i_hold && !at_once;
    wire tick_ends = (phase_q == last_phase_q && !held) || at_once;
    wire boundary  = (o_last && !held) || at_once;
    assign o_last  = phase_q == last_phase_q && count_q == last_count_q;

    assign o_commit      = boundary && ready && (due || dwell_q == 16'd0 || preempt_q);
    wire   refresh       = boundary && i_refresh && i_settled;
    assign o_refresh     = refresh;
    assign o_follows     = due || dwell_q == 16'd0 || preempt_q;
    assign o_asked       = preempt_q;
    assign o_underrun    = boundary && due && !ready && !preempt_q && !late_q;
    assign o_count       = count_q[TIMING_BITS-1:0];
    // A count of all ones matches no channel, whatever the cycle length, so a timing of all ones silences its channel.
    assign o_can_match   = o_pulse_length != {PULSE_BITS{1'b0}} && count_q < {{(24-TIMING_BITS){1'b0}}, {TIMING_BITS{1'b1}}};

    // How many ticks are behind this one.
    wire [23:0] left = last_count_q - count_q;
    assign o_near        = left < quarter_q && left >> (PULSE_BITS - 1) == 24'd0 && last_phase_q == 24'd0;
    assign o_ahead_count = i_cycle_length[PULSE_BITS-1:0] - ONE - left[PULSE_BITS-1:0];

    always @(posedge clk) begin
        if (rst) begin
            count_q <= 24'd0;
            phase_q <= 24'd0;
        end else if (tick_ends) begin
            phase_q <= 24'd0;
            count_q <= boundary ? 24'd0 : count_q + 1'b1;
        end else if (!held) phase_q <= phase_q + 1'b1;
        {o_tick, o_cycle_start} <= {rst || tick_ends, rst || boundary};
    end

    always @(posedge clk) begin
        if (rst) begin
            last_count_q   <= IDLE_CYCLE - 1'b1;
            quarter_q      <= IDLE_CYCLE >> 2;
            last_phase_q   <= 24'd0;
            o_pulse_length <= {PULSE_BITS{1'b0}};
            o_index        <= 16'd0;
            dwell_q        <= 16'd0;
            o_tag          <= 2'b00;
        end else if (o_commit) begin
            if (!i_silent) begin
                last_count_q <= i_cycle_length - 1'b1;
                quarter_q    <= i_cycle_length >> 2;
                last_phase_q <= i_prescaler - 1'b1;
            end
            o_pulse_length <= i_silent ? {PULSE_BITS{1'b0}} : i_pulse_length;
            o_index        <= i_index;
            dwell_q        <= i_dwell;
            o_tag          <= i_tag;
        end else begin
            if (boundary) o_tag <= 2'b00;
            if (refresh) o_pulse_length <= i_pulse_length;
            if (boundary && dwell_q > 16'd1) dwell_q <= dwell_q - 1'b1;
        end
    end

    always @(posedge clk) begin
        if (rst) {preempt_q, late_q} <= 2'b00;
        else begin
            if (i_preempt) preempt_q <= 1'b1;
            else if (o_commit) preempt_q <= 1'b0;
            if (o_commit) late_q <= 1'b0;
            else if (o_underrun) late_q <= 1'b1;
        end
    end

`ifdef FORMAL
    `include "formal/cycle_controller.vh"
`endif
endmodule
`default_nettype wire
