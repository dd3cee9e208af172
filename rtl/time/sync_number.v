// SPDX-License-Identifier: Apache-2.0
//
// Gives the carrier periods of all boards the same numbers: the master's, a bit of them in every period, over SYNC.
//
// A message takes 64 periods. It begins with a mark, in a period whose number is a multiple of 64. Then come the upper 42 bits of
// that number, highest first, their parity (even, with it), and zeros. A board that knows nothing knows the number after one message,
// and its next one confirms it. A number that was confirmed is given up only after two messages in a row that say another one.
// Master: o_symbol is what carrier_sync sends for the period after i_count. Slave: i_valid strobes in a period's last clock, with
// the symbol of the next one; o_load then makes the present one's number o_value, which period_count takes before its next step.
// i_count is period_count's; it changes within 16 clocks of a period's start, and not in the clock of i_valid.
`default_nettype none
module sync_number (
    input  wire        clk,
    input  wire        rst,
    input  wire [47:0] i_count,
    output wire [1:0]  o_symbol,
    input  wire        i_valid,
    input  wire [1:0]  i_symbol,   // 0 and 1: a bit, 2: the mark, 3: nothing was heard
    output wire        o_load,
    output wire [47:0] o_value,
    output reg         o_agreed    // a whole message has confirmed the count
);
    localparam [5:0] PARITY = 6'd43;

    // ---- Master

    wire [5:0]  next = i_count[5:0] + 1'b1;
    // Bit 47 belongs to place 1, bit 6 to place 42.
    wire [47:0] word = {i_count[47:6], ^i_count[47:6], 5'd0};
    wire [63:0] bits = {1'b0, word, 15'd0};  // by place, the first at the left
    assign o_symbol = next == 6'd0 ? 2'd2 : {1'b0, bits[~next]};

    // ---- Slave

    reg        within_q;  // a message has begun, and nothing was wrong in it so far
    reg [5:0]  place_q;   // that the next symbol has in it
    reg [41:0] upper_q;
    reg        odd_q;     // so far
    wire       bit_now = i_symbol[0];
    wire       is_bit  = !i_symbol[1];
    wire       fits    = within_q && is_bit && place_q != 6'd0 && (place_q < PARITY || (place_q == PARITY ? bit_now == odd_q : !bit_now));
    wire       whole   = i_valid && fits && place_q == PARITY;
    wire       agrees  = i_count == o_value;
    assign o_value = {upper_q, PARITY - 6'd1};
    assign o_load  = whole && !agrees && !o_agreed;
    always @(posedge clk) begin
        if (rst) {within_q, o_agreed} <= 2'b00;
        else if (i_valid) begin
            within_q <= i_symbol == 2'd2 || fits;
            if (whole) o_agreed <= agrees;
        end
        if (i_valid) begin
            place_q <= i_symbol == 2'd2 ? 6'd1 : place_q + 1'b1;
            odd_q   <= i_symbol != 2'd2 && odd_q ^ bit_now;
            if (place_q < PARITY) upper_q <= {upper_q[40:0], bit_now};
        end
    end

`ifdef FORMAL
    `include "formal/sync_number.vh"
`endif
endmodule
`default_nettype wire
