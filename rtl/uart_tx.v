// SPDX-License-Identifier: Apache-2.0
//
// Sends bytes over a serial line: 8 data bits, no parity, 1 stop bit.
//
// The bytes come on a valid/ready stream; o_ready is high between bytes. A byte's start bit begins one clock after it is taken.
// STEP is 2^20 · baud / clock, rounded, as in uart_rx.
`default_nettype none
module uart_tx #(
    parameter [19:0] STEP = 20'd20972
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_valid,
    output wire       o_ready,
    input  wire [7:0] i_byte,
    output reg        o_line
);
    reg [19:0] phase_q;
    reg [3:0]  bits_left_q;
    reg [8:0]  shift_q;  // data, then the stop bit
    wire [20:0] phase_d = {1'b0, phase_q} + {1'b0, STEP};

    assign o_ready = bits_left_q == 4'd0;

    initial o_line = 1'b1;
    always @(posedge clk) begin
        if (rst) begin
            o_line      <= 1'b1;
            bits_left_q <= 4'd0;
        end else if (o_ready) begin
            phase_q <= 20'd0;
            if (i_valid) begin
                o_line      <= 1'b0;
                shift_q     <= {1'b1, i_byte};
                bits_left_q <= 4'd10;
            end
        end else begin
            phase_q <= phase_d[19:0];
            if (phase_d[20]) begin
                bits_left_q       <= bits_left_q - 1'b1;
                {shift_q, o_line} <= {1'b1, shift_q};
            end
        end
    end
endmodule
`default_nettype wire
