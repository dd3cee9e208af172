// SPDX-License-Identifier: Apache-2.0
// One byte of CRC-16/IBM-3740 (polynomial 0x1021, most significant bit first). Over a frame followed by its own CRC, high
// byte first, the result is 0. Include inside a module.
function [15:0] crc16(input [15:0] crc, input [7:0] data);
    reg [7:0] folded;
    begin
        folded = crc[15:8] ^ data;
        folded = folded ^ {4'd0, folded[7:4]};
        crc16  = {crc[7:0], 8'd0} ^ {folded[3:0], 12'd0} ^ {3'd0, folded, 5'd0} ^ {8'd0, folded};
    end
endfunction
