// SPDX-License-Identifier: Apache-2.0
//
// Receives bytes from a serial line: 8 data bits, no parity, 1 stop bit.
//
// o_valid strobes in the middle of a good stop bit. A byte whose stop bit is low is dropped. The bit clock is a 20-bit phase
// accumulator, so that the baud rate need not divide the clock. The line must have been synchronised.
// STEP is 2^20 · baud / clock, rounded; the rate is then off by less than 2^-21 of the clock rate, 24 Hz at 50 MHz. A bit must
// have at least 8 clocks, so that its middle is found.
`default_nettype none
module uart_rx #(
    parameter [19:0] STEP = 20'd20972
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_line,  // synchronous to clk
    output reg  [7:0] o_byte,
    output reg        o_valid,
    output wire       o_sample,     // strobe, in the middle of a bit: the line is read now
    output wire [3:0] o_bits_left   // 10 for the start bit, 9 to 2 for data, 1 for the stop bit; 0 between bytes
);
    localparam [19:0] HALF_BIT = 20'h80000;

    reg [19:0] phase_q;
    reg [3:0]  bits_left_q;  // 10 until the middle of the start bit; 0 when idle
    reg        high_seen_q;  // the line has been high, so that low now is a falling edge
    wire [20:0] phase_d = {1'b0, phase_q} + {1'b0, STEP};

    assign o_sample    = bits_left_q != 4'd0 && phase_d[20];
    assign o_bits_left = bits_left_q;

    always @(posedge clk) begin
        o_valid <= 1'b0;
        if (rst) begin
            bits_left_q <= 4'd0;
            high_seen_q <= 1'b0;
        end else if (bits_left_q == 4'd0) begin
            phase_q     <= HALF_BIT;
            high_seen_q <= i_line;
            if (high_seen_q && !i_line) bits_left_q <= 4'd10;
        end else begin
            phase_q <= phase_d[19:0];
            if (phase_d[20]) begin
                bits_left_q <= bits_left_q - 1'b1;
                high_seen_q <= i_line;
                if (bits_left_q == 4'd10 && i_line) bits_left_q <= 4'd0;  // too short for a start bit
                else if (bits_left_q == 4'd1) o_valid <= i_line;
                else o_byte <= {i_line, o_byte[7:1]};
            end
        end
    end
endmodule
`default_nettype wire
