// SPDX-License-Identifier: Apache-2.0
//
// Makes the pulse generators' words of what the channels are to emit, once a carrier period, a channel a clock:
// amplitude · modulation → slew limit → width = cycle · asin(amplitude) / π (Hoshi et al. 2010, eq. 7) → {early, fall, rise}.
//
// i_begin opens a period; the settings must hold from then until o_last. Words come while o_ready, from channel 0 on, with i_last at
// the last one; each leaves 12 clocks later. The next i_begin comes after o_last. i_phase is where the pulse's middle
// lies, in 65,536ths of the cycle; an amplitude of 65,535 is full. Whatever the amplitude, the middle stays within half a tick.
// With i_raw, i_phase is the tick at which a pulse of i_raw_width starts, and neither modulation nor slew limit applies.
// A word without a pulse is {0, all ones}: width 0, a tick not below the cycle, or a start at which no pulse can start.
// Of a pulse that would be shorter than LEAST_WIDTH ticks, none or one of so many is left, whichever is nearer. Raw ones have been looked
// at before.
// The slew limiter keeps what each channel emits in a block RAM, and changes it by at most a rate a period, or so that it arrives in
// i_arrival_periods from the period with i_new_target on. o_bent is high with a word that has not reached its target.
// CHANNELS, TIMING_BITS and WIDTH_BITS are those of width_pulse_generators. SLEW 0 leaves the limiter out.
`default_nettype none
module emission #(
    parameter CHANNELS    = 100,
    parameter TIMING_BITS = 11,
    parameter WIDTH_BITS  = 10,
    parameter LEAST_WIDTH = 1,
    parameter SLEW        = 1
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_begin,
    input  wire [7:0]             i_modulation,       // 255: full
    input  wire                   i_off,              // outputs are off; may change at any time
    input  wire [TIMING_BITS:0]   i_cycle,            // ticks, up to 2^(WIDTH_BITS + 1) − 2, raw up to 2^TIMING_BITS; all ones: 2^TIMING_BITS + 2^WIDTH_BITS or more
    input  wire                   i_raw,
    input  wire [WIDTH_BITS-1:0]  i_raw_width,
    input  wire [1:0]             i_slew,             // 0: none, 1: at most the two rates a period, 2: arrive
    input  wire [15:0]            i_phase_rate,       // 65,536ths of the cycle a period
    input  wire [15:0]            i_amplitude_rate,
    input  wire [11:0]            i_arrival_periods,  // 0 counts as 1
    input  wire                   i_new_target,       // with i_begin
    output wire                   o_ready,
    input  wire                   i_valid,
    input  wire                   i_last,
    input  wire [15:0]            i_amplitude,
    input  wire [15:0]            i_phase,
    output reg                    o_valid,
    output reg                    o_last,
    output reg  [2*TIMING_BITS:0] o_word,
    output reg  [WIDTH_BITS-1:0]  o_width,
    output reg                    o_bent
);
    localparam T = TIMING_BITS;
    localparam [T-1:0] NEVER = {T{1'b1}};
    localparam [T-1:0] LEAST = LEAST_WIDTH[T-1:0];

    generate
        if (CHANNELS < 1) channels_out_of_range error();
        if (TIMING_BITS < 4 || TIMING_BITS > 16) timing_bits_out_of_range error();
        if (WIDTH_BITS < 1 || WIDTH_BITS > TIMING_BITS) width_bits_out_of_range error();
        if (LEAST_WIDTH < 1 || LEAST_WIDTH >= 1 << WIDTH_BITS) least_width_out_of_range error();
        if (SLEW < 0 || SLEW > 1) slew_out_of_range error();
    endgenerate

    // A number at a register's end says how many clocks after the input it is.
    reg [11:1] valid_q, last_q;
    always @(posedge clk) begin
        valid_q <= rst ? 11'd0 : {valid_q[10:1], i_valid};
        last_q  <= {last_q[10:1], i_last};
        o_valid <= !rst && valid_q[11];
        o_last  <= !rst && valid_q[11] && last_q[11];
    end

    // A sample of 255 leaves an amplitude as it is: amplitude · (257 · sample + 1) / 65536.
    reg  [16:0] factor_q;
    reg  [32:0] modulated_1;
    reg  [15:0] phase_1;
    always @(posedge clk) begin
        factor_q    <= {1'b0, i_modulation, i_modulation} + 17'd1;
        modulated_1 <= {17'd0, i_amplitude} * {16'd0, factor_q};
        phase_1     <= i_phase;
    end
    wire [15:0] amplitude_1 = modulated_1[31:16];

    wire [15:0] amplitude_6, phase_6;
    wire        bent_7;
    generate
        if (SLEW != 0) begin : limited
            slew_limiter #(.CHANNELS(CHANNELS)) limiter (
                .clk(clk), .rst(rst),
                .i_begin(i_begin), .i_new_target(i_new_target), .i_hold(i_raw), .i_off(i_off), .i_mode(i_slew), .i_phase_rate(i_phase_rate),
                .i_amplitude_rate(i_amplitude_rate), .i_arrival_periods(i_arrival_periods), .o_ready(o_ready),
                .i_valid(valid_q[1]), .i_amplitude(amplitude_1), .i_phase(phase_1),
                .o_amplitude(amplitude_6), .o_phase(phase_6), .o_bent(bent_7));
        end else begin : unlimited
            reg [159:0] delayed_q;
            always @(posedge clk) delayed_q <= {delayed_q[127:0], amplitude_1, phase_1};
            assign {amplitude_6, phase_6, bent_7, o_ready} = {delayed_q[159:128], 2'b01};
            wire unused = &{1'b0, i_begin, i_off, i_new_target, i_slew, i_phase_rate, i_amplitude_rate, i_arrival_periods};
        end
    endgenerate

    // Width and middle in ticks. The middle is in half ticks, so that an odd width leaves it where it is. For raw words the middle's
    // register holds the start. The table's word has a clock to itself, as from any block RAM (primary_memory.v).
    (* rom_style = "block" *) reg [15:0] arcsine [0:1023];
    `include "tables/arcsine.vh"
    reg  [15:0]  width_7, width_8, phase_7, phase_8, phase_9;
    reg  [T+16:0] width_9, middle_9;
    reg  [T-1:0] width_10;
    reg  [T+1:0] middle_10;
    wire [T:0]   half_ticks_9 = width_9[T+16:16];
    wire [T-1:0] rounded_9 = width_9[T+16:17] + {{(T-1){1'b0}}, width_9[16]};
    wire [16:0]  tick = {1'b0, phase_9};
    wire [T:0]   tick_9 = tick[T:0];
    wire         too_late = tick >> (T + 1) != 17'd0 || tick_9 >= i_cycle;
    always @(posedge clk) begin
        width_7  <= arcsine[amplitude_6[15:6]];
        width_8  <= width_7;
        {phase_9, phase_8, phase_7} <= {phase_8, phase_7, phase_6};
        width_9  <= {{(T+1){1'b0}}, width_8} * {16'd0, i_cycle};
        middle_9 <= {{(T+1){1'b0}}, phase_8} * {16'd0, i_cycle};
        if (!i_raw) width_10 <= half_ticks_9 < {1'b0, LEAST} ? {T{1'b0}} : rounded_9 < LEAST ? LEAST : rounded_9;
        else width_10 <= too_late ? {T{1'b0}} : {{(T-WIDTH_BITS){1'b0}}, i_raw_width};
        middle_10 <= i_raw ? {tick_9, 1'b0} : middle_9[T+16:15];
    end

    wire [T+2:0] twice = {1'b0, middle_10} - (i_raw ? {(T+3){1'b0}} : {3'd0, width_10}) + {{(T+2){1'b0}}, 1'b1};
    wire         borrows = twice[T+2];  // the pulse starts in the cycle before
    reg          early_11;
    reg  [T:0]   rise_11;
    reg  [T-1:0] width_11;
    wire         silent = width_11 == {T{1'b0}} || rise_11 >= {1'b0, NEVER};
    wire [T+1:0] stop   = {1'b0, rise_11} + {2'b00, width_11};
    wire [T+1:0] over   = stop - {1'b0, i_cycle};
    reg  [10:8]  bent_q;
    reg          bent_11;
    always @(posedge clk) begin
        early_11 <= borrows;
        rise_11  <= borrows ? twice[T+1:1] + i_cycle : twice[T+1:1];
        width_11 <= width_10;
        {bent_11, bent_q} <= {bent_q, bent_7};
        o_word   <= silent ? {1'b0, NEVER, NEVER} : {early_11, over[T+1] ? stop[T-1:0] : over[T-1:0], rise_11[T-1:0]};
        o_width  <= silent ? {WIDTH_BITS{1'b0}} : width_11[WIDTH_BITS-1:0];
        o_bent   <= valid_q[11] && bent_11;
    end
    wire unused = &{1'b0, modulated_1[32], modulated_1[15:0], amplitude_6[5:0], width_9[15:0], middle_9[14:0], twice[0], over[T]};
endmodule
`default_nettype wire
