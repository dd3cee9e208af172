// SPDX-License-Identifier: Apache-2.0
// One byte of the frame check sequence of IEEE 802.3 (3.2.9), least significant bit first; begin with all ones. Over a frame followed by
// its own FCS the result is 32'hdebb20e3; what is sent is the complement, low byte first. Include inside a module.
function [31:0] crc32(input [31:0] crc, input [7:0] data);
    integer k;
    begin
        crc32 = crc ^ {24'd0, data};
        for (k = 0; k < 8; k = k + 1) crc32 = {1'b0, crc32[31:1]} ^ (crc32[0] ? 32'hedb88320 : 32'd0);
    end
endfunction
