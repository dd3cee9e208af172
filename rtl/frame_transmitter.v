// SPDX-License-Identifier: Apache-2.0
//
// Turns a reply of 16-bit words into bytes and appends their CRC.
//
// It stands before cobs_encoder, so that the CRC covers the plain bytes. Both sides are valid/ready streams; i_last marks the
// reply's last word, o_last the last byte of the CRC. A word is sent low byte first, the CRC high byte first. A byte is offered
// in the clock in which its word is. It has no parameters.
`default_nettype none
module frame_transmitter (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_valid,
    output wire        o_ready,
    input  wire [15:0] i_word,
    input  wire        i_last,
    output wire        o_valid,
    input  wire        i_ready,
    output wire [7:0]  o_byte,
    output wire        o_last
);
    localparam [1:0] LOW = 2'd0, HIGH = 2'd1, CRC_HIGH = 2'd2, CRC_LOW = 2'd3;

    reg [1:0]   state_q;
    reg [15:0]  crc_q;
    wire        from_word = state_q == LOW || state_q == HIGH;
    wire [7:0]  word_byte = state_q == LOW ? i_word[7:0] : i_word[15:8];

    `include "crc16.vh"

    assign o_valid = !from_word || i_valid;
    assign o_byte  = state_q == CRC_HIGH ? crc_q[15:8] : state_q == CRC_LOW ? crc_q[7:0] : word_byte;
    assign o_last  = state_q == CRC_LOW;
    assign o_ready = state_q == HIGH && i_ready;

    always @(posedge clk) begin
        if (rst) begin
            state_q <= LOW;
            crc_q   <= 16'hffff;
        end else if (o_valid && i_ready) begin
            if (from_word) crc_q <= crc16(crc_q, word_byte);
            case (state_q)
                LOW:      state_q <= HIGH;
                HIGH:     state_q <= i_last ? CRC_HIGH : LOW;
                CRC_HIGH: state_q <= CRC_LOW;
                default: begin
                    state_q <= LOW;
                    crc_q   <= 16'hffff;
                end
            endcase
        end
    end
endmodule
`default_nettype wire
