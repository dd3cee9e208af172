// SPDX-License-Identifier: Apache-2.0
//
// Lets DISABLE and STOP act as soon as their frame has arrived, although frames ahead of it may still wait for their answers. A
// hand must not feel anything for the third of a second that 16 answers take on a slow line.
//
// It looks at the bytes of each frame beside frame_receiver. o_disable or o_stop rises one clock after a good frame with that
// command, and stays until command_unit has carried that frame out or refused it; a command that was sent before it, and that
// comes to its turn meanwhile, then cannot switch anything on again. A frame that was applied before does nothing again: its
// sequence number lies behind i_expected. Before a session there are no numbers to compare, so then every frame counts.
// FRAMES is how many frames can wait at most.
`default_nettype none
`include "interface.vh"
module urgent_commands #(
    parameter FRAMES = 128
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_valid,     // bytes of a frame, from cobs_decoder
    input  wire [7:0] i_byte,
    input  wire       i_end,
    input  wire       i_good,      // strobe from frame_receiver, with i_end
    input  wire       i_done,      // strobe from command_unit: one more frame was carried out or refused
    input  wire       i_session,
    input  wire [7:0] i_expected,  // the sequence number that would be applied next
    output reg        o_disable,
    output reg        o_stop
);
    localparam BITS = $clog2(FRAMES + 1);
    localparam [BITS-1:0] NONE = 0, ONE = 1;

    reg [2:0] count_q;      // bytes of this frame so far; 5 is more than these commands have, with their CRC
    reg       new_q;        // it has not been applied before
    reg       disables_q, stops_q;
    reg [BITS-1:0] waiting_q;  // frames that have arrived and are not done
    reg [BITS-1:0] disable_left_q, stop_left_q;  // of those, up to and with the last DISABLE, the last STOP
    wire [7:0] ahead = i_byte - i_expected;
    wire       unused = &{1'b0, ahead[6:0]};
    wire [BITS-1:0] waiting_d = waiting_q + {{(BITS-1){1'b0}}, i_good} - {{(BITS-1){1'b0}}, i_done};
    wire       urgent = i_good && count_q == 3'd4 && new_q;

    always @(posedge clk) begin
        if (i_valid && count_q == 3'd0) new_q <= !i_session || !ahead[7];
        if (i_valid && count_q == 3'd1) {disables_q, stops_q} <= {i_byte == `HG_COMMAND_DISABLE, i_byte == `HG_COMMAND_STOP};
        if (rst) begin
            count_q <= 3'd0;
            {o_disable, o_stop} <= 2'b00;
            {waiting_q, disable_left_q, stop_left_q} <= {3*BITS{1'b0}};
        end else begin
            if (i_end) count_q <= 3'd0;
            else if (i_valid && count_q != 3'd5) count_q <= count_q + 1'b1;
            waiting_q <= waiting_d;

            if (urgent && disables_q) {o_disable, disable_left_q} <= {1'b1, waiting_d};
            else if (i_done && disable_left_q != NONE) begin
                disable_left_q <= disable_left_q - ONE;
                if (disable_left_q == ONE) o_disable <= 1'b0;
            end

            if (urgent && stops_q) {o_stop, stop_left_q} <= {1'b1, waiting_d};
            else if (i_done && stop_left_q != NONE) begin
                stop_left_q <= stop_left_q - ONE;
                if (stop_left_q == ONE) o_stop <= 1'b0;
            end
        end
    end

`ifdef FORMAL
    `include "formal/urgent_commands.vh"
`endif
endmodule
`default_nettype wire
