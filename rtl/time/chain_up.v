// SPDX-License-Identifier: Apache-2.0
//
// Shares the line to the host with the tiles behind this one: sends this tile's answers and theirs, one whole frame after another.
//
// In a chain (i_chained) each frame begins with the two bytes that chain_down.v describes. This tile's own frames have those of the nearest
// tile; the bytes of frames from the next tile are counted up as they pass, so the host learns which tile answers. Frames from the next
// tile go first, because only this tile's own answers can wait: an own frame begins when no other frame is there, and bytes that come
// meanwhile are kept in a FIFO. A frame from the next tile that stops in its middle, for example because that tile is switched off, is
// ended after 24 bits of silence, so the line is free again.
// Without a chain, bytes go through in the clock in which they come, and the next tile is not listened to.
// STEP is that of uart_rx, BIT_CLOCKS the length of a bit in clocks. BYTES is the size of the FIFO: a power of two, more than the longest
// frame of this tile and the two bytes before it; lines of equal rate then never fill it. A byte too many is dropped, and its frame is
// damaged.
`default_nettype none
`include "interface.vh"
module chain_up #(
    parameter [19:0] STEP = 20'd20972,
    parameter BIT_CLOCKS = 50,
    parameter BYTES = 512
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_chained,
    input  wire       i_next,    // the line from the next tile, synchronous to clk
    input  wire       i_valid,   // this tile's answers, each with a zero at its end
    output wire       o_ready,
    input  wire [7:0] i_byte,
    output wire       o_valid,   // to the transmitter
    input  wire       i_ready,
    output wire [7:0] o_byte
);
    localparam BITS = $clog2(BYTES);
    localparam [BITS:0] ONE = 1;
    localparam QUIET_CLOCKS = 24 * BIT_CLOCKS;
    localparam QUIET_BITS = $clog2(QUIET_CLOCKS + 1);
    localparam [QUIET_BITS-1:0] QUIET = QUIET_CLOCKS[QUIET_BITS-1:0];
    localparam [1:0] NOBODY = 2'd0, OWN = 2'd1, NEXT = 2'd2, CUT = 2'd3;

    // ---- What comes from the next tile

    wire       arrives, unused_sample;
    wire [7:0] arrived;
    wire [3:0] unused_bits;
    uart_rx #(.STEP(STEP)) receiver (
        .clk(clk), .rst(rst), .i_line(i_next), .o_byte(arrived), .o_valid(arrives), .o_sample(unused_sample), .o_bits_left(unused_bits));
    wire unused = &{1'b0, unused_sample, unused_bits};

    (* no_rw_check *) reg [7:0] kept [0:BYTES-1];  // a byte is never read in the clock in which it is written
    reg [BITS:0] write_q, read_q;
    reg [7:0]    next_byte_q;
    reg          has_next_q;
    wire         takes_next;
    wire [BITS:0] used = write_q - read_q;
    wire         keeps = arrives && i_chained && !used[BITS];
    wire         waits = write_q != read_q;

    always @(posedge clk) begin
        if (keeps) kept[write_q[BITS-1:0]] <= arrived;
        next_byte_q <= kept[read_q[BITS-1:0]];
        has_next_q  <= !rst && i_chained && !takes_next && waits;
        if (rst || !i_chained) begin
            write_q <= {(BITS+1){1'b0}};
            read_q  <= {(BITS+1){1'b0}};
        end else begin
            if (keeps) write_q <= write_q + ONE;
            if (takes_next) read_q <= read_q + ONE;
        end
    end

    // ---- Whose frame is on the line

    reg [1:0] owner_q;
    reg [1:0] place_q;   // the byte of the frame that comes next; stays at the third
    reg       counts_q;  // its number is counted
    reg [QUIET_BITS-1:0] quiet_q;
    wire      heads = owner_q == OWN && !place_q[1];
    wire      goes  = o_valid && i_ready;
    wire [7:0] counted = place_q == 2'd0 ? next_byte_q + {6'd0, next_byte_q[0], 1'b0}
                       : place_q == 2'd1 ? next_byte_q - {6'd0, counts_q && next_byte_q[0], 1'b0} : next_byte_q;

    assign o_valid = !i_chained ? i_valid : owner_q == OWN ? heads || i_valid : owner_q == NEXT ? has_next_q : owner_q == CUT;
    assign o_byte  = !i_chained ? i_byte
                   : owner_q == OWN ? (!heads ? i_byte : place_q[0] ? `HG_CHAIN_COMPLEMENT : `HG_CHAIN_NEAR)
                   : owner_q == NEXT ? counted : 8'd0;
    assign o_ready = i_ready && (!i_chained || (owner_q == OWN && !heads));
    assign takes_next = goes && i_chained && owner_q == NEXT;

    // A zero ends a frame wherever it stands, so it is not counted.
    always @(posedge clk) begin
        if (goes && place_q == 2'd0) counts_q <= next_byte_q[0];
        quiet_q <= owner_q != NEXT || has_next_q || !i_ready ? QUIET : quiet_q - 1'b1;
        if (rst || !i_chained) begin
            owner_q <= NOBODY;
            place_q <= 2'd0;
        end else if (owner_q == NOBODY) begin
            owner_q <= waits ? NEXT : i_valid ? OWN : NOBODY;
            place_q <= 2'd0;
        end else if (goes) begin
            if (!place_q[1]) place_q <= place_q + 1'b1;
            if (o_byte == 8'd0) owner_q <= NOBODY;
        end else if (owner_q == NEXT && quiet_q == {QUIET_BITS{1'b0}}) owner_q <= CUT;
    end
endmodule
`default_nettype wire
