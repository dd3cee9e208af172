// SPDX-License-Identifier: Apache-2.0
// CRC-16/IBM-3740 as its definition has it: one bit at a time through the shift register. Include inside a module.
function [15:0] crc16_bitwise(input [15:0] crc, input [7:0] data);
    integer i;
    begin
        crc16_bitwise = crc;
        for (i = 7; i >= 0; i = i - 1)
            crc16_bitwise = {crc16_bitwise[14:0], 1'b0} ^ (crc16_bitwise[15] != data[i] ? 16'h1021 : 16'h0000);
    end
endfunction
