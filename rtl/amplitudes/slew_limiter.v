// SPDX-License-Identifier: Apache-2.0
//
// Keeps what each channel emits, and lets its phase and amplitude change only so fast: abrupt changes of ultrasound are heard.
//
// Words come after i_begin, once o_ready, a channel a clock, and leave five clocks later. The phase goes the shorter way round; from
// exactly the opposite one, backwards. Modes, which must hold for the period:
//   0  none: every word is at its target.
//   1  rate: phase and amplitude move towards their targets by at most i_phase_rate and i_amplitude_rate.
//   2  arrive: in the period with i_new_target a count starts at i_arrival_periods, and falls by 1 each period. With r of it left a
//      word goes 1/r of the way that is left, so in the count's last period it is at its target; then it follows it as in mode 0.
//      Rounding bends the straight way of n periods by less than n / 2^17 of its length and n / e + 2 units.
// In each mode a word keeps its place for the next period, so a limiter that is switched on starts from where the channels are. i_hold
// lets words through untouched, which have no place; while i_off, and in a reset, the pins are silent. The first period after either
// starts from amplitude 0, where a phase is not heard, so it is at its target at once. That is known at i_begin; i_off may change at any time.
// o_bent comes one clock after a word that is not at its target.
`default_nettype none
module slew_limiter #(
    parameter CHANNELS = 100
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_begin,
    input  wire        i_new_target,       // with i_begin
    input  wire        i_hold,
    input  wire        i_off,
    input  wire [1:0]  i_mode,
    input  wire [15:0] i_phase_rate,
    input  wire [15:0] i_amplitude_rate,
    input  wire [11:0] i_arrival_periods,  // 0 counts as 1
    output wire        o_ready,
    input  wire        i_valid,
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

    // What the pins have done since the last period was begun is not in the places, so they count as silent.
    reg silent_q, starts_q;
    always @(posedge clk) begin
        if (rst || i_off || (i_valid && i_hold)) silent_q <= 1'b1;
        else if (i_begin) silent_q <= 1'b0;
        if (i_begin) starts_q <= silent_q;
    end

    // The places of all channels. A number at a register's end says how many clocks after the input it is.
    reg  [BITS-1:0] channel_q, channel_1, channel_2, channel_3, channel_4, channel_5;
    reg  [5:1]      writes_q;
    (* no_rw_check *) reg [31:0] places [0:(1<<BITS)-1];  // {amplitude, phase}; not written in the clock in which it is read
    integer i;
    initial begin
        writes_q = 5'd0;  // nothing is written before the first reset, either
        for (i = 0; i < (1 << BITS); i = i + 1) places[i] = 32'd0;
    end
    reg  [31:0] place_q;
    wire [31:0] place_1 = {place_q[31:16] & {16{!starts_q}}, place_q[15:0]};
    reg  [31:0] place_2, place_3, place_4, target_1, target_2, target_3, target_4, target_5;
    always @(posedge clk) begin
        if (rst || i_begin) channel_q <= {BITS{1'b0}};
        else if (i_valid) channel_q <= channel_q + 1'b1;
        {channel_5, channel_4, channel_3, channel_2, channel_1} <= {channel_4, channel_3, channel_2, channel_1, channel_q};
        writes_q <= rst ? 5'd0 : {writes_q[4:1], i_valid && !i_hold};
        place_q <= places[channel_q];
        {place_4, place_3, place_2} <= {place_3, place_2, place_1};
        {target_5, target_4, target_3, target_2, target_1} <= {target_4, target_3, target_2, target_1, i_amplitude, i_phase};
        if (writes_q[5]) places[channel_5] <= {o_amplitude, o_phase};
    end

    // A step is a product in both modes, so that one multiplier serves both: way · share, or ±1/2 · 2 rate. A factor is in units, a
    // share in 2^-17.
    wire by_rate = i_mode == RATE;
    wire follows = i_hold || (i_mode != RATE && (i_mode != ARRIVE || arrived));
    wire [15:0] turn = target_1[15:0] - place_1[15:0];
    reg  [16:0] phase_way_2, amplitude_way_2;  // from the place to the target, signed
    // These have the way's sign when it is longer than the rate; an inverted number is one less than the negative one.
    wire [16:0] phase_over     = phase_way_2 + ({1'b0, i_phase_rate} ^ {17{!phase_way_2[16]}});
    wire [16:0] amplitude_over = amplitude_way_2 + ({1'b0, i_amplitude_rate} ^ {17{!amplitude_way_2[16]}});
    reg  signed [17:0] phase_factor_3, amplitude_factor_3, phase_share_q, amplitude_share_q;
    reg         phase_follows_3, amplitude_follows_3, phase_follows_4, amplitude_follows_4;
    wire signed [35:0] phase_product     = phase_factor_3 * phase_share_q;
    wire signed [35:0] amplitude_product = amplitude_factor_3 * amplitude_share_q;
    reg  [15:0] phase_step_4, amplitude_step_4;
    always @(posedge clk) begin
        phase_way_2     <= {turn[15], turn};
        amplitude_way_2 <= {1'b0, target_1[31:16]} - {1'b0, place_1[31:16]};

        phase_factor_3      <= {phase_way_2[16], phase_way_2[16] || by_rate, phase_way_2[15:0] & {16{!by_rate}}};
        amplitude_factor_3  <= {amplitude_way_2[16], amplitude_way_2[16] || by_rate, amplitude_way_2[15:0] & {16{!by_rate}}};
        phase_follows_3     <= follows || starts_q || (by_rate && phase_over[16] != phase_way_2[16]);
        amplitude_follows_3 <= follows || (by_rate && amplitude_over[16] != amplitude_way_2[16]);
        phase_share_q       <= by_rate ? {1'b0, i_phase_rate, 1'b0} : {1'b0, share_q};
        amplitude_share_q   <= by_rate ? {1'b0, i_amplitude_rate, 1'b0} : {1'b0, share_q};

        phase_step_4     <= phase_product[32:17];
        amplitude_step_4 <= amplitude_product[32:17];
        {phase_follows_4, amplitude_follows_4} <= {phase_follows_3, amplitude_follows_3};

        o_phase     <= phase_follows_4 ? target_4[15:0] : place_4[15:0] + phase_step_4;
        o_amplitude <= amplitude_follows_4 ? target_4[31:16] : place_4[31:16] + amplitude_step_4;
        o_bent      <= {o_amplitude, o_phase} != target_5;
    end
    wire unused = &{1'b0, reduced[12], phase_over[15:0], amplitude_over[15:0], phase_product[35:33], phase_product[16:0],
                    amplitude_product[35:33], amplitude_product[16:0]};
endmodule
`default_nettype wire
