// SPDX-License-Identifier: Apache-2.0
//
// The phase at which one channel must play so that its wave arrives in phase at one focus: one result a clock.
//
// o_phase = i_offset / 256 − distance · i_wave_number, as a fraction of the carrier period times 2^16, modulo 1. It is where in the
// period the middle of the channel's pulse lies, so a nearer channel plays later, as in the focal law (Haptogram eq. 2-5).
// Lengths are signed, in 1/128 mm. The distance is found to 1/16 of that, and half a step is added, because the root is rounded
// down; their product is rounded down to 16 bits of a turn. i_wave_number is turns per 1/128 mm, times 2^27.
// o_far says that a coordinate of the focus and of the channel differ by 2^17 (1.024 m) or more. Then o_phase means nothing.
// i_beside comes out with the result. Latency: 16 clocks, for all inputs but i_wave_number, which must not change meanwhile.
// BESIDE_BITS is the width of what the user wants to have beside a result.
`default_nettype none
module focus_phase #(
    parameter BESIDE_BITS = 1
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_valid,
    input  wire signed [17:0]     i_focus_x, i_focus_y, i_focus_z,
    input  wire signed [15:0]     i_x, i_y, i_z,
    input  wire [7:0]             i_offset,
    input  wire [17:0]            i_wave_number,
    input  wire [BESIDE_BITS-1:0] i_beside,
    output wire                   o_valid,
    output reg  [15:0]            o_phase,
    output wire                   o_far,
    output wire [BESIDE_BITS-1:0] o_beside
);
    localparam FRACTION  = 4;                        // bits of the distance below 1/128 mm
    localparam ROOT_BITS = 18 + FRACTION;            // the distance is less than √3 · 2^17
    localparam STEPS     = 2;                        // digits of the root a clock
    localparam LATENCY   = 3 + ROOT_BITS / STEPS + 2;
    localparam TURN      = 27 + FRACTION + 1;        // the product's bits below one turn

    generate
        if (BESIDE_BITS < 1) beside_bits_out_of_range error();
    endgenerate

    reg [LATENCY-1:0]  valid_q;
    wire               used = i_valid || valid_q != {LATENCY{1'b0}};  // as square_root's i_used

    reg signed [18:0]  dx_q, dy_q, dz_q;
    wire signed [17:0] dx = dx_q[17:0], dy = dy_q[17:0], dz = dz_q[17:0];
    reg signed [35:0]  xx_q, yy_q, zz_q;
    reg [35:0]         square_q;
    always @(posedge clk) begin
        dx_q <= {i_focus_x[17], i_focus_x} - {{3{i_x[15]}}, i_x};
        dy_q <= {i_focus_y[17], i_focus_y} - {{3{i_y[15]}}, i_y};
        dz_q <= {i_focus_z[17], i_focus_z} - {{3{i_z[15]}}, i_z};
        {xx_q, yy_q, zz_q} <= {3*36{1'bx}};
        if (used) begin
            xx_q <= dx * dx;
            yy_q <= dy * dy;
            zz_q <= dz * dz;
        end
        square_q <= {2'b00, xx_q[33:0]} + {2'b00, yy_q[33:0]} + {2'b00, zz_q[33:0]};
    end

    wire [ROOT_BITS-1:0] root;
    square_root #(.BITS(ROOT_BITS), .STEPS(STEPS)) distance (
        .clk(clk), .i_used(used), .i_radicand({square_q, {2*FRACTION{1'b0}}}), .o_root(root));

    wire [TURN-1:0] product = {{(TURN-ROOT_BITS-1){1'b0}}, root, 1'b1} * {{(TURN-18){1'b0}}, i_wave_number};
    reg  [15:0]     turns_q;

    // far_q[0] belongs to the squares. A difference of 2^17 or more does not fit 18 bits, but for -2^17, whose square is the
    // only one with bit 34.
    reg [LATENCY-2:0]             far_q;
    reg [(LATENCY-1)*8-1:0]       offset_q;
    reg [LATENCY*BESIDE_BITS-1:0] beside_q;
    wire too_wide = dx_q[18] != dx_q[17] || dy_q[18] != dy_q[17] || dz_q[18] != dz_q[17];
    always @(posedge clk) begin
        turns_q  <= product[TURN-1 -: 16];
        o_phase  <= {offset_q[(LATENCY-1)*8-1 -: 8], 8'd0} - turns_q;
        far_q    <= {far_q[LATENCY-3:1], far_q[0] || xx_q[34] || yy_q[34] || zz_q[34], too_wide};
        offset_q <= used ? {offset_q[(LATENCY-2)*8-1:0], i_offset} : {(LATENCY-1)*8{1'bx}};
        beside_q <= used ? {beside_q[(LATENCY-1)*BESIDE_BITS-1:0], i_beside} : {LATENCY*BESIDE_BITS{1'bx}};
        valid_q  <= rst ? {LATENCY{1'b0}} : {valid_q[LATENCY-2:0], i_valid};
    end
    assign o_valid  = valid_q[LATENCY-1];
    assign o_far    = far_q[LATENCY-2];
    assign o_beside = beside_q[LATENCY*BESIDE_BITS-1 -: BESIDE_BITS];

    wire unused = &{1'b0, xx_q[35], yy_q[35], zz_q[35], product[TURN-17:0]};
endmodule
`default_nettype wire
