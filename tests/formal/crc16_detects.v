// SPDX-License-Identifier: Apache-2.0
//
// Proves that the CRC computed a byte at a time equals the one computed a bit at a time, and that it detects every burst of up to
// 16 wrong bits in a frame of any length. The argument for bursts has three steps, each of which is asserted below:
// 1. The CRC is linear, so the CRC of a damaged frame is that of the frame xor that of the error alone, started from 0.
// 2. A burst of 16 bits touches at most 3 bytes, and leaves a state other than 0.
// 3. Bytes without an error never bring a state other than 0 back to 0.
`default_nettype none
module crc16_detects (
    input wire [15:0] i_crc,
    input wire [15:0] i_other_crc,
    input wire [7:0]  i_byte,
    input wire [7:0]  i_other_byte,
    input wire [15:0] i_burst,
    input wire [2:0]  i_offset  // bits before the burst in its first byte
);
    `include "crc16.vh"
    `include "formal/crc16_bitwise.vh"

    wire [23:0] error = {i_burst, 8'd0} >> i_offset;
    wire [15:0] after = crc16(crc16(crc16(16'd0, error[23:16]), error[15:8]), error[7:0]);
    always @(*) begin
        assert (crc16(i_crc, i_byte) == crc16_bitwise(i_crc, i_byte));
        assert ((crc16(i_crc, i_byte) ^ crc16(i_other_crc, i_other_byte)) == crc16(i_crc ^ i_other_crc, i_byte ^ i_other_byte));
        assert (i_burst == 16'd0 || after != 16'd0);
        assert (i_crc == 16'd0 || crc16(i_crc, 8'd0) != 16'd0);
        // A frame followed by its own CRC, high byte first, leaves 0.
        assert (crc16(crc16(i_crc, i_crc[15:8]), i_crc[7:0]) == 16'd0);
        cover (i_burst == 16'h8001 && i_offset == 3'd7);
    end
endmodule
`default_nettype wire
