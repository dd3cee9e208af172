// SPDX-License-Identifier: Apache-2.0
//
// Sees a DISABLE or STOP in a datagram as it comes, so that it acts at the datagram's end, also when there is no room for it, or much ahead of it.
//
// i_byte is the payload, from a frame's beginning on and with a zero at its end. Two clocks behind the last byte of such a frame, with the right
// CRC, o_disable or o_stop is high, until i_gone: the datagram is over, or was none.
`default_nettype none
`include "interface.vh"
module early_commands (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_write,
    input  wire [7:0] i_byte,
    input  wire       i_gone,
    output reg        o_disable,
    output reg        o_stop
);
    `include "crc16.vh"
    wire       valid, ends, intact;
    wire [7:0] data;
    reg        valid_q, ends_q, intact_q, disables_q, stops_q;
    reg [7:0]  data_q;
    reg [2:0]  count_q;  // bytes of the frame; 5 is more than these commands have, with their CRC
    reg [15:0] crc_q;
    wire       anew = rst || i_gone;
    cobs_decoder decoder (
        .clk(clk), .rst(anew), .i_valid(i_write), .i_byte(i_byte), .i_break(1'b0),
        .o_valid(valid), .o_byte(data), .o_end(ends), .o_intact(intact));

    initial {valid_q, ends_q, o_disable, o_stop} = 4'd0;
    always @(posedge clk) begin
        {valid_q, ends_q} <= anew ? 2'b00 : {valid, ends};
        {data_q, intact_q} <= {data, intact};
        if (anew || ends_q) {count_q, crc_q} <= {3'd0, 16'hffff};
        else if (valid_q) begin
            crc_q <= crc16(crc_q, data_q);
            if (count_q != 3'd5) count_q <= count_q + 3'd1;
        end
        if (valid_q && count_q == 3'd1) {disables_q, stops_q} <= {data_q == `HG_COMMAND_DISABLE, data_q == `HG_COMMAND_STOP};
        if (anew) {o_disable, o_stop} <= 2'b00;
        else if (ends_q && intact_q && count_q == 3'd4 && crc_q == 16'd0) {o_disable, o_stop} <= {o_disable || disables_q, o_stop || stops_q};
    end
endmodule
`default_nettype wire
