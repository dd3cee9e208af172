// SPDX-License-Identifier: Apache-2.0
//
// The counterpart of player for channels that each have an amplitude: from the next (index, dwell) to the pins, in two stages that do not
// wait for each other.
//
// Once a record, the first stage writes the record's words into the drive memory: timings, phases and amplitudes, or the focus engine's
// results. Once a carrier period, period_controller has these made into the generators' words (modulation, slew limit, width), which take
// effect at the period's end. The other ports are those of player. Settings (parameters, geometry, samples) are written one word a strobe;
// a sample must not be written while o_fetching. o_sample_word follows i_read_address by two clocks, o_parameter_word by one.
// i_modulate and the ports of its arguments are the command MODULATE's; i_modulates says when the command takes effect. The parameters are
// the core's and player's. MAX_DUTY_256 must be at least 128, because full amplitude is half of the cycle.
`default_nettype none
`include "interface.vh"
module drive_player #(
    parameter CHANNELS        = 100,
    parameter RECORDS         = 400,
    parameter TIMING_BITS     = 11,
    parameter PULSE_BITS      = 8,
    parameter WIDTH_BITS      = 10,
    parameter MODULATION_DEPTH = 4096,
    parameter SLEW            = 1,
    parameter FOCI            = 8,
    parameter SYNC            = 0,
    parameter IDLE_CLOCKS     = 1250,
    parameter MAX_HIGH_CLOCKS = 10000,
    parameter MIN_PULSE_CLOCKS = 5,
    parameter MAX_PULSE_CLOCKS = 999,
    parameter MAX_DUTY_256    = 128,
    parameter MAX_CYCLE_CLOCKS = 50000000,
    parameter ADDRESS_BITS    = $clog2(RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS))  // follows from the others
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                i_preempt,
    input  wire                i_drop,           // silence that was prepared is not wanted
    input  wire                i_entry,
    output wire                o_take,
    input  wire [15:0]         i_index,
    input  wire [15:0]         i_dwell,
    input  wire [1:0]          i_tag,       // of the entry; o_tag shows it with the first cycle start of it
    output wire                o_reading,
    output wire [ADDRESS_BITS-1:0] o_address,
    input  wire [15:0]         i_word,
    input  wire                i_set_parameter,  // strobes: i_set_word is for i_set_address of this region
    input  wire                i_set_geometry,
    input  wire                i_set_sample,
    input  wire [15:0]         i_set_address,    // of a word
    input  wire [15:0]         i_set_word,
    input  wire [15:0]         i_read_address,
    output wire [15:0]         o_parameter_word,
    output wire [15:0]         o_sample_word,
    output wire                o_fetching,
    output wire [15:0]         o_foci_base,
    output wire [15:0]         o_foci_count,
    output wire [2:0]          o_foci_last,
    input  wire                i_modulate,       // strobe: settings of the modulation
    input  wire [15:0]         i_divider,
    input  wire [15:0]         i_length,
    input  wire [15:0]         i_form,           // bit 0: over and over; the others: half the number of the first sample
    input  wire                i_modulates,      // strobe, not before that: they take effect
    input  wire                i_at_pass_end,    // with it: when the present pass has ended
    input  wire                i_streams,        // pattern_stream's, whose turns follow o_go
    output wire                o_go,
    input  wire                i_fades,          // all amplitudes change by at most i_fade a period
    input  wire [15:0]         i_fade,
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
    output wire                o_guard_trip,
    output wire                o_modulated,
    output wire                o_samples,        // strobe: its first sample is taken
    output wire                o_bent,
    output wire                o_far
);
    localparam CHANNEL_BITS = $clog2(CHANNELS);
    localparam LEAD = CHANNELS + 44;

    generate
        if (TIMING_BITS < 4 || TIMING_BITS > 16) timing_bits_out_of_range error();
        if (PULSE_BITS < 1 || PULSE_BITS > 8) pulse_bits_out_of_range error();
        if (WIDTH_BITS < PULSE_BITS || WIDTH_BITS > TIMING_BITS) width_bits_out_of_range error();
        if (SLEW < 0 || SLEW > 1) slew_out_of_range error();
        if (FOCI != 0 && FOCI != 8) foci_out_of_range error();
        if (MAX_DUTY_256 < 128) max_duty_256_out_of_range error();
    endgenerate

    // ---- Settings

    wire [15:0] foci_cycle, gain, phase_rate, amplitude_rate;
    wire [17:0] wave_number;
    wire [11:0] arrival_periods;
    wire [1:0]  slew;
    wire        foci_whole;

    parameter_registers #(.IDLE_CLOCKS(IDLE_CLOCKS)) settings (
        .clk(clk),
        .i_write(i_set_parameter), .i_write_address(i_set_address[4:0]), .i_write_word(i_set_word),
        .i_read_address(i_read_address[4:0]), .o_word(o_parameter_word),
        .o_foci_base(o_foci_base), .o_foci_count(o_foci_count), .o_foci_last(o_foci_last), .o_foci_whole(foci_whole),
        .o_foci_cycle(foci_cycle), .o_wave_number(wave_number), .o_gain(gain),
        .o_slew(slew), .o_phase_rate(phase_rate), .o_amplitude_rate(amplitude_rate), .o_arrival_periods(arrival_periods));

    // ---- Once a record

    wire                    loaded, silent, amplitudes, take_over, bank;
    wire [15:0]             next_index, next_dwell;
    wire [1:0]              next_tag;
    wire [23:0]             next_cycle_length, next_prescaler;
    wire [PULSE_BITS-1:0]   next_pulse_length;
    wire [WIDTH_BITS-1:0]   next_width = {{(WIDTH_BITS-PULSE_BITS){1'b0}}, next_pulse_length};
    wire [CHANNEL_BITS-1:0] channel;
    wire [31:0]             drive_word;

    drive_loader #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS),
        .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256),
        .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS), .WIDTH_BITS(WIDTH_BITS), .FOCI(FOCI), .LEAST_CYCLE(2 * LEAD),
        .COMMON_CYCLE(SYNC != 0 ? IDLE_CLOCKS : 0)
    ) loader (
        .clk(clk), .rst(rst),
        .i_preempt(i_preempt || i_drop), .i_entry(i_entry), .i_common(i_together), .o_take(o_take), .i_index(i_index), .i_dwell(i_dwell), .i_tag(i_tag),
        .o_reading(o_reading), .o_address(o_address), .i_word(i_word),
        .i_set_geometry(i_set_geometry), .i_set_address(i_set_address[CHANNEL_BITS+1:0]), .i_set_word(i_set_word),
        .i_foci_base(o_foci_base), .i_foci_count(o_foci_count), .i_foci_last(o_foci_last), .i_foci_whole(foci_whole), .i_foci_cycle(foci_cycle),
        .i_wave_number(wave_number), .i_gain(gain),
        .i_take_over(take_over), .o_ready(loaded), .o_silent(silent), .o_amplitudes(amplitudes),
        .o_index(next_index), .o_dwell(next_dwell), .o_tag(next_tag), .o_cycle_length(next_cycle_length), .o_prescaler(next_prescaler),
        .o_pulse_length(next_pulse_length), .o_refused(o_refused), .o_far(o_far),
        .i_swept(bank), .i_channel(channel), .o_word(drive_word));

    // ---- Once a carrier period

    wire       guarded;
    wire       allow = guarded && !i_mute;
    wire [1:0] coming_tag, tag;
    wire bent_words, settled, tick, cycle_start, can_match, follows, asked, commit, refresh, asks, ready, refreshes, still, missed, late;
    wire period, mute, begins, new_target, raw, drop, emission_ready, valid, last, busy, word_valid, word_last, bent;
    wire [TIMING_BITS-1:0]  count;
    wire [15:0]             index, dwell, present;
    wire [23:0]             cycle_length, prescaler;
    wire [WIDTH_BITS-1:0]   longest, playing_longest, raw_width, width, ahead_count;
    wire                    words, centred, near_end;
    wire [TIMING_BITS:0]    cycle_ticks;
    wire [2*TIMING_BITS:0]  word;
    wire [7:0]              sample;

    period_controller #(
        .CHANNELS(CHANNELS), .TIMING_BITS(TIMING_BITS), .WIDTH_BITS(WIDTH_BITS), .LEAD(LEAD), .IDLE_CLOCKS(IDLE_CLOCKS)
    ) periods (
        .clk(clk), .rst(rst), .i_allow(guarded || i_together), .i_preempt(i_preempt), .i_streams(i_streams),
        .i_tick(tick), .i_cycle_start(cycle_start), .i_settled(settled), .i_follows(follows), .i_asked(asked),
        .i_commit(commit), .i_refresh(refresh), .o_preempt(asks), .o_ready(ready), .o_refresh(refreshes), .o_words(words), .o_centred(centred),
        .o_index(index), .o_dwell(dwell), .o_tag(coming_tag), .o_silent(still), .o_cycle_length(cycle_length), .o_prescaler(prescaler), .o_longest(longest),
        .i_next(loaded), .i_next_silent(silent), .i_next_amplitudes(amplitudes),
        .i_next_index(next_index), .i_next_dwell(next_dwell), .i_next_tag(next_tag), .i_next_cycle_length(next_cycle_length),
        .i_next_prescaler(next_prescaler), .i_next_pulse_length(next_width), .o_take_over(take_over),
        .o_bank(bank), .o_channel(channel), .o_mute(mute), .o_begin(begins), .o_new_target(new_target), .o_raw(raw),
        .o_raw_width(raw_width), .o_cycle(cycle_ticks), .o_drop(drop), .i_ready(emission_ready), .o_valid(valid), .o_last(last),
        .i_word(word_valid), .i_word_last(word_last), .i_width(width), .i_bent(bent),
        .o_period(period), .o_go(o_go), .o_busy(busy), .o_bent(bent_words), .o_missed(missed));

    modulator #(.DEPTH(MODULATION_DEPTH)) samples (
        .clk(clk), .rst(rst),
        .i_write(i_set_sample), .i_write_address(i_set_address), .i_write_word(i_set_word),
        .i_read_address(i_read_address), .o_word(o_sample_word), .o_fetching(o_fetching),
        .i_modulate(i_modulate), .i_divider(i_divider), .i_length(i_length), .i_form(i_form), .i_modulates(i_modulates), .i_at_pass_end(i_at_pass_end),
        .i_period(period), .o_running(o_modulated), .o_first(o_samples), .o_sample(sample));

    // The slew limiter's settings, as they were when the period's words were begun.
    reg [1:0]  slew_q;
    reg [15:0] phase_rate_q, amplitude_rate_q;
    reg [11:0] arrival_periods_q;
    always @(posedge clk) if (!busy)
        {slew_q, phase_rate_q, amplitude_rate_q, arrival_periods_q}
            <= i_fades ? {2'd1, 16'hffff, i_fade, arrival_periods} : {slew, phase_rate, amplitude_rate, arrival_periods};

    emission #(
        .CHANNELS(CHANNELS), .TIMING_BITS(TIMING_BITS), .WIDTH_BITS(WIDTH_BITS), .LEAST_WIDTH(MIN_PULSE_CLOCKS), .SLEW(SLEW)
    ) emit (
        .clk(clk), .rst(rst || drop), .i_begin(begins), .i_modulation(sample), .i_off(!allow), .i_cycle(cycle_ticks), .i_raw(raw),
        .i_raw_width(raw_width), .i_slew(slew_q), .i_phase_rate(phase_rate_q), .i_amplitude_rate(amplitude_rate_q),
        .i_arrival_periods(arrival_periods_q), .i_new_target(new_target), .o_ready(emission_ready),
        .i_valid(valid), .i_last(last), .i_amplitude(mute ? 16'd0 : drive_word[31:16]), .i_phase(drive_word[15:0]),
        .o_valid(word_valid), .o_last(word_last), .o_word(word), .o_width(width), .o_bent(bent));

    // ---- Every clock

    cycle_controller #(
        .PULSE_BITS(WIDTH_BITS), .TIMING_BITS(TIMING_BITS), .IDLE_CLOCKS(IDLE_CLOCKS)
    ) cycle (
        .clk(clk), .rst(rst),
        .i_allow(guarded || i_together), .i_preempt(asks), .i_hold(i_hold), .o_last(o_last), .i_settled(settled),
        .i_ready(ready), .i_index(index), .i_dwell(dwell), .i_tag(coming_tag), .i_silent(still),
        .i_cycle_length(cycle_length), .i_prescaler(prescaler), .i_pulse_length(longest),
        .i_refresh(refreshes), .o_refresh(refresh), .o_follows(follows), .o_asked(asked),
        .o_near(near_end), .o_ahead_count(ahead_count),
        .o_commit(commit), .o_tick(tick), .o_count(count), .o_can_match(can_match), .o_pulse_length(playing_longest),
        .o_index(present), .o_tag(tag), .o_cycle_start(cycle_start), .o_underrun(late));
    assign o_underrun = late || missed;
    assign o_bent = bent_words && allow;

    width_pulse_generators #(
        .CHANNELS(CHANNELS), .TIMING_BITS(TIMING_BITS), .WIDTH_BITS(WIDTH_BITS)
    ) generators (
        .clk(clk), .rst(rst), .i_allow(allow),
        .i_shift(word_valid), .i_word(word), .i_commit(commit || refresh),
        .i_tick(tick), .i_cycle_start(cycle_start), .i_can_match(can_match), .i_count(count), .i_near(near_end), .i_words(words), .i_ahead_count(ahead_count),
        .i_centred(centred), .i_longest(playing_longest),
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

endmodule
`default_nettype wire
