// SPDX-License-Identifier: Apache-2.0
//
// Marks frames as old that are on their way when something happens: frames that wait, that arrive, and that a network port still holds.
//
// urgent_commands has one of these for each event: outputs go off, a STOP, the end of a session.
// i_event: the event comes from outside of the frames. i_acts: the frame that ends in this clock is the event, so that frames behind it are new.
// i_old: bytes of the port that come in this clock, and later ones while i_old is high, were sent before the last i_event. i_begun: a frame, or a
// byte that may be its first, is arriving. i_near: the frame that has just begun had reached the pin before the event. i_waiting: frames that
// wait, at the end of this clock. o_old is high from the next clock on until the last old frame is done. o_ends strobes in the clock in which o_old
// falls, except after an event that found no frame.
// FRAMES is how many frames can wait at most. BESIDE 0: events are frames only, so that i_event, i_old and i_near are 0.
`default_nettype none
module old_frames #(
    parameter FRAMES = 128,
    parameter BESIDE = 1,
    parameter BITS   = $clog2(FRAMES + 1)  // follows from it
) (
    input  wire            clk,
    input  wire            rst,
    input  wire            i_event,
    input  wire            i_acts,
    input  wire            i_old,
    input  wire            i_begun,
    input  wire            i_near,
    input  wire            i_end,
    input  wire            i_good,   // with i_end: the frame waits from now on
    input  wire            i_done,   // strobe: the first waiting frame is done
    input  wire [BITS-1:0] i_waiting,
    output reg             o_old,
    output wire            o_ends    // strobe
);
    localparam [BITS-1:0] NONE = 0, ONE = 1;

    reg            old_q;   // the arriving frame is old
    reg            held_q;  // the port held old bytes a clock ago
    reg [BITS-1:0] left_q;  // waiting frames up to the last old one
    wire old   = BESIDE != 0 && old_q, held = BESIDE != 0 && held_q;
    wire marks = i_event || i_acts || i_old || (i_good && old);
    wire last  = left_q == ONE && i_done;
    assign o_ends = !marks && (last || (held && left_q == NONE));

    always @(posedge clk) begin
        if (rst) begin
            {old_q, held_q, o_old} <= 3'd0;
            left_q <= NONE;
        end else begin
            old_q  <= !i_end && i_begun && (old_q || i_event || i_old || i_near);
            held_q <= i_old;
            left_q <= marks ? i_waiting : left_q - {{(BITS-1){1'b0}}, i_done && left_q != NONE};
            // Whether an old frame will be left, without the sum in i_waiting.
            o_old  <= marks || !(left_q == NONE || last);
        end
    end

`ifdef FORMAL
    `include "formal/old_frames.vh"
`endif
endmodule
`default_nettype wire
