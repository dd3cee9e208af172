// SPDX-License-Identifier: Apache-2.0
//
// A block RAM of the ECP5 for simulation, as far as Yosys uses it: 1,024 words of 18 bits, two ports of one clock. Yosys ships only
// the outline of DP16KD; tests/netlist renames the cells of its netlists to this, which is why it has all their pins.
// A port of width 9 has its address from AD3 up, one of 18 from AD4 up and byte enables in AD0 and AD1. Width 36 writes two words
// through both ports' DI, enabled by AD0 to AD3 of port A, and reads them at the address of port B. INITVAL_xx: 16 words each,
// in 20 bits. What a port reads while it writes is the old word, or with WRITEMODE "NORMAL" the one it read before.
`default_nettype none
module dp16kd #(
    parameter [319:0] INITVAL_00 = 0, INITVAL_01 = 0, INITVAL_02 = 0, INITVAL_03 = 0, INITVAL_04 = 0, INITVAL_05 = 0, INITVAL_06 = 0, INITVAL_07 = 0,
    parameter [319:0] INITVAL_08 = 0, INITVAL_09 = 0, INITVAL_0A = 0, INITVAL_0B = 0, INITVAL_0C = 0, INITVAL_0D = 0, INITVAL_0E = 0, INITVAL_0F = 0,
    parameter [319:0] INITVAL_10 = 0, INITVAL_11 = 0, INITVAL_12 = 0, INITVAL_13 = 0, INITVAL_14 = 0, INITVAL_15 = 0, INITVAL_16 = 0, INITVAL_17 = 0,
    parameter [319:0] INITVAL_18 = 0, INITVAL_19 = 0, INITVAL_1A = 0, INITVAL_1B = 0, INITVAL_1C = 0, INITVAL_1D = 0, INITVAL_1E = 0, INITVAL_1F = 0,
    parameter [319:0] INITVAL_20 = 0, INITVAL_21 = 0, INITVAL_22 = 0, INITVAL_23 = 0, INITVAL_24 = 0, INITVAL_25 = 0, INITVAL_26 = 0, INITVAL_27 = 0,
    parameter [319:0] INITVAL_28 = 0, INITVAL_29 = 0, INITVAL_2A = 0, INITVAL_2B = 0, INITVAL_2C = 0, INITVAL_2D = 0, INITVAL_2E = 0, INITVAL_2F = 0,
    parameter [319:0] INITVAL_30 = 0, INITVAL_31 = 0, INITVAL_32 = 0, INITVAL_33 = 0, INITVAL_34 = 0, INITVAL_35 = 0, INITVAL_36 = 0, INITVAL_37 = 0,
    parameter [319:0] INITVAL_38 = 0, INITVAL_39 = 0, INITVAL_3A = 0, INITVAL_3B = 0, INITVAL_3C = 0, INITVAL_3D = 0, INITVAL_3E = 0, INITVAL_3F = 0,
    parameter DATA_WIDTH_A = 18, DATA_WIDTH_B = 18, WRITEMODE_A = "NORMAL", WRITEMODE_B = "NORMAL",
    parameter REGMODE_A = "NOREG", REGMODE_B = "NOREG", RESETMODE = "SYNC", ASYNC_RESET_RELEASE = "SYNC",
    parameter CSDECODE_A = "0b000", CSDECODE_B = "0b000", CLKAMUX = "CLKA", CLKBMUX = "CLKB", GSR = "AUTO"
) (
    input  wire CLKA, CEA, OCEA, RSTA, WEA, CSA0, CSA1, CSA2,
    input  wire ADA0, ADA1, ADA2, ADA3, ADA4, ADA5, ADA6, ADA7, ADA8, ADA9, ADA10, ADA11, ADA12, ADA13,
    input  wire DIA0, DIA1, DIA2, DIA3, DIA4, DIA5, DIA6, DIA7, DIA8, DIA9, DIA10, DIA11, DIA12, DIA13, DIA14, DIA15, DIA16, DIA17,
    output wire DOA0, DOA1, DOA2, DOA3, DOA4, DOA5, DOA6, DOA7, DOA8, DOA9, DOA10, DOA11, DOA12, DOA13, DOA14, DOA15, DOA16, DOA17,
    input  wire CLKB, CEB, OCEB, RSTB, WEB, CSB0, CSB1, CSB2,
    input  wire ADB0, ADB1, ADB2, ADB3, ADB4, ADB5, ADB6, ADB7, ADB8, ADB9, ADB10, ADB11, ADB12, ADB13,
    input  wire DIB0, DIB1, DIB2, DIB3, DIB4, DIB5, DIB6, DIB7, DIB8, DIB9, DIB10, DIB11, DIB12, DIB13, DIB14, DIB15, DIB16, DIB17,
    output wire DOB0, DOB1, DOB2, DOB3, DOB4, DOB5, DOB6, DOB7, DOB8, DOB9, DOB10, DOB11, DOB12, DOB13, DOB14, DOB15, DOB16, DOB17
);
    localparam [20479:0] ROWS = {
        INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39, INITVAL_38,
        INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32, INITVAL_31, INITVAL_30,
        INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C, INITVAL_2B, INITVAL_2A, INITVAL_29, INITVAL_28,
        INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24, INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20,
        INITVAL_1F, INITVAL_1E, INITVAL_1D, INITVAL_1C, INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18,
        INITVAL_17, INITVAL_16, INITVAL_15, INITVAL_14, INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10,
        INITVAL_0F, INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
        INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01, INITVAL_00};
    reg [17:0] words [0:1023];
    integer i;
    initial for (i = 0; i < 1024; i = i + 1) words[i] = ROWS[20*i +: 18];

    wire [13:0] address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
    wire [17:0] in_a = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
    reg  [17:0] out_a;
    assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0} = out_a;
    wire [13:0] address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
    wire [17:0] in_b = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};
    reg  [17:0] out_b;
    assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0} = out_b;

    // A word with those of its halves replaced that are written.
    function [17:0] merged(input [1:0] halves, input [17:0] old, input [17:0] data);
        merged = {halves[1] ? data[17:9] : old[17:9], halves[0] ? data[8:0] : old[8:0]};
    endfunction
    function [17:0] written(input narrow, input [13:0] address, input [17:0] old, input [17:0] data);
        written = narrow ? merged({address[3], !address[3]}, old, {data[8:0], data[8:0]}) : merged(address[1:0], old, data);
    endfunction
    function [17:0] shown(input narrow, input [13:0] address, input [17:0] word);
        shown = !narrow ? word : {9'd0, address[3] ? word[17:9] : word[8:0]};
    endfunction

    generate
        if (DATA_WIDTH_A == 36 && DATA_WIDTH_B == 36) begin : wide
            wire [9:0] low_a = {address_a[13:5], 1'b0}, high_a = {address_a[13:5], 1'b1};
            always @(posedge CLKA) begin
                if (CEA && WEA) words[low_a] <= merged(address_a[1:0], words[low_a], in_a);
                if (CEA && WEA) words[high_a] <= merged(address_a[3:2], words[high_a], in_b);
                if (CEB) {out_b, out_a} <= {words[{address_b[13:5], 1'b1}], words[{address_b[13:5], 1'b0}]};
            end
        end else if ((DATA_WIDTH_A == 9 || DATA_WIDTH_A == 18) && (DATA_WIDTH_B == 9 || DATA_WIDTH_B == 18)) begin : ports
            localparam NARROW_A = DATA_WIDTH_A == 9, NARROW_B = DATA_WIDTH_B == 9;
            wire [9:0] word_a = address_a[13:4], word_b = address_b[13:4];
            always @(posedge CLKA) begin
                if (CEA && WEA) words[word_a] <= written(NARROW_A, address_a, words[word_a], in_a);
                if (CEB && WEB) words[word_b] <= written(NARROW_B, address_b, words[word_b], in_b);
                if (CEA && (!WEA || WRITEMODE_A == "READBEFOREWRITE")) out_a <= shown(NARROW_A, address_a, words[word_a]);
                if (CEB && (!WEB || WRITEMODE_B == "READBEFOREWRITE")) out_b <= shown(NARROW_B, address_b, words[word_b]);
            end
        end else these_widths_are_not_modelled error();
        if (REGMODE_A != "NOREG" || REGMODE_B != "NOREG") output_registers_are_not_modelled error();
        if (CLKAMUX != "CLKA" || CLKBMUX != "CLKB") falling_edges_are_not_modelled error();
    endgenerate
endmodule
`default_nettype wire
