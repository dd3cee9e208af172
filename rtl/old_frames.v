// SPDX-License-Identifier: Apache-2.0
//
// What is on its way when something happens counts as old: the frames that wait, the one that arrives, and what a network port still holds.
// urgent_commands has one of these for each thing that may happen: outputs go off, a STOP, the end of a session.
//
// i_event: it happens beside the frames. i_acts: it happens by the frame that ends in this clock, and what arrives behind that is new. i_old is
// high as long as the port's bytes were sent before the last i_event; so is one that comes in this clock. i_begun: a frame, or a byte that may
// be its first, is arriving; i_near: what has just begun had reached the pin when it happened. i_waiting: frames that wait, at this clock's end. o_old is high from the next clock on until the last old one is
// done; o_ends strobes together with its fall, but for that behind an event that has found nothing.
// FRAMES is how many can wait at most. BESIDE: 0 when it happens by frames alone, so that i_event, i_old and i_near are 0.
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
    input  wire            i_done,   // strobe: the first of those that wait is done
    input  wire [BITS-1:0] i_waiting,
    output reg             o_old,
    output wire            o_ends    // strobe
);
    localparam [BITS-1:0] NONE = 0, ONE = 1;

    reg            old_q;   // the frame that arrives is
    reg            held_q;  // the port had something old
    reg [BITS-1:0] left_q;  // of those that wait, up to and with the last old one
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
            // Whether none will be left, without the sum that i_waiting is.
            o_old  <= marks || !(left_q == NONE || last);
        end
    end

`ifdef FORMAL
    `include "formal/old_frames.vh"
`endif
endmodule
`default_nettype wire
