// SPDX-License-Identifier: Apache-2.0
//
// How Yosys makes sums and comparisons of an ECP5's cells, in the place of its own rules (techmap).
//
// A comparison with a constant is a tree of LUTs: fewer than a carry chain's cells. A carry chain has its first carry made by half of a cell, or
// by that of bit 0, and its last one brought out by another half, where nextpnr would add whole cells for them.
`default_nettype none

(* techmap_celltype = "$lt $le $gt $ge" *)
module compare_with_constant (A, B, Y);
    parameter A_SIGNED = 0, B_SIGNED = 0, A_WIDTH = 1, B_WIDTH = 1, Y_WIDTH = 1;
    parameter _TECHMAP_CELLTYPE_ = "";
    parameter _TECHMAP_CONSTMSK_A_ = 0, _TECHMAP_CONSTMSK_B_ = 0;
    (* force_downto *) input  wire [A_WIDTH-1:0] A;
    (* force_downto *) input  wire [B_WIDTH-1:0] B;
    (* force_downto *) output wire [Y_WIDTH-1:0] Y;
    localparam WIDTH = A_WIDTH > B_WIDTH ? A_WIDTH : B_WIDTH;
    localparam LEAVES = 1 << $clog2(WIDTH);

    wire _TECHMAP_FAIL_ = (A_SIGNED != 0 && B_SIGNED != 0) || WIDTH <= 4 || !(&_TECHMAP_CONSTMSK_A_ || &_TECHMAP_CONSTMSK_B_);

    localparam SWAPPED = _TECHMAP_CELLTYPE_ == "$gt" || _TECHMAP_CELLTYPE_ == "$le";
    localparam DENIED  = _TECHMAP_CELLTYPE_ == "$ge" || _TECHMAP_CELLTYPE_ == "$le";
    wire [LEAVES-1:0] a = {{LEAVES{1'b0}}, A}, b = {{LEAVES{1'b0}}, B};
    wire [LEAVES-1:0] left = SWAPPED ? b : a, right = SWAPPED ? a : b;
    // Node n has the nodes 2n and 2n + 1, whose bits are the higher ones; the leaves are the bits.
    wire [2*LEAVES-1:0] less, same;
    assign less[2*LEAVES-1:LEAVES] = ~left & right;
    assign same[2*LEAVES-1:LEAVES] = ~(left ^ right);
    genvar n;
    generate
        for (n = 1; n < LEAVES; n = n + 1) begin : node
            assign less[n] = less[2*n+1] || (same[2*n+1] && less[2*n]);
            assign same[n] = same[2*n+1] && same[2*n];
        end
    endgenerate
    assign Y = DENIED ? !less[1] : less[1];
endmodule

(* techmap_celltype = "$alu" *)
module carry_chain (A, B, CI, BI, X, Y, CO);
    parameter A_SIGNED = 0, B_SIGNED = 0, A_WIDTH = 1, B_WIDTH = 1, Y_WIDTH = 1;
    parameter _TECHMAP_CONSTMSK_CI_ = 0, _TECHMAP_CONSTVAL_CI_ = 0, _TECHMAP_CONSTMSK_BI_ = 0, _TECHMAP_CONSTVAL_BI_ = 0;
    (* force_downto *) input  wire [A_WIDTH-1:0] A;
    (* force_downto *) input  wire [B_WIDTH-1:0] B;
    input wire CI, BI;
    (* force_downto *) output wire [Y_WIDTH-1:0] X, Y, CO;

    wire _TECHMAP_FAIL_ = Y_WIDTH <= 4;

    (* force_downto *) wire [Y_WIDTH-1:0] a, b;
    \$pos #(.A_SIGNED(A_SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)) widens_a (.A(A), .Y(a));
    \$pos #(.A_SIGNED(B_SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH)) widens_b (.A(B), .Y(b));
    wire [Y_WIDTH-1:0] addend = BI ? ~b : b;

    // Half h of the chain has bit h - FIRST. The first half only makes a carry: it propagates none (the upper four bits of INIT, where C and D are 1),
    // and generates what the lower four say of B and A. That is CI, or, where that and BI are known, bit 0's carry, if this saves a half.
    localparam FIRST = Y_WIDTH % 2 == 0 && _TECHMAP_CONSTMSK_CI_ && _TECHMAP_CONSTMSK_BI_ ? 0 : 1;
    localparam HALVES = 2 * ((Y_WIDTH + FIRST + 2) / 2);  // with one behind them for the last carry
    localparam [15:0] OF_BIT_0 = _TECHMAP_CONSTVAL_BI_ ? (_TECHMAP_CONSTVAL_CI_ ? 16'h000b : 16'h0002) : (_TECHMAP_CONSTVAL_CI_ ? 16'h000e : 16'h0008);
    localparam [15:0] BEGINS = FIRST == 0 ? OF_BIT_0 : 16'h000a, ADDS = 16'h96aa, ENDS = 16'h0000;
    wire [HALVES-1:0] s, at_a, at_b;
    wire [HALVES:0]   carry;  // of every second half, from its pair
    assign at_a = FIRST == 0 ? {{HALVES{1'b0}}, a} : {{HALVES{1'b0}}, a, CI};
    assign at_b = FIRST == 0 ? {{HALVES{1'b0}}, b} : {{HALVES{1'b0}}, b, 1'b0};
    genvar h;
    generate
        for (h = 0; h < HALVES; h = h + 2) begin : pair
            localparam [15:0] LOWER = h == 0 ? BEGINS : h < Y_WIDTH + FIRST ? ADDS : ENDS;
            localparam [15:0] UPPER = h + 1 < Y_WIDTH + FIRST ? ADDS : ENDS;
            if (h == 0)
                CCU2C #(.INIT0(LOWER), .INIT1(UPPER), .INJECT1_0("NO"), .INJECT1_1("NO")) cell_of (
                    .CIN(1'bx), .A0(at_a[0]), .B0(at_b[0]), .C0(1'b1), .D0(1'b1), .A1(at_a[1]), .B1(at_b[1]), .C1(BI), .D1(1'b1),
                    .S1(s[1]), .COUT(carry[2]));
            else
                CCU2C #(.INIT0(LOWER), .INIT1(UPPER), .INJECT1_0("NO"), .INJECT1_1("NO")) cell_of (
                    .CIN(carry[h]), .A0(at_a[h]), .B0(at_b[h]), .C0(BI), .D0(1'b1), .A1(at_a[h+1]), .B1(at_b[h+1]), .C1(BI), .D1(1'b1),
                    .S0(s[h]), .S1(s[h+1]), .COUT(carry[h+2]));
        end
    endgenerate
    assign Y = FIRST == 0 ? {s[Y_WIDTH-1:1], a[0] ^ addend[0] ^ CI} : s[Y_WIDTH:1];
    // A carry behind another bit than the last one follows from that bit.
    assign X = a ^ addend;
    wire [Y_WIDTH-1:0] carries = (a & addend) | (X & ~Y);
    generate
        for (h = 0; h < Y_WIDTH; h = h + 1) begin : carry_of
            assign CO[h] = h == Y_WIDTH - 1 ? s[Y_WIDTH+FIRST] : carries[h];
        end
    endgenerate
endmodule
`default_nettype wire
