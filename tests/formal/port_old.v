// SPDX-License-Identifier: Apache-2.0
//
// Proves of a network port that what is anywhere in it, or arriving, when something happens comes out as old. One byte of one frame, any one, is
// followed from the PHY on. The PHY's clock and the instrument's are free: any ratio, and each may stop at any time, for as long as it likes.
`default_nettype none
module port_old #(
    parameter BITS   = 2,
    parameter SETTLE = 2
) (
    input wire          eth_clk,
    input wire          clk,
    input wire          dv,      // a frame comes from the PHY
    input wire          pick,    // it is the one that is followed
    input wire          commit,  // it is good, and has so many bytes for the instrument
    input wire [BITS:0] bytes,
    input wire [BITS:0] which,   // the byte of it that is followed
    input wire          mark,
    input wire          take
);
    localparam [BITS:0] ROOM = 1 << BITS, ONE = 1;
    localparam [3:0] LAST = SETTLE[3:0];
    reg          dv_q, begun_q, ended_q, here_q, since_q, mark_q, take_q, was_old_q, new_q, gone_q, chosen_q, last_q;
    // begun_q: that frame arrives; last_q: it has ended; here_q: it was committed
    reg [3:0]    age_q;      // clocks since a frame's end
    reg [BITS:0] start_q, taken_q, place_q;
    initial {dv_q, ended_q, begun_q, here_q, since_q, mark_q, take_q, was_old_q, new_q, gone_q, chosen_q, last_q, age_q, start_q, taken_q, place_q} = 0;
    wire old;
    datagram_mark #(.BITS(BITS), .SETTLE(SETTLE)) dut (
        .i_clk(eth_clk), .i_dv(dv_q), .i_start(start_q), .o_clk(clk), .i_mark(mark_q), .i_taken(taken_q), .o_old(old));

    // A frame is committed at most so many clocks behind its end, when the next may have begun, or not at all.
    wire commits = ended_q && commit;
    wire comes   = take_q && taken_q != start_q;
    always @(posedge eth_clk) begin
        dv_q <= dv;
        if (dv && !dv_q && pick && !chosen_q) {begun_q, chosen_q} <= 2'b11;
        if (dv_q && !dv) {ended_q, last_q, begun_q, age_q} <= {1'b1, begun_q, 5'd0};
        else if (commits || age_q == LAST - 4'd1) {ended_q, last_q} <= 2'b00;
        else age_q <= age_q + 4'd1;
        if (commits) start_q <= start_q + bytes;
        if (commits && last_q && which < bytes) {here_q, place_q} <= {1'b1, start_q + which};
    end
    always @(posedge clk) begin
        {mark_q, take_q} <= {mark, take};
        if (comes) taken_q <= taken_q + ONE;
        if (mark_q && (begun_q || last_q || here_q)) since_q <= 1'b1;
        if (here_q && comes && taken_q == place_q) gone_q <= 1'b1;
        if (here_q && since_q && comes && taken_q == place_q && !gone_q) assert (old);
        was_old_q <= was_old_q || (old && comes);
        new_q     <= new_q || (was_old_q && comes && !old);
        cover (here_q && since_q && comes && taken_q == place_q);
        cover (new_q);
    end
    (* gclk *) reg time_q;
    always @(posedge time_q) begin
        assume (start_q - taken_q <= ROOM);
        assume (!(ended_q && dv_q && !dv));  // a frame is longer than that
        assume (bytes <= ROOM && (!commits || {1'b0, start_q - taken_q} + {1'b0, bytes} <= {1'b0, ROOM}));
    end
endmodule
`default_nettype wire
