// SPDX-License-Identifier: Apache-2.0
//
// Decides, once a carrier period, what the next period plays, and has the pulse generators' words for it made out of the drive memory.
//
// A record of amplitudes gets new words in each period, because modulation and slew limit may change them. The words are begun at the go point:
// a quarter of a period and LEAD clocks before the period ends, so that they are there when the first pulse starts whose middle is in the next
// period. At the go point the next record, if it is wanted, is taken over; otherwise the present record gets new words.
// A record of timings, or silence, that follows one of its kind is taken over as soon as it is wanted, and its words are made once. A preempt
// drops these words. A preempt cannot drop other words: they play for a cycle, and at their commit o_preempt repeats the preempt.
// Silence after a record of amplitudes is that record with all amplitudes at 0, so that the slew limiter can fade it.
// While outputs are off and a preempt has been answered by a loaded record, the go point is now.
// o_period strobes once a carrier period: at the go point, or when a period without a go point has ended.
// If pulses from before the last change still run at the go point, the last period's words play again, and o_missed strobes.
// CHANNELS, TIMING_BITS and WIDTH_BITS are the core's. LEAD is at least CHANNELS + 44: 4 clocks for the modulation, 19 for the slew
// limiter, 14 from the drive memory to the generators, 7 for the control. IDLE_CLOCKS is the cycle before the first record.
`default_nettype none
module period_controller #(
    parameter CHANNELS     = 100,
    parameter TIMING_BITS  = 11,
    parameter WIDTH_BITS   = 10,
    parameter LEAD         = 144,
    parameter IDLE_CLOCKS  = 1250,
    parameter CHANNEL_BITS = $clog2(CHANNELS)  // follows from CHANNELS
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_allow,        // from output_guard
    input  wire                    i_preempt,      // strobe
    input  wire                    i_streams,      // records of timings wait for the go point, too
    // From and to cycle_controller
    input  wire                    i_tick,
    input  wire                    i_cycle_start,
    input  wire                    i_settled,
    input  wire                    i_follows,
    input  wire                    i_asked,
    input  wire                    i_commit,       // of what was taken over
    input  wire                    i_refresh,      // of the present record's next words
    output wire                    o_preempt,
    output wire                    o_ready,
    output wire                    o_refresh,
    output wire                    o_words,        // all words for the next cycle are there, and may begin early pulses
    output wire                    o_centred,      // the present record has amplitudes, so its pulses are centred on their phases
    output reg  [15:0]             o_index,
    output reg  [15:0]             o_dwell,
    output reg  [1:0]              o_tag,
    output reg                     o_silent,       // no pulses, and cycle and prescaler stay
    output reg  [23:0]             o_cycle_length,
    output reg  [23:0]             o_prescaler,
    output reg  [WIDTH_BITS-1:0]   o_longest,
    // The next record, whole in the drive memory
    input  wire                    i_next,
    input  wire                    i_next_silent,
    input  wire                    i_next_amplitudes,
    input  wire [15:0]             i_next_index,
    input  wire [15:0]             i_next_dwell,
    input  wire [1:0]              i_next_tag,
    input  wire [23:0]             i_next_cycle_length,
    input  wire [23:0]             i_next_prescaler,
    input  wire [WIDTH_BITS-1:0]   i_next_pulse_length,
    output wire                    o_take_over,
    // The sweep: drive memory to emission
    output reg                     o_bank,         // of the drive memory, the one that is read
    output reg  [CHANNEL_BITS-1:0] o_channel,
    output reg                     o_mute,
    output wire                    o_begin,
    output wire                    o_new_target,
    output reg                     o_raw,
    output reg  [WIDTH_BITS-1:0]   o_raw_width,
    output reg  [TIMING_BITS:0]    o_cycle,
    output wire                    o_drop,         // strobe: words that are under way to emission are not wanted any more
    input  wire                    i_ready,
    output wire                    o_valid,
    output wire                    o_last,
    input  wire                    i_word,         // a word has come to the generators
    input  wire                    i_word_last,
    input  wire [WIDTH_BITS-1:0]   i_width,
    input  wire                    i_bent,
    output wire                    o_period,
    output wire                    o_go,           // strobe: the go point; in the next clock no record waits to be taken over
    output wire                    o_busy,         // the settings of the slew limiter must stay
    output reg                     o_bent,         // strobe: a word of this period was bent
    output reg                     o_missed        // strobe
);
    localparam [23:0] LEAD_TICKS = LEAD[23:0], LONG_TICKS = LEAD[23:0] / 24'd2 + 24'd1;  // with ticks of one clock, and of more
    localparam integer IDLE_ROOM  = IDLE_CLOCKS - IDLE_CLOCKS / 4;
    localparam integer IDLE_TICKS = IDLE_ROOM > LEAD ? IDLE_ROOM - LEAD : 0;
    localparam [23:0] IDLE_WAIT = IDLE_TICKS[23:0];
    localparam [23:0] NO_WRAP = (1 << TIMING_BITS) + (1 << WIDTH_BITS);
    localparam [CHANNEL_BITS-1:0] LAST = CHANNELS[CHANNEL_BITS-1:0] - 1'b1;

    generate
        if (LEAD < CHANNELS + 44) lead_out_of_range error();
    endgenerate

    // ---- The go point of the present cycle

    reg [23:0] wait_q, left_q;  // ticks to it, from the cycle's start and from now
    reg        given_q;         // o_period has been given for the next cycle
    reg        owed_q;          // or must be given late, for the present one
    reg [2:0]  given_before_q;  // in the last three clocks: the modulation takes four
    reg        busy_q;          // words are being made, or wait to be put to use
    reg        taken_q;         // they are of a record that was taken over
    reg        plays_q;         // the record at the pins has amplitudes, or is the silence after one
    wire       quiet  = given_before_q == 3'd0 && !owed_q && !i_cycle_start;
    wire       wanted = i_next && i_follows && !i_preempt;
    wire       forced = !i_allow && i_asked && wanted;
    wire       near   = left_q == 24'd0 && !given_q;
    wire       go     = quiet && (near || forced);
    assign o_go     = go && !given_q;
    assign o_period = o_go || (owed_q && given_before_q == 3'd0);

    // With ticks of one clock a quarter of the cycle earlier, because there early pulses begin.
    wire        short_ticks = o_prescaler == 24'd1;
    wire [23:0] lead        = short_ticks ? LEAD_TICKS : LONG_TICKS;
    wire [23:0] room        = short_ticks ? o_cycle_length - (o_cycle_length >> 2) : o_cycle_length;
    always @(posedge clk) begin
        given_before_q <= rst ? 3'd0 : {given_before_q[1:0], o_period};
        if (rst) {given_q, owed_q} <= 2'b00;
        else begin
            if (i_cycle_start) given_q <= 1'b0;
            else if (go) given_q <= 1'b1;
            if (i_cycle_start && !given_q) owed_q <= 1'b1;
            else if (o_period) owed_q <= 1'b0;
        end
        if (rst) wait_q <= IDLE_WAIT;
        else if (i_commit && !o_silent) wait_q <= room > lead ? room - lead : 24'd0;
        if (i_cycle_start) left_q <= wait_q;
        else if (i_tick && left_q != 24'd0) left_q <= left_q - 1'b1;
    end

    // ---- What the next cycle plays

    wire idle     = !busy_q && i_settled;
    wire promptly = idle && !plays_q && !i_streams && wanted && (i_next_silent || !i_next_amplitudes);
    wire renews   = idle && go && plays_q && !wanted;
    assign o_take_over = promptly || (idle && go && wanted);
    assign o_drop      = i_preempt && taken_q && o_raw && !plays_q && !i_commit;
    // A preempt that cannot drop the record that was taken over is repeated at the record's commit.
    reg    again_q;
    assign o_preempt = i_preempt || (i_commit && again_q);
    reg    fresh_q, bent_q, committed_q;
    always @(posedge clk) begin
        if (rst || o_drop || i_commit || i_refresh) {busy_q, taken_q} <= 2'b00;
        else if (o_take_over || renews) {busy_q, taken_q} <= {1'b1, o_take_over};
        if (rst || i_commit) again_q <= 1'b0;
        else if (i_preempt && taken_q && !o_drop) again_q <= 1'b1;
        if (rst) plays_q <= 1'b0;
        else if (i_commit) plays_q <= !o_raw;
        committed_q <= i_commit || i_refresh;
        o_missed    <= !rst && i_cycle_start && plays_q && !committed_q;
        if (rst) begin
            {o_raw, o_silent, o_mute, o_bank} <= 4'b1100;
            {o_tag, o_index, o_dwell, o_cycle_length, o_prescaler} <= 82'd1;
        end else if (o_take_over) begin
            {o_tag, o_index, o_dwell} <= {i_next_tag, i_next_index, i_next_dwell};
            o_silent <= i_next_silent && o_raw;
            o_mute   <= i_next_silent;
            if (!i_next_silent) begin
                {o_raw, o_bank} <= {!i_next_amplitudes, !o_bank};
                {o_cycle_length, o_prescaler, o_raw_width} <= {i_next_cycle_length, i_next_prescaler, i_next_pulse_length};
            end
        end
        o_cycle <= o_cycle_length >= NO_WRAP ? {(TIMING_BITS+1){1'b1}} : o_cycle_length[TIMING_BITS:0];
    end

    // ---- Its words

    // One-hot: four clocks for the modulation's sample, then the words when emission is ready for them.
    reg [4:1] steps_q;
    reg       sweeps_q, prepared_q, valid_1_q, valid_2_q, last_1_q, last_2_q;
    wire      without_sample = i_next_silent ? o_raw : !i_next_amplitudes;
    wire      issues = sweeps_q && i_ready;
    assign o_busy       = busy_q;
    assign o_begin      = steps_q[4];
    assign o_new_target = fresh_q;
    assign {o_valid, o_last} = {valid_2_q, last_2_q};
    assign o_ready      = prepared_q && taken_q;
    assign o_refresh    = prepared_q && !taken_q;
    assign o_words      = prepared_q && !o_silent;
    assign o_centred    = plays_q;
    always @(posedge clk) begin
        // Silence after timings needs no words; timings need neither a sample nor the slew limiter.
        steps_q <= rst ? 4'd0 : {steps_q[3:1], renews || (o_take_over && !without_sample)};
        if (o_take_over || renews) fresh_q <= o_take_over;
        if (rst || o_drop) sweeps_q <= 1'b0;
        else if (o_begin || (o_take_over && !i_next_silent && !i_next_amplitudes)) sweeps_q <= 1'b1;
        else if (issues && o_channel == LAST) sweeps_q <= 1'b0;
        if (o_take_over || renews) o_channel <= {CHANNEL_BITS{1'b0}};
        else if (issues) o_channel <= o_channel + 1'b1;
        {valid_2_q, valid_1_q} <= rst || o_drop ? 2'b00 : {valid_1_q, issues};
        {last_2_q, last_1_q}   <= {last_1_q, o_channel == LAST};

        if (rst || o_drop || i_commit || i_refresh) prepared_q <= 1'b0;
        else if ((o_take_over && i_next_silent && o_raw) || (i_word && i_word_last)) prepared_q <= 1'b1;
        if (o_take_over || renews) {o_longest, bent_q} <= {(WIDTH_BITS+1){1'b0}};
        else if (i_word) begin
            if (i_width > o_longest) o_longest <= i_width;
            bent_q <= bent_q || i_bent;
        end
        o_bent <= !rst && i_word && i_word_last && (bent_q || i_bent);
    end

`ifdef FORMAL
    `include "formal/period_controller.vh"
`endif
endmodule
`default_nettype wire
