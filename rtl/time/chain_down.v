// SPDX-License-Identifier: Apache-2.0
//
// Shares the host's serial line with the tiles behind this one: passes frames on to the next tile, and shows this tile's own receiver only
// the frames for this tile.
//
// In a chain each frame begins with two address bytes: 2 · n + 1 for the n-th tile from here, 2 for all, and then the complement of the
// upper seven bits above a 1. A tile counts n down while passing these bytes on, so a tile's number is its place in the chain and need not
// be set. The complement is counted up. It shows damage to one of the two bytes, which no CRC covers. Both counts go from the lowest bit to
// the highest, as the bits of a byte come. Each bit is passed on in its middle, with a new edge, so nothing is stored, and a line through
// many tiles is as good as one of a metre. A byte whose lowest bit is 0 is never counted, so a zero, which ends a frame whatever came
// before, is passed on as a zero.
// Until the frame of nothing but "for all" has come (o_chained), the line belongs to this tile alone, as without a chain, and nothing is
// passed on; so a host finds the tiles one by one. A break ends the chain again, and is passed on.
// STEP is that of uart_rx. The line must have been synchronised.
`default_nettype none
`include "interface.vh"
module chain_down #(
    parameter [19:0] STEP = 20'd20972
) (
    input  wire clk,
    input  wire rst,
    input  wire i_line,     // from the host, or the tile before this one
    input  wire i_break,    // strobe: it has been low for 20 bits
    output wire o_line,     // to this tile's receiver; in a chain half a bit later than i_line
    output wire o_next,     // to the next tile; always half a bit later
    output wire o_chained,
    output wire o_coming    // a frame, whose two first bytes this tile's receiver does not see
);
    localparam [3:0] START = 4'd10, LOWEST = 4'd9, STOP = 4'd1, IDLE = 4'd0;
    localparam [1:0] FIRST = 2'd0, SECOND = 2'd1, THIRD = 2'd2;

    wire [7:0] value;
    wire       sample, valid;
    wire [3:0] bits_left;
    uart_rx #(.STEP(STEP)) receiver (
        .clk(clk), .rst(rst), .i_line(i_line), .o_byte(value), .o_valid(valid), .o_sample(sample), .o_bits_left(bits_left));
    wire unused = &{1'b0, valid};

    reg       chained_q, own_q, next_q;
    reg [1:0] place_q;     // the byte of the frame that comes, from FIRST on; stays at the fourth
    reg       counts_q;    // it is for one tile, so its number is counted
    reg       carry_q;     // of the count, to the next bit
    reg       near_q;      // the first byte was for this tile or for all
    reg       mine_q;      // and the second byte agreed
    wire      header    = place_q == FIRST || place_q == SECOND;
    wire      counted   = bits_left == LOWEST ? i_line : i_line ^ (header && carry_q);
    wire      complete  = sample && bits_left == STOP && i_line;
    wire      misframed = sample && bits_left == STOP && !i_line;

    assign o_chained = chained_q;
    assign o_line    = chained_q ? own_q : i_line;
    assign o_next    = next_q;
    assign o_coming  = !i_line || bits_left != IDLE || place_q != FIRST;

    always @(posedge clk) begin
        if (sample && place_q == FIRST && bits_left == LOWEST) counts_q <= i_line;
        if (sample) carry_q <= bits_left == LOWEST ? i_line && (place_q == FIRST || counts_q)
                             : carry_q && (place_q == FIRST ? !i_line : i_line);
        if (rst) begin
            {chained_q, own_q, next_q, mine_q} <= 4'b0110;
            place_q <= FIRST;
        end else begin
            if (bits_left == IDLE) begin
                // A byte without its stop bit, which may be a break, lasts until the line is high again.
                if (i_line) {own_q, next_q} <= 2'b11;
            end else if (sample) case (bits_left)
                START: if (!i_line) {own_q, next_q} <= {!mine_q, !chained_q};
                STOP: {own_q, next_q} <= {2{i_line}};
                default: {own_q, next_q} <= {i_line || !mine_q, counted || !chained_q};
            endcase
            if (complete) begin
                place_q <= value == 8'd0 ? FIRST : place_q == FIRST ? SECOND : place_q == SECOND ? THIRD : 2'd3;
                near_q  <= value == `HG_CHAIN_NEAR || value == `HG_CHAIN_ALL;
                mine_q  <= value != 8'd0 && (place_q == SECOND ? near_q && value == `HG_CHAIN_COMPLEMENT : mine_q);
                if (value == 8'd0 && place_q == THIRD && mine_q && !counts_q) chained_q <= 1'b1;
            end
            if (misframed) begin
                place_q <= FIRST;
                mine_q  <= 1'b0;
            end
            if (i_break) chained_q <= 1'b0;
        end
    end

`ifdef FORMAL
    `include "formal/chain_down.vh"
`endif
endmodule
`default_nettype wire
