// SPDX-License-Identifier: Apache-2.0
//
// Makes the pulse generators' words of what the channels are to emit, once a carrier period, a channel a clock:
// amplitude · modulation → slew limit → width = cycle · asin(amplitude) / π (Hoshi et al. 2010, eq. 7) → {early, rise, fall}.
//
// i_begin opens a period; the settings must hold from then until o_last. Words come while o_ready, from channel 0 on, with
// i_last at the last one; each leaves 11 clocks later. The next i_begin comes after o_last. i_phase is where the pulse's middle
// lies, in 65,536ths of the cycle; an amplitude of 65,535 is full. Whatever the amplitude, the middle stays within half a tick.
// With i_raw, i_phase is the tick at which a pulse of i_raw_width starts, and neither modulation nor slew limit applies.
// A word without a pulse is {0, all ones}: width 0, a tick not below the cycle, or a start at which no pulse can start.
// The slew limiter keeps what each channel emits in a block RAM, and changes it by at most a rate a period, or so that it arrives in
// i_arrival_periods from the period with i_new_target on. o_bent is high with a word that has not reached its target.
// CHANNELS, TIMING_BITS and WIDTH_BITS are those of width_pulse_generators. SLEW 0 leaves the limiter out.
`default_nettype none
module emission #(
    parameter CHANNELS    = 100,
    parameter TIMING_BITS = 11,
    parameter WIDTH_BITS  = 10,
    parameter SLEW        = 1
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_begin,
    input  wire [7:0]             i_modulation,       // 255: full
    input  wire [TIMING_BITS:0]   i_cycle,            // ticks; up to 2^(WIDTH_BITS + 1) − 2 unless raw; all ones: so many or more
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

    generate
        if (CHANNELS < 1) channels_out_of_range error();
        if (TIMING_BITS < 4 || TIMING_BITS > 16) timing_bits_out_of_range error();
        if (WIDTH_BITS < 1 || WIDTH_BITS > TIMING_BITS) width_bits_out_of_range error();
        if (SLEW < 0 || SLEW > 1) slew_out_of_range error();
    endgenerate

    // A number at a register's end says how many clocks after the input it is.
    reg [10:1] valid_q, last_q;
    always @(posedge clk) begin
        valid_q <= rst ? 10'd0 : {valid_q[9:1], i_valid};
        last_q  <= {last_q[9:1], i_last};
        o_valid <= !rst && valid_q[10];
        o_last  <= !rst && valid_q[10] && last_q[10];
    end

    // A sample of 255 leaves an amplitude as it is: a · (257 · sample + 1) / 65536.
    wire [15:0] modulation = {i_modulation, i_modulation};
    reg  [31:0] product_1;
    reg  [15:0] amplitude_1, phase_1, phase_2, amplitude_2;
    wire [31:0] modulated = product_1 + {16'd0, amplitude_1};
    always @(posedge clk) begin
        product_1   <= i_amplitude * modulation;
        amplitude_1 <= i_amplitude;
        {phase_2, phase_1} <= {phase_1, i_phase};
        amplitude_2 <= modulated[31:16];
    end

    wire [15:0] amplitude_6, phase_6;
    wire        bent_7;
    generate
        if (SLEW != 0) begin : limited
            slew_limiter #(.CHANNELS(CHANNELS)) limiter (
                .clk(clk), .rst(rst), .i_begin(i_begin), .i_hold(i_raw), .i_mode(i_slew), .i_phase_rate(i_phase_rate),
                .i_amplitude_rate(i_amplitude_rate), .i_arrival_periods(i_arrival_periods), .i_new_target(i_new_target), .o_ready(o_ready),
                .i_valid(valid_q[2]), .i_last(last_q[2]), .i_amplitude(amplitude_2), .i_phase(phase_2),
                .o_amplitude(amplitude_6), .o_phase(phase_6), .o_bent(bent_7));
        end else begin : free
            reg [95:0] delayed_q;
            always @(posedge clk) delayed_q <= {delayed_q[63:0], amplitude_2, phase_2};
            reg [31:0] delayed_6;
            always @(posedge clk) delayed_6 <= delayed_q[95:64];
            assign {amplitude_6, phase_6} = delayed_6;
            assign {o_ready, bent_7} = 2'b10;
            wire unused = &{1'b0, i_begin, i_slew, i_phase_rate, i_amplitude_rate, i_arrival_periods, i_new_target, delayed_q[31:0]};
        end
    endgenerate

    // Width and middle in ticks. The middle is in half ticks, so that an odd width leaves it where it is.
    (* rom_style = "block" *) reg [15:0] arcsine [0:1023];
    `include "tables/arcsine.vh"
    reg  [15:0]   width_7, phase_7, phase_8;
    reg  [T+16:0] width_8, middle_8;
    wire          too_late = {{T{1'b0}}, phase_8} >= {{15{1'b0}}, i_cycle};
    reg  [T-1:0]  width_9;
    reg  [T+1:0]  middle_9;
    always @(posedge clk) begin
        width_7  <= arcsine[amplitude_6[15:6]];
        {phase_8, phase_7} <= {phase_7, phase_6};
        width_8  <= width_7 * i_cycle;
        middle_8 <= phase_7 * i_cycle;
        if (!i_raw) width_9 <= width_8[T+16:17] + {{(T-1){1'b0}}, width_8[16]};
        else width_9 <= too_late ? {T{1'b0}} : {{(T-WIDTH_BITS){1'b0}}, i_raw_width};
        middle_9 <= i_raw ? {raw_tick, 1'b0} : middle_8[T+16:15];
    end
endmodule
`default_nettype wire
