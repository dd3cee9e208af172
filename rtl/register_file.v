// SPDX-License-Identifier: Apache-2.0
//
// The identity and status blocks of the address space: what this instrument is, what it does now, and counters of events.
//
// A host reads them to learn what it may send, and to see what went wrong. o_word follows i_read by one clock. The counters run
// modulo 65,536 and start at 0 after reset.
// SCHEDULE and STREAM are the core's.
`default_nettype none
`include "interface.vh"
module register_file #(
    parameter SCHEDULE = 0,
    parameter STREAM   = 0
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_read,
    input  wire        i_is_identity,
    input  wire [4:0]  i_address,  // number of the word
    input  wire [15:0] i_identity_word,  // that one of identity_block
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
    input  wire [3:0]  i_stream,    // repeated, early, lost, late
    input  wire        i_waiting,
    input  wire        i_streaming,
    input  wire [1:0]  i_flash,
    input  wire        i_answer,    // strobe: a reply begins, and the period that it tells is the present one
    input  wire [47:0] i_period
);
    reg [15:0] underruns_q, records_refused_q, good_q, damaged_q, repeated_q, refused_q, watchdog_q, guard_q, bent_q, far_q, missed_q, lost_q, late_q;
    reg [47:0] period_q;
    always @(posedge clk) if (i_answer) period_q <= i_period;
    reg [15:0] stream_late_q, stream_lost_q, stream_early_q, stream_repeated_q;
    always @(posedge clk) begin
        if (rst) {stream_late_q, stream_lost_q, stream_early_q, stream_repeated_q} <= 64'd0;
        else if (i_stream != 4'd0) begin
            stream_late_q     <= stream_late_q + {15'd0, i_stream[0]};
            stream_lost_q     <= stream_lost_q + {15'd0, i_stream[1]};
            stream_early_q    <= stream_early_q + {15'd0, i_stream[2]};
            stream_repeated_q <= stream_repeated_q + {15'd0, i_stream[3]};
        end
    end
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
        if (i_is_identity) o_word <= i_identity_word;
        else case (i_address)
            `HG_STATUS_FLAGS:            o_word <= {7'd0, i_flash, i_streaming, i_waiting, i_modulated, i_stopped, i_mode, i_enabled};
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
            `HG_STATUS_STREAM_LATE:      o_word <= STREAM != 0 ? stream_late_q : refused_q;
            `HG_STATUS_STREAM_LOST:      o_word <= STREAM != 0 ? stream_lost_q : refused_q;
            `HG_STATUS_STREAM_EARLY:     o_word <= STREAM != 0 ? stream_early_q : refused_q;
            `HG_STATUS_STREAM_REPEATED:  o_word <= STREAM != 0 ? stream_repeated_q : refused_q;
            default:                     o_word <= refused_q;
        endcase
    end
endmodule
`default_nettype wire
