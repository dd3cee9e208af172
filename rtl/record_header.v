// SPDX-License-Identifier: Apache-2.0
//
// Looks at a record's header: what kind it is, and whether it is well-formed. Combinational.
//
// i_last_word is the header's fourth word, with the kind and the upper bits of the prescaler; the other inputs are from the words before.
// A pulse must fit PULSE_BITS and be at most MAX_DUTY_256 / 256 of the cycle, and a prescaler must fit PRESCALER_BITS. With WIDTH_BITS a
// record may be one of amplitudes, o_amplitudes: pulse length 0, prescaler 1, and a cycle that has room for them, o_has_room: LEAST_CYCLE
// ticks to as many as WIDTH_BITS and MAX_PULSE_CLOCKS allow half of. One of timings is then malformed when its cycle is one over whose
// end emission.v could not carry a pulse. The parameters are those of memory_controller.
`default_nettype none
`include "interface.vh"
module record_header #(
    parameter TIMING_BITS  = 16,
    parameter PULSE_BITS   = 8,
    parameter MAX_PULSE_CLOCKS = 999,
    parameter MAX_DUTY_256     = 128,
    parameter WIDTH_BITS   = 0,
    parameter LEAST_CYCLE  = 2,
    parameter PRESCALER_BITS = 24
) (
    input  wire [7:0]  i_pulse,
    input  wire [23:0] i_cycle,      // ticks
    input  wire [15:0] i_prescaler,  // its lower bits
    input  wire [15:0] i_last_word,
    output wire        o_amplitudes,
    output wire        o_has_room,
    output wire        o_malformed
);
    localparam [31:0] LARGEST_DUTY = MAX_DUTY_256;
    localparam integer WIDEST = (1 << WIDTH_BITS) - 1 < MAX_PULSE_CLOCKS ? (1 << WIDTH_BITS) - 1 : MAX_PULSE_CLOCKS;
    localparam integer MOST_CYCLE = 2 * WIDEST;  // half of it is the widest pulse
    localparam [23:0] LEAST_TICKS = LEAST_CYCLE[23:0], MOST_TICKS = MOST_CYCLE[23:0];
    localparam [23:0] FIRST_UNFIT = (1 << TIMING_BITS) + 1, LAST_UNFIT = (1 << TIMING_BITS) + (1 << WIDTH_BITS) - 1;

    generate
        if (WIDTH_BITS != 0 && LEAST_CYCLE > 2 * WIDEST) width_bits_out_of_range error();
    endgenerate

    wire [24:0] pulse_limit = 25'd1 << PULSE_BITS;
    wire [23:0] prescaler   = {i_last_word[7:0], i_prescaler};
    wire unfit = WIDTH_BITS != 0 && (o_amplitudes ? i_pulse != 8'd0 || prescaler != 24'd1 || !o_has_room
                                                  : i_cycle >= FIRST_UNFIT && i_cycle <= LAST_UNFIT);
    assign o_has_room   = WIDTH_BITS != 0 && i_cycle >= LEAST_TICKS && i_cycle <= MOST_TICKS;
    assign o_amplitudes = WIDTH_BITS != 0 && i_last_word[15:8] == `HG_KIND_AMPLITUDES;
    assign o_malformed  = {17'd0, i_pulse} >= pulse_limit || (i_last_word[15:8] != `HG_KIND_TIMINGS && !o_amplitudes) || unfit
                          || {1'b0, prescaler} >> PRESCALER_BITS != 25'd0
                          || {16'd0, i_pulse, 8'd0} > {8'd0, i_cycle} * LARGEST_DUTY;
endmodule
`default_nettype wire
