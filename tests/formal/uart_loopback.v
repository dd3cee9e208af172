// SPDX-License-Identifier: Apache-2.0
//
// Proves that uart_rx receives each byte that uart_tx sends, once, also when their baud rates differ a little. Bytes
// are sent without a pause, which is the hardest case: both bit clocks start anew with every start bit.
`default_nettype none
module uart_loopback #(
    parameter TX_STEP = 131072,
    parameter RX_STEP = 131072
) (
    input wire       clk,
    input wire       rst,
    input wire [7:0] i_byte
);
    wire       line, ready, valid;
    wire [7:0] received;
    uart_tx #(.STEP(TX_STEP)) transmitter (.clk(clk), .rst(rst), .i_valid(1'b1), .o_ready(ready), .i_byte(i_byte), .o_line(line));
    uart_rx #(.STEP(RX_STEP)) receiver (.clk(clk), .rst(rst), .i_line(line), .o_byte(received), .o_valid(valid));

    reg       f_reset_seen_q, f_pending_q;
    reg [7:0] f_byte_q;
    reg [1:0] f_received_q;
    initial f_reset_seen_q = 1'b0;
    always @(posedge clk) begin
        f_reset_seen_q <= 1'b1;
        assume (rst == !f_reset_seen_q);
        if (rst) {f_pending_q, f_received_q} <= 3'd0;
        else begin
            if (valid) {f_pending_q, f_received_q} <= {1'b0, f_received_q + 2'd1};
            if (ready) {f_pending_q, f_byte_q} <= {1'b1, i_byte};
            assert (!valid || (f_pending_q && received == f_byte_q));
            assert (!ready || !f_pending_q);
            cover (valid && received == 8'h00 && f_received_q == 2'd0);
            cover (valid && received == 8'h5a && f_received_q == 2'd0);
        end
    end
endmodule
`default_nettype wire
