// SPDX-License-Identifier: Apache-2.0
//
// The parameters block of the address space: settings of the foci and of the slew limiter, which a host writes and reads.
//
// As a memory, it is not reset; what it holds at power-up is an `initial` value. o_word follows i_read_address by one clock.
// IDLE_CLOCKS is the first carrier period of focus records.
`default_nettype none
`include "interface.vh"
module parameter_registers #(
    parameter IDLE_CLOCKS = 1250
) (
    input  wire        clk,
    input  wire        i_write,
    input  wire [4:0]  i_write_address,
    input  wire [15:0] i_write_word,
    input  wire [4:0]  i_read_address,
    output reg  [15:0] o_word,
    output reg  [15:0] o_foci_base,
    output reg  [15:0] o_foci_count,
    output reg  [2:0]  o_foci_last,
    output reg         o_foci_whole,
    output reg  [15:0] o_foci_cycle,
    output reg  [17:0] o_wave_number,
    output reg  [15:0] o_gain,
    output reg  [1:0]  o_slew,
    output reg  [15:0] o_phase_rate,
    output reg  [15:0] o_amplitude_rate,
    output reg  [11:0] o_arrival_periods
);
    initial begin
        {o_foci_base, o_foci_count, o_foci_last, o_foci_whole, o_foci_cycle} = {36'd0, IDLE_CLOCKS[15:0]};
        {o_wave_number, o_gain, o_slew} = 36'd0;
        {o_phase_rate, o_amplitude_rate, o_arrival_periods} = {32'hffffffff, 12'd1};
    end

    always @(posedge clk) begin
        if (i_write) case (i_write_address)
            `HG_PARAMETERS_FOCI_BASE:        o_foci_base  <= i_write_word;
            `HG_PARAMETERS_FOCI_COUNT:       o_foci_count <= i_write_word;
            `HG_PARAMETERS_FOCI_FORM:        {o_foci_whole, o_foci_last} <= i_write_word[3:0];
            `HG_PARAMETERS_FOCI_CYCLE:       o_foci_cycle <= i_write_word;
            `HG_PARAMETERS_WAVE_NUMBER_LOW:  o_wave_number[15:0]  <= i_write_word;
            `HG_PARAMETERS_WAVE_NUMBER_HIGH: o_wave_number[17:16] <= i_write_word[1:0];
            `HG_PARAMETERS_GAIN:             o_gain <= i_write_word;
            `HG_PARAMETERS_SLEW_MODE:        o_slew <= i_write_word[1:0];
            `HG_PARAMETERS_PHASE_RATE:       o_phase_rate     <= i_write_word;
            `HG_PARAMETERS_AMPLITUDE_RATE:   o_amplitude_rate <= i_write_word;
            `HG_PARAMETERS_ARRIVAL_PERIODS:  o_arrival_periods <= i_write_word[11:0];
            default: ;
        endcase
        case (i_read_address)
            `HG_PARAMETERS_FOCI_BASE:        o_word <= o_foci_base;
            `HG_PARAMETERS_FOCI_COUNT:       o_word <= o_foci_count;
            `HG_PARAMETERS_FOCI_FORM:        o_word <= {12'd0, o_foci_whole, o_foci_last};
            `HG_PARAMETERS_FOCI_CYCLE:       o_word <= o_foci_cycle;
            `HG_PARAMETERS_WAVE_NUMBER_LOW:  o_word <= o_wave_number[15:0];
            `HG_PARAMETERS_WAVE_NUMBER_HIGH: o_word <= {14'd0, o_wave_number[17:16]};
            `HG_PARAMETERS_GAIN:             o_word <= o_gain;
            `HG_PARAMETERS_SLEW_MODE:        o_word <= {14'd0, o_slew};
            `HG_PARAMETERS_PHASE_RATE:       o_word <= o_phase_rate;
            `HG_PARAMETERS_AMPLITUDE_RATE:   o_word <= o_amplitude_rate;
            default:                         o_word <= {4'd0, o_arrival_periods};
        endcase
    end
endmodule
`default_nettype wire
