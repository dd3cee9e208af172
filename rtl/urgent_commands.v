// SPDX-License-Identifier: Apache-2.0
//
// Lets DISABLE and STOP act as soon as their frame has arrived, and keeps frames that were sent before a switch-off from switching on again.
//
// A hand must not feel anything for the third of a second that 16 answers take on a slow line. So this module looks at the bytes of each frame
// beside frame_receiver. A DISABLE or STOP with a right CRC acts at once, with any sequence number, ahead of waiting frames, and without room for
// it. i_off: something else has switched outputs off, namely a break, the stop input, the watchdog, the guard, loss of SYNC, or a DISABLE that a
// network port has seen. In all these cases the frames that are on their way are old (old_frames.v): they are answered and not carried out.
// o_disable is high from the next clock on until the last old frame has been carried out or refused. o_stop is the same for STOP alone; o_stops
// strobes when o_stop rises and when it falls, because a GATE in between may have been carried out. i_stops is a STOP from the network port.
// i_ends and o_ended are the same for the end of a session. o_heard strobes at each DISABLE or STOP.
// i_coming: the line is not idle, or one of its bytes is on its way here. Bytes that were on the line two clocks before i_off are old, too.
// i_old: bytes that still come out of a network port were sent before the port's last switch-off (bit 0), STOP (1), or end of a session (2).
// FRAMES is how many frames can wait at most. NET is the core's; without it i_stops, i_ends and i_old are 0.
`default_nettype none
`include "interface.vh"
module urgent_commands #(
    parameter FRAMES = 128,
    parameter NET    = 0
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_coming,
    input  wire       i_arrives,   // strobe: a byte of the line, also a code byte of COBS
    input  wire       i_valid,     // bytes of a frame, from cobs_decoder
    input  wire [7:0] i_byte,
    input  wire       i_end,
    input  wire       i_right,     // with i_end, from frame_receiver: its CRC is right
    input  wire       i_good,      // and it has been kept
    input  wire       i_done,      // strobe from command_unit: one more frame was carried out or refused
    input  wire       i_off,       // outputs are switched off
    input  wire       i_stops,     // strobe
    input  wire       i_ends,      // strobe
    input  wire [2:0] i_old,
    output wire       o_disable,
    output wire       o_stop,
    output reg        o_stops,     // strobe
    output wire       o_ended,
    output reg        o_heard      // strobe
);
    localparam BITS = $clog2(FRAMES + 1);

    reg [2:0] count_q;      // bytes of this frame so far; 5 is more than these commands have, with their CRC
    reg       disables_q, stops_q;
    reg       begun_q;      // a frame is arriving
    reg [1:0] off_q;        // outputs were switched off a clock ago, and two
    reg [BITS-1:0] waiting_q;  // frames that have arrived and are not done
    wire [BITS-1:0] waiting_d = waiting_q + {{(BITS-1){1'b0}}, i_good} - {{(BITS-1){1'b0}}, i_done};
    wire acts  = i_right && count_q == 3'd4 && (disables_q || stops_q);
    wire begun = begun_q || i_arrives || i_coming;
    wire stop_ends, unused_ends, unused_off_ends;
    wire unused = &{1'b0, unused_ends, unused_off_ends};

    old_frames #(.FRAMES(FRAMES)) off (
        .clk(clk), .rst(rst), .i_event(i_off), .i_acts(acts && disables_q), .i_old(i_old[0]), .i_near(i_coming && !begun_q && off_q != 2'b00),
        .i_begun(begun), .i_end(i_end), .i_good(i_good), .i_done(i_done), .i_waiting(waiting_d), .o_old(o_disable), .o_ends(unused_off_ends));
    old_frames #(.FRAMES(FRAMES), .BESIDE(NET)) stop (
        .clk(clk), .rst(rst), .i_event(i_stops), .i_acts(acts && stops_q), .i_old(i_old[1]), .i_near(1'b0),
        .i_begun(begun), .i_end(i_end), .i_good(i_good), .i_done(i_done), .i_waiting(waiting_d), .o_old(o_stop), .o_ends(stop_ends));
    generate
        if (NET != 0) begin : with_port
            old_frames #(.FRAMES(FRAMES)) session (
                .clk(clk), .rst(rst), .i_event(i_ends), .i_acts(1'b0), .i_old(i_old[2]), .i_near(1'b0),
                .i_begun(begun), .i_end(i_end), .i_good(i_good), .i_done(i_done), .i_waiting(waiting_d), .o_old(o_ended), .o_ends(unused_ends));
        end else begin : without_port
            assign {o_ended, unused_ends} = 2'b00;
            wire unused_port = &{1'b0, i_ends, i_old[2]};
        end
    endgenerate

    always @(posedge clk) begin
        if (i_valid && count_q == 3'd1) {disables_q, stops_q} <= {i_byte == `HG_COMMAND_DISABLE, i_byte == `HG_COMMAND_STOP};
        if (rst) begin
            count_q <= 3'd0;
            {begun_q, off_q, o_stops, o_heard} <= 5'd0;
            waiting_q <= {BITS{1'b0}};
        end else begin
            if (i_end) count_q <= 3'd0;
            else if (i_valid && count_q != 3'd5) count_q <= count_q + 1'b1;
            begun_q   <= !i_end && (begun_q || i_arrives);
            off_q     <= {off_q[0], i_off};
            waiting_q <= waiting_d;
            o_stops   <= i_stops || (acts && stops_q) || stop_ends;
            o_heard   <= acts || i_stops;
        end
    end

`ifdef FORMAL
    `include "formal/urgent_commands.vh"
`endif
endmodule
`default_nettype wire
