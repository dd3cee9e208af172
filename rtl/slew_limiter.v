// SPDX-License-Identifier: Apache-2.0
//
// Keeps what each channel emits, and lets its phase and amplitude change only so fast: abrupt changes of ultrasound are heard.
//
// Words come after i_begin, once o_ready, a channel a clock, and leave four clocks later. The phase goes the shorter way round; from
// exactly the opposite one, backwards. Modes, which must hold for the period:
//   0  none: every word is at its target.
//   1  rate: phase and amplitude move towards their targets by at most i_phase_rate and i_amplitude_rate.
//   2  arrive: in the period with i_new_target a count starts at i_arrival_periods, and falls by 1 each period. With r of it left a
//      word goes 1/r of the way that is left, so in the count's last period it is at its target; then it follows it as in mode 0.
//      1/r is rounded down to 2^-17, which bends the straight way by less than i_arrival_periods / 2^17 of its length.
// In each mode a word keeps its place for the next period, so a limiter that is switched on starts from where the channels are.
// i_hold lets words through untouched, and keeps the places. o_bent comes one clock after a word that is not at its target.
`default_nettype none
module slew_limiter #(
    parameter CHANNELS = 100
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_begin,
    input  wire        i_new_target,       // with i_begin
    input  wire        i_hold,
    input  wire [1:0]  i_mode,
    input  wire [15:0] i_phase_rate,
    input  wire [15:0] i_amplitude_rate,
    input  wire [11:0] i_arrival_periods,  // 0 counts as 1
    output wire        o_ready,
    input  wire        i_valid,
    input  wire        i_last,
    input  wire [15:0] i_amplitude,
    input  wire [15:0] i_phase,
    output reg  [15:0] o_amplitude,
    output reg  [15:0] o_phase,
    output reg         o_bent
);
    localparam BITS = CHANNELS > 1 ? $clog2(CHANNELS) : 1;
    localparam [1:0] RATE = 2'd1, ARRIVE = 2'd2;

    generate
        if (CHANNELS < 1) channels_out_of_range error();
    endgenerate

    // How many periods are left, and 2^17 divided by that, a bit a clock.
    reg [11:0] left_q, rest_q;
    reg [4:0]  bits_q;  // of the quotient, still to come
    reg [16:0] share_q;
    reg        first_q;
    wire [12:0] rest    = {rest_q, first_q};
    wire        goes    = rest >= {1'b0, left_q};
    wire [12:0] reduced = rest - {1'b0, left_q};
    wire        arrived = left_q <= 12'd1;
    assign o_ready = bits_q == 5'd0;
    always @(posedge clk) begin
        if (rst) left_q <= 12'd0;
        else if (i_begin && i_new_target) left_q <= i_arrival_periods;
        else if (i_begin && !arrived) left_q <= left_q - 1'b1;
        if (rst) bits_q <= 5'd0;
        else if (i_begin) bits_q <= 5'd18;
        else if (bits_q != 5'd0) bits_q <= bits_q - 1'b1;
        first_q <= i_begin;
        if (i_begin) rest_q <= 12'd0;
        else rest_q <= goes ? reduced[11:0] : rest[11:0];
        if (bits_q != 5'd0) share_q <= {share_q[15:0], goes};
    end

    // The places of all channels. A place is read and written in different clocks of a period.
    reg [BITS-1:0] channel_q, channel_1, channel_2, channel_3;
    reg [3:0]      writes_q;
    (* no_rw_check *) reg [31:0] places [0:(1<<BITS)-1];
    integer i;
    initial for (i = 0; i < (1 << BITS); i = i + 1) places[i] = 32'd0;
    reg [31:0] place_1, place_2, place_3, target_1, target_2, target_3, target_4;
    reg [31:0] word_d;
    always @(posedge clk) begin
        if (rst || i_begin) channel_q <= {BITS{1'b0}};
        else if (i_valid) channel_q <= i_last ? {BITS{1'b0}} : channel_q + 1'b1;
        {channel_3, channel_2, channel_1} <= {channel_2, channel_1, channel_q};
        writes_q <= rst ? 4'd0 : {writes_q[2:0], i_valid && !i_hold};
        place_1 <= places[channel_q];
        {place_3, place_2} <= {place_2, place_1};
        {target_4, target_3, target_2, target_1} <= {target_3, target_2, target_1, i_amplitude, i_phase};
        if (writes_q[2]) places[channel_3] <= word_d;
    end

    // A step is a product in both modes, so that one multiplier serves both: way · share / 2^17, or ±2^16 · 2 rate / 2^17.
    wire        by_rate = i_mode == RATE;
    wire        follows = i_hold || (i_mode != RATE && (i_mode != ARRIVE || arrived));
    wire [16:0] phase_rate     = {1'b0, i_phase_rate};
    wire [16:0] amplitude_rate = {1'b0, i_amplitude_rate};
    reg signed [16:0] phase_way, amplitude_way;      // from the place to the target
    wire [15:0] phase_turn = target_1[15:0] - place_1[15:0];
    wire [16:0] phase_over     = phase_way[16] ? phase_way + phase_rate : phase_way - phase_rate;
    wire [16:0] amplitude_over = amplitude_way[16] ? amplitude_way + amplitude_rate : amplitude_way - amplitude_rate;
    reg signed [17:0] phase_factor, amplitude_factor, phase_share, amplitude_share;
    reg         phase_follows, amplitude_follows;
    wire signed [35:0] phase_product     = phase_factor * phase_share;
    wire signed [35:0] amplitude_product = amplitude_factor * amplitude_share;
endmodule
`default_nettype wire
