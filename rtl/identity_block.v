// SPDX-License-Identifier: Apache-2.0
//
// The identity block of the address space: what this instrument is. o_word is word i_address of it, combinational and constant.
//
// All parameters are the core's, only to be told to the host.
`default_nettype none
`include "interface.vh"
module identity_block #(
    parameter CHANNELS       = 100,
    parameter RECORDS        = 400,
    parameter SEQUENCE_DEPTH = 1024,
    parameter LIVE_DEPTH     = 256,
    parameter TIMING_BITS    = 16,
    parameter PULSE_BITS     = 8,
    parameter CLOCK_HZ       = 50000000,
    parameter MIN_PULSE_CLOCKS = 5,
    parameter MAX_PULSE_CLOCKS = 999,
    parameter MAX_DUTY_256     = 128,
    parameter MAX_CYCLE_CLOCKS = 50000000,
    parameter WIDTH_BITS     = 0,
    parameter MODULATION_DEPTH = 0,
    parameter SLEW           = 0,
    parameter FOCI           = 0,
    parameter SYNC           = 0,
    parameter CHAIN          = 0,
    parameter NET            = 0,
    parameter SCHEDULE       = 0,
    parameter STREAM         = 0,
    parameter TRIGGER        = 0,
    parameter FRAME_BYTES    = 214
) (
    input  wire [4:0]  i_address,
    output reg  [15:0] o_word
);
    localparam [15:0] CHANNELS_16 = CHANNELS[15:0], RECORDS_16 = RECORDS[15:0], SEQUENCE_16 = SEQUENCE_DEPTH[15:0],
                      LIVE_16 = LIVE_DEPTH[15:0], TIMING_16 = TIMING_BITS[15:0], PULSE_16 = PULSE_BITS[15:0];
    localparam [31:0] CLOCK_32 = CLOCK_HZ, CYCLE_32 = MAX_CYCLE_CLOCKS;
    localparam [15:0] MIN_16 = MIN_PULSE_CLOCKS[15:0], DUTY_16 = MAX_DUTY_256[15:0];
    // More than the field holds is said as its largest value: what a host then keeps to, the board plays.
    localparam [15:0] MAX_16 = MAX_PULSE_CLOCKS > 65535 ? 16'hffff : MAX_PULSE_CLOCKS[15:0];
    localparam [127:0] NAME = `HG_NAME;
    localparam SAMPLE_WORDS = MODULATION_DEPTH / 2;
    localparam [15:0] FEATURES = `HG_FEATURES | (WIDTH_BITS != 0 ? `HG_FEATURE_AMPLITUDE : 16'd0) | (SLEW != 0 ? `HG_FEATURE_SLEW : 16'd0)
                                 | (MODULATION_DEPTH != 0 ? `HG_FEATURE_MODULATION : 16'd0) | (FOCI != 0 ? `HG_FEATURE_FOCI | `HG_FEATURE_LIVE_FOCI : 16'd0)
                                 | (SCHEDULE != 0 ? `HG_FEATURE_SCHEDULE : 16'd0) | (SYNC != 0 ? `HG_FEATURE_SYNC : 16'd0)
                                 | (CHAIN != 0 ? `HG_FEATURE_CHAIN : 16'd0) | (NET != 0 ? `HG_FEATURE_NET : 16'd0)
                                 | (STREAM != 0 ? `HG_FEATURE_STREAM : 16'd0) | (TRIGGER != 0 ? `HG_FEATURE_TRIGGER : 16'd0);

    always @* case (i_address)
        `HG_IDENTITY_VERSION:        o_word = `HG_VERSION;
        `HG_IDENTITY_CHANNELS:       o_word = CHANNELS_16;
        `HG_IDENTITY_RECORDS:        o_word = RECORDS_16;
        `HG_IDENTITY_SEQUENCE_DEPTH: o_word = SEQUENCE_16;
        `HG_IDENTITY_LIVE_DEPTH:     o_word = LIVE_16;
        `HG_IDENTITY_BITS:           o_word = {PULSE_16[7:0], TIMING_16[7:0]};
        `HG_IDENTITY_CLOCK_HZ_LOW:   o_word = CLOCK_32[15:0];
        `HG_IDENTITY_CLOCK_HZ_HIGH:  o_word = CLOCK_32[31:16];
        `HG_IDENTITY_FEATURES:       o_word = FEATURES;
        `HG_IDENTITY_FRAME_BYTES:    o_word = FRAME_BYTES[15:0];
        `HG_IDENTITY_MIN_PULSE_CLOCKS: o_word = MIN_16;
        `HG_IDENTITY_MAX_PULSE_CLOCKS: o_word = MAX_16;
        `HG_IDENTITY_MAX_DUTY_256:   o_word = DUTY_16;
        `HG_IDENTITY_MAX_CYCLE_LOW:  o_word = CYCLE_32[15:0];
        `HG_IDENTITY_MAX_CYCLE_HIGH: o_word = CYCLE_32[31:16];
        `HG_IDENTITY_WIDTH_BITS:     o_word = WIDTH_BITS[15:0];
        `HG_IDENTITY_FOCI:           o_word = FOCI[15:0];
        `HG_IDENTITY_MODULATION_WORDS: o_word = SAMPLE_WORDS[15:0];
        default:                     o_word = NAME[{i_address[2:0], 4'd0} +: 16];
    endcase
endmodule
`default_nettype wire
