// SPDX-License-Identifier: Apache-2.0
//
// From the next (index, dwell) to the pins: memory controller, cycle controller, pulse generators and output guard.
//
// It is a module of its own because everything that contracts 1, 2 and 4 promise happens in here. Its only inputs are entries,
// a memory to read, and the guard's three strobes, so it can be built, proved and measured by itself. i_entry/o_take is a
// valid/ready stream. A pin rises one tick and two clocks after the tick that its timing names; o_index and o_cycle_start are
// delayed alike.
// CHANNELS, RECORDS, TIMING_BITS, PULSE_BITS, MAX_HIGH_CLOCKS, MIN_PULSE_CLOCKS and MAX_DUTY_256 are the core's. PULSE_BITS must not
// exceed TIMING_BITS, because the end of a pulse is found by comparing the lowest PULSE_BITS of its timing. IDLE_CLOCKS is the
// cycle before the first record. MAX_PULSE_CLOCKS, MAX_CYCLE_CLOCKS and PRESCALER_BITS bound what a record may ask for, see
// memory_controller.
`default_nettype none
`include "interface.vh"
module player #(
    parameter CHANNELS        = 100,
    parameter RECORDS         = 400,
    parameter TIMING_BITS     = 16,
    parameter PULSE_BITS      = 8,
    parameter IDLE_CLOCKS     = 1250,
    parameter MAX_HIGH_CLOCKS = 10000,
    parameter MIN_PULSE_CLOCKS = 5,
    parameter MAX_PULSE_CLOCKS = 999,
    parameter MAX_DUTY_256    = 128,
    parameter MAX_CYCLE_CLOCKS = 50000000,
    parameter PRESCALER_BITS  = 24,
    parameter SYNC            = 0,
    parameter ADDRESS_BITS    = $clog2(RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS))  // follows from the others
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                i_preempt,
    input  wire                i_drop,      // as i_preempt, but no change is asked for
    input  wire                i_entry,
    output wire                o_take,
    input  wire [15:0]         i_index,
    input  wire [15:0]         i_dwell,
    input  wire [1:0]          i_tag,       // of the entry; o_tag shows it with the first cycle start of it
    output wire                o_reading,
    output wire [ADDRESS_BITS-1:0] o_address,
    input  wire [15:0]         i_word,
    input  wire                i_enable,
    input  wire                i_disable,
    input  wire                i_mute,           // no pulse may reach the pins, but time goes on as if they did
    input  wire                i_together,       // with other boards: cycles have IDLE_CLOCKS clocks, and changes wait for their end
    input  wire                i_hold,           // cycle_controller's
    output wire                o_last,
    output wire [CHANNELS-1:0] o_pins,
    output wire                o_enabled,
    output wire                o_alive,
    output wire [15:0]         o_index,
    output wire                o_cycle_start,
    output wire [1:0]          o_tag,
    output wire                o_refused,
    output wire                o_underrun,
    output wire                o_guard_trip
);
    generate
        if (TIMING_BITS < 4 || TIMING_BITS > 16) timing_bits_out_of_range error();
        if (PULSE_BITS < 1 || PULSE_BITS > 8 || PULSE_BITS > TIMING_BITS) pulse_bits_out_of_range error();
    endgenerate

    wire                   shift, ready, silent, commit, tick, can_match, cycle_start, settled;
    wire [TIMING_BITS-1:0] timing, count;
    wire [15:0]            index, dwell, present;
    wire [1:0]             coming_tag, tag;
    wire                   guarded;
    wire                   allow = guarded && !i_mute;
    wire [23:0]            cycle_length, prescaler;
    wire [PULSE_BITS-1:0]  next_pulse_length, pulse_length;
    wire                   amplitudes, foci, refresh, follows, asked, near;  // of drive_player alone
    wire [PULSE_BITS-1:0]  ahead_count;
    wire                   unused = &{1'b0, amplitudes, foci, refresh, follows, asked, near, ahead_count};

    memory_controller #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS),
        .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256),
        .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS), .PRESCALER_BITS(PRESCALER_BITS), .COMMON_CYCLE(SYNC != 0 ? IDLE_CLOCKS : 0)
    ) memory (
        .clk(clk), .rst(rst),
        .i_preempt(i_preempt || i_drop), .i_entry(i_entry), .i_settled(settled), .i_common(i_together), .o_take(o_take), .i_index(i_index), .i_dwell(i_dwell), .i_tag(i_tag),
        .o_reading(o_reading), .o_address(o_address), .i_word(i_word),
        .i_foci_base(16'd0), .i_foci_count(16'd0), .i_foci_last(3'd0), .i_foci_cycle(16'd0), .o_amplitudes(amplitudes), .o_foci(foci),
        .o_shift(shift), .o_timing(timing),
        .i_commit(commit), .o_ready(ready), .o_silent(silent), .o_index(index), .o_dwell(dwell), .o_tag(coming_tag),
        .o_cycle_length(cycle_length), .o_prescaler(prescaler), .o_pulse_length(next_pulse_length), .o_refused(o_refused));

    cycle_controller #(
        .PULSE_BITS(PULSE_BITS), .TIMING_BITS(TIMING_BITS), .IDLE_CLOCKS(IDLE_CLOCKS)
    ) cycle (
        .clk(clk), .rst(rst),
        .i_allow(guarded || i_together), .i_preempt(i_preempt), .i_hold(i_hold), .o_last(o_last), .i_settled(settled),
        .i_ready(ready), .i_index(index), .i_dwell(dwell), .i_tag(coming_tag), .i_silent(silent),
        .i_cycle_length(cycle_length), .i_prescaler(prescaler), .i_pulse_length(next_pulse_length),
        .i_refresh(1'b0), .o_refresh(refresh), .o_follows(follows), .o_asked(asked),
        .o_near(near), .o_ahead_count(ahead_count),
        .o_commit(commit), .o_tick(tick), .o_count(count), .o_can_match(can_match), .o_pulse_length(pulse_length),
        .o_index(present), .o_tag(tag), .o_cycle_start(cycle_start), .o_underrun(o_underrun));

    pulse_generators #(
        .CHANNELS(CHANNELS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS)
    ) generators (
        .clk(clk), .rst(rst), .i_allow(allow),
        .i_shift(shift), .i_timing(timing), .i_commit(commit),
        .i_tick(tick), .i_cycle_start(cycle_start), .i_can_match(can_match), .i_count(count), .i_pulse_length(pulse_length),
        .o_settled(settled), .o_pins(o_pins));

    output_guard #(
        .CHANNELS(CHANNELS), .MAX_HIGH_CLOCKS(MAX_HIGH_CLOCKS)
    ) guard (
        .clk(clk), .rst(rst),
        .i_enable(i_enable), .i_disable(i_disable), .i_pins(o_pins),
        .o_allow(guarded), .o_enabled(o_enabled), .o_trip(o_guard_trip), .o_alive(o_alive));

    beside_pins beside (
        .clk(clk), .rst(rst), .i_tick(tick), .i_cycle_start(cycle_start), .i_index(present), .i_tag(tag),
        .o_cycle_start(o_cycle_start), .o_tag(o_tag), .o_index(o_index));

`ifdef FORMAL
    `include "formal/player.vh"
`endif
endmodule
`default_nettype wire
