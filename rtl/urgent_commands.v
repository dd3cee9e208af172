// SPDX-License-Identifier: Apache-2.0
//
// Lets DISABLE and STOP act as soon as their frame has arrived, and keeps what was sent before any switch-off from switching on again.
//
// A hand must not feel anything for the third of a second that 16 answers take on a slow line. So this looks at the bytes of each
// frame beside frame_receiver: a DISABLE or STOP with a right CRC acts at once, whatever its sequence number, whatever waits, and also
// when there is no room for it. i_off says that something else has switched outputs off: a break, the stop input, the watchdog, the
// guard, loss of SYNC. In each of these cases the frames that wait, and one that is still arriving, count as answered and not as done:
// o_disable is high from the next clock on until the last of them has been carried out or refused. o_stop is the same for STOP alone,
// and o_stops strobes when that begins and when it ends, because a GATE in between may have been carried out. o_heard strobes at each
// DISABLE or STOP. i_stops is a STOP that came another way.
// FRAMES is how many frames can wait at most.
`default_nettype none
`include "interface.vh"
module urgent_commands #(
    parameter FRAMES = 128
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_arrives,   // strobe: a byte of the line, also a code byte of COBS
    input  wire       i_valid,     // bytes of a frame, from cobs_decoder
    input  wire [7:0] i_byte,
    input  wire       i_end,
    input  wire       i_right,     // with i_end, from frame_receiver: its CRC is right
    input  wire       i_good,      // and it has been kept
    input  wire       i_done,      // strobe from command_unit: one more frame was carried out or refused
    input  wire       i_off,       // outputs are switched off
    input  wire       i_stops,     // strobe
    output reg        o_disable,
    output reg        o_stop,
    output reg        o_stops,     // strobe
    output reg        o_heard      // strobe
);
    localparam BITS = $clog2(FRAMES + 1);
    localparam [BITS-1:0] NONE = 0, ONE = 1;

    reg [2:0] count_q;      // bytes of this frame so far; 5 is more than these commands have, with their CRC
    reg       disables_q, stops_q;
    reg       begun_q;      // a frame is arriving
    reg       old_q;        // and outputs were switched off meanwhile
    reg [BITS-1:0] waiting_q;  // frames that have arrived and are not done
    reg [BITS-1:0] disable_left_q, stop_left_q;  // of those, up to and with the last that came before a switch-off, before a STOP
    wire [BITS-1:0] waiting_d = waiting_q + {{(BITS-1){1'b0}}, i_good} - {{(BITS-1){1'b0}}, i_done};
    wire acts  = i_right && count_q == 3'd4 && (disables_q || stops_q);
    wire off   = i_off || (acts && disables_q) || (i_good && old_q);
    wire stops = i_stops || (acts && stops_q);
    wire [BITS-1:0] disable_left_d = off ? waiting_d : disable_left_q - {{(BITS-1){1'b0}}, i_done && disable_left_q != NONE};
    // Whether none will be left, without the sum that waiting_d is.
    wire disable_ends = disable_left_q == NONE || (disable_left_q == ONE && i_done);
    wire stop_ends    = stop_left_q == NONE || (stop_left_q == ONE && i_done);
    wire [BITS-1:0] stop_left_d    = stops ? waiting_d : stop_left_q - {{(BITS-1){1'b0}}, i_done && stop_left_q != NONE};

    always @(posedge clk) begin
        if (i_valid && count_q == 3'd1) {disables_q, stops_q} <= {i_byte == `HG_COMMAND_DISABLE, i_byte == `HG_COMMAND_STOP};
        if (rst) begin
            count_q <= 3'd0;
            {begun_q, old_q, o_disable, o_stop, o_stops, o_heard} <= 6'd0;
            {waiting_q, disable_left_q, stop_left_q} <= {3*BITS{1'b0}};
        end else begin
            if (i_end) count_q <= 3'd0;
            else if (i_valid && count_q != 3'd5) count_q <= count_q + 1'b1;
            begun_q   <= !i_end && (begun_q || i_arrives);
            old_q     <= !i_end && (old_q || (i_off && (begun_q || i_arrives)));
            waiting_q <= waiting_d;
            disable_left_q <= disable_left_d;
            stop_left_q    <= stop_left_d;
            o_disable <= off || !disable_ends;
            o_stop    <= stops || !stop_ends;
            o_stops   <= stops || (stop_left_q == ONE && i_done);
            o_heard   <= acts || i_stops;
        end
    end

`ifdef FORMAL
    `include "formal/urgent_commands.vh"
`endif
endmodule
`default_nettype wire
