// SPDX-License-Identifier: Apache-2.0
//
// Tells which bytes that come out of datagram_fifo were on their way when something happened at the instrument's side.
//
// At i_mark (strobe or level) all bytes between the PHY and o_clk become old. o_old is high from the next clock on, until the last old byte has been
// taken. A question goes over to the PHY's side. There the end of an arriving frame (i_dv) and SETTLE clocks more are waited for, in which the frame
// is committed or dropped. Then i_start, which is behind all old bytes, is the answer. A PHY without a clock gives no answer, and no new bytes.
// Bytes that come within some 20 clocks of the PHY behind i_mark may count as old, too.
// BITS is that of datagram_fifo. SETTLE: at least the clocks from the last byte of a frame until i_start includes its datagram.
`default_nettype none
module datagram_mark #(
    parameter BITS   = 12,
    parameter SETTLE = 12
) (
    input  wire          i_clk,
    input  wire          i_dv,      // GMII
    input  wire [BITS:0] i_start,   // bytes that were committed
    input  wire          o_clk,
    input  wire          i_mark,
    input  wire [BITS:0] i_taken,   // bytes that were taken
    output wire          o_old
);
    localparam WAIT_BITS = $clog2(SETTLE + 1);
    localparam [WAIT_BITS-1:0] LAST = SETTLE[WAIT_BITS-1:0];
    reg                 asks_q, told_q, wants_q, old_q;
    reg                 low_q;   // no frame comes, or that which came has ended
    reg [WAIT_BITS-1:0] wait_q;
    reg [BITS:0]        place_q;
    wire                asked, answered;
    initial {asks_q, told_q, wants_q, old_q, low_q, wait_q, place_q} = {6+BITS+WAIT_BITS{1'b0}};
    synchronizer #(.RESET_VALUE(1'b0)) there (.clk(i_clk), .rst(1'b0), .i_foreign(asks_q), .o_synchronous(asked));
    synchronizer #(.RESET_VALUE(1'b0)) back  (.clk(o_clk), .rst(1'b0), .i_foreign(told_q), .o_synchronous(answered));

    always @(posedge i_clk) begin
        if (asked == told_q) {low_q, wait_q} <= {(WAIT_BITS+1){1'b0}};
        else if (!low_q) low_q <= !i_dv;
        else if (wait_q != LAST) wait_q <= wait_q + 1'b1;
        else {told_q, place_q} <= {asked, i_start};
    end

    // place_q stays while nothing is asked.
    wire          waits  = wants_q || answered != asks_q;
    wire [BITS:0] behind = i_taken - place_q;
    assign o_old = old_q && (waits || behind[BITS]);
    always @(posedge o_clk) begin
        old_q   <= i_mark || o_old;
        wants_q <= i_mark || (wants_q && answered != asks_q);
        if (wants_q && answered == asks_q) asks_q <= !asks_q;
    end
endmodule
`default_nettype wire
