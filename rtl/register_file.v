// SPDX-License-Identifier: Apache-2.0
//
// The identity and status blocks of the address space: what this instrument is, what it does now, and counters of events.
//
// A host reads them to learn what it may send, and to see what went wrong. o_word follows i_read by one clock. The counters run
// modulo 65,536 and start at 0 after reset.
// All parameters are the core's, only to be told to the host.
`default_nettype none
`include "interface.vh"
module register_file #(
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
    parameter SCHEDULE       = 0,
    parameter FRAME_BYTES    = 214
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_read,
    input  wire        i_is_identity,
    input  wire [4:0]  i_address,  // number of the word
    output reg  [15:0] o_word,
    input  wire        i_enabled,
    input  wire        i_stopped,
    input  wire        i_modulated,
    input  wire [1:0]  i_mode,
    input  wire [15:0] i_present_index,
    input  wire [15:0] i_live_level,
    input  wire [15:0] i_watchdog_ms,
    input  wire [3:0]  i_sync,      // numbered, in step, role
    input  wire        i_underrun,  // from here on strobes, one for each counter
    input  wire        i_record_refused,
    input  wire        i_frame_good,
    input  wire        i_frame_damaged,
    input  wire        i_frame_repeated,
    input  wire        i_frame_refused,
    input  wire        i_watchdog_trip,
    input  wire        i_guard_trip,
    input  wire        i_bent_period,
    input  wire        i_far_foci,
    input  wire        i_sync_missed,
    input  wire        i_sync_lost,
    input  wire        i_late_change,
    input  wire        i_waiting,
    input  wire        i_answer,    // strobe: a reply begins, and the period that it tells is the present one
    input  wire [47:0] i_period
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
                                 | (CHAIN != 0 ? `HG_FEATURE_CHAIN : 16'd0);

    reg [15:0] underruns_q, records_refused_q, good_q, damaged_q, repeated_q, refused_q, watchdog_q, guard_q, bent_q, far_q, missed_q, lost_q, late_q;
    reg [47:0] period_q;
    always @(posedge clk) if (i_answer) period_q <= i_period;
    wire counts = i_underrun || i_record_refused || i_frame_good || i_frame_damaged || i_frame_repeated || i_frame_refused
                  || i_watchdog_trip || i_guard_trip || i_bent_period || i_far_foci || i_sync_missed || i_sync_lost || i_late_change;
    // `counts` in front spares a simulator eight tests in most clocks.
    always @(posedge clk) if (rst || counts) begin
        if (rst) begin
            {underruns_q, records_refused_q, good_q, damaged_q} <= 64'd0;
            {repeated_q, refused_q, watchdog_q, guard_q} <= 64'd0;
            {bent_q, far_q, missed_q, lost_q, late_q} <= 80'd0;
        end else begin
            if (i_underrun) underruns_q <= underruns_q + 1'b1;
            if (i_record_refused) records_refused_q <= records_refused_q + 1'b1;
            if (i_frame_good) good_q <= good_q + 1'b1;
            if (i_frame_damaged) damaged_q <= damaged_q + 1'b1;
            if (i_frame_repeated) repeated_q <= repeated_q + 1'b1;
            if (i_frame_refused) refused_q <= refused_q + 1'b1;
            if (i_watchdog_trip) watchdog_q <= watchdog_q + 1'b1;
            if (i_guard_trip) guard_q <= guard_q + 1'b1;
            if (i_bent_period) bent_q <= bent_q + 1'b1;
            if (i_far_foci) far_q <= far_q + 1'b1;
            if (i_sync_missed) missed_q <= missed_q + 1'b1;
            if (i_sync_lost) lost_q <= lost_q + 1'b1;
            if (i_late_change) late_q <= late_q + 1'b1;
        end
    end

    always @(posedge clk) if (i_read) begin
        if (i_is_identity) case (i_address)
            `HG_IDENTITY_VERSION:        o_word <= `HG_VERSION;
            `HG_IDENTITY_CHANNELS:       o_word <= CHANNELS_16;
            `HG_IDENTITY_RECORDS:        o_word <= RECORDS_16;
            `HG_IDENTITY_SEQUENCE_DEPTH: o_word <= SEQUENCE_16;
            `HG_IDENTITY_LIVE_DEPTH:     o_word <= LIVE_16;
            `HG_IDENTITY_BITS:           o_word <= {PULSE_16[7:0], TIMING_16[7:0]};
            `HG_IDENTITY_CLOCK_HZ_LOW:   o_word <= CLOCK_32[15:0];
            `HG_IDENTITY_CLOCK_HZ_HIGH:  o_word <= CLOCK_32[31:16];
            `HG_IDENTITY_FEATURES:       o_word <= FEATURES;
            `HG_IDENTITY_FRAME_BYTES:    o_word <= FRAME_BYTES[15:0];
            `HG_IDENTITY_MIN_PULSE_CLOCKS: o_word <= MIN_16;
            `HG_IDENTITY_MAX_PULSE_CLOCKS: o_word <= MAX_16;
            `HG_IDENTITY_MAX_DUTY_256:   o_word <= DUTY_16;
            `HG_IDENTITY_MAX_CYCLE_LOW:  o_word <= CYCLE_32[15:0];
            `HG_IDENTITY_MAX_CYCLE_HIGH: o_word <= CYCLE_32[31:16];
            `HG_IDENTITY_WIDTH_BITS:     o_word <= WIDTH_BITS[15:0];
            `HG_IDENTITY_FOCI:           o_word <= FOCI[15:0];
            `HG_IDENTITY_MODULATION_WORDS: o_word <= SAMPLE_WORDS[15:0];
            default:                     o_word <= NAME[{i_address[2:0], 4'd0} +: 16];
        endcase else case (i_address)
            `HG_STATUS_FLAGS:            o_word <= {10'd0, i_waiting, i_modulated, i_stopped, i_mode, i_enabled};
            `HG_STATUS_PRESENT_INDEX:    o_word <= i_present_index;
            `HG_STATUS_UNDERRUNS:        o_word <= underruns_q;
            `HG_STATUS_REFUSED_RECORDS:  o_word <= records_refused_q;
            `HG_STATUS_FRAMES_GOOD:      o_word <= good_q;
            `HG_STATUS_FRAMES_DAMAGED:   o_word <= damaged_q;
            `HG_STATUS_FRAMES_REPEATED:  o_word <= repeated_q;
            `HG_STATUS_WATCHDOG_TRIPS:   o_word <= watchdog_q;
            `HG_STATUS_GUARD_TRIPS:      o_word <= guard_q;
            `HG_STATUS_LIVE_LEVEL:       o_word <= i_live_level;
            `HG_STATUS_WATCHDOG_MS:      o_word <= i_watchdog_ms;
            `HG_STATUS_BENT_PERIODS:     o_word <= bent_q;
            `HG_STATUS_FAR_FOCI:         o_word <= far_q;
            `HG_STATUS_SYNC:             o_word <= {12'd0, i_sync};
            `HG_STATUS_SYNC_MISSES:      o_word <= missed_q;
            `HG_STATUS_SYNC_LOSSES:      o_word <= lost_q;
            // Without SCHEDULE nobody may ask for these, and they take no cell.
            `HG_STATUS_LATE_CHANGES:     o_word <= SCHEDULE != 0 ? late_q : refused_q;
            `HG_STATUS_PERIOD_LOW:       o_word <= SCHEDULE != 0 ? period_q[15:0] : refused_q;
            `HG_STATUS_PERIOD_MIDDLE:    o_word <= SCHEDULE != 0 ? period_q[31:16] : refused_q;
            `HG_STATUS_PERIOD_HIGH:      o_word <= SCHEDULE != 0 ? period_q[47:32] : refused_q;
            default:                     o_word <= refused_q;
        endcase
    end
endmodule
`default_nettype wire
