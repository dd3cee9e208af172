// SPDX-License-Identifier: Apache-2.0
//
// The angle and the length of a vector in the plane, one a clock, by CORDIC (Volder).
//
// A vector in the left half of the plane is first turned by half a turn. Then it is turned towards the x axis in 14 steps, by
// arctan(2^-step) each, two steps a clock; when it lies below the axis, it is mirrored there first. The turns add up to the angle.
// Each makes the vector longer, so o_length is 1.6468 times the length. The vector must be shorter than 2^22.
// A part stands for its value and a half more, as it was rounded down: so its complement is its exact negative, without a carry.
// o_angle is a fraction of a turn times 2^16. i_beside comes out with the result. Latency: 8 clocks.
// BESIDE_BITS is the width of what the user wants to have beside a result.
`default_nettype none
module polar #(
    parameter BESIDE_BITS = 1
) (
    input  wire                   clk,
    input  wire                   i_used,  // as square_root's
    input  wire signed [22:0]     i_re,
    input  wire signed [22:0]     i_im,
    input  wire [BESIDE_BITS-1:0] i_beside,
    output wire [15:0]            o_angle,
    output wire [22:0]            o_length,
    output wire [BESIDE_BITS-1:0] o_beside
);
    localparam STAGES  = 7;   // of two steps
    localparam SETTLED = 7;   // from this step on the length would grow by less than 2^-13 of it, and is left as it is
    localparam BITS    = 23;
    localparam LATENCY = STAGES + 1;

    generate
        if (BESIDE_BITS < 1) beside_bits_out_of_range error();
    endgenerate

    // arctan(2^-step) as a fraction of a turn times 2^18, rounded to the nearest, by its series; 1 / 2π is 2670177 / 2^24.
    function [17:0] arctangent(input integer step);
        reg [63:0] k, term, sum;
        begin
            sum = 64'd0;
            for (k = 64'd0; k != 64'd20; k = k + 64'd1) begin
                term = ((64'd1 << 40) >> ({32'd0, step} * (64'd2 * k + 64'd1))) / (64'd2 * k + 64'd1);
                sum  = k[0] ? sum - term : sum + term;
            end
            sum = ((sum >> 10) * 64'd2670177 + (64'd1 << 35)) >> 36;
            arctangent = step == 0 ? 18'd32768 : sum[17:0];  // an eighth, for which the series is too slow
        end
    endfunction

    // The sum of the first arctangents: the angle when every turn is a downward one.
    function [17:0] arctangents(input integer steps);
        integer step;
        begin
            arctangents = 18'd0;
            for (step = 0; step < steps; step = step + 1) arctangents = arctangents + arctangent(step);
        end
    endfunction
    localparam [17:0] START = arctangents(2 * STAGES) + 18'd2;  // with half of the last bit that comes out

    // Before each stage: x, y, the angle, and whether the vector has been mirrored an odd number of times. The angle begins as if
    // it never were: then all turns are downward. A turn of the mirrored vector takes back twice its arc.
    wire [BITS-1:0] x        [0:STAGES];
    wire [BITS-1:0] y        [0:STAGES];
    wire [17:0]     angle    [0:STAGES];
    wire            mirrored [0:STAGES];
    reg  [BITS-1:0] re_q, im_q;
    reg             left_q;
    always @(posedge clk) begin
        re_q   <= i_re ^ {BITS{i_re[BITS-1]}};
        im_q   <= i_im ^ {BITS{i_re[BITS-1]}};
        left_q <= i_re[BITS-1];
    end
    assign x[0]        = re_q;
    assign y[0]        = im_q;
    assign angle[0]    = {left_q, START[16:0]};
    assign mirrored[0] = 1'b0;
    assign o_length    = x[STAGES];
    assign o_angle     = angle[STAGES][17:2];

    genvar s;
    generate
        for (s = 0; s < STAGES; s = s + 1) begin : stage
            // |y| is at most 1.65 · 2^22 / 2^step after a step, so each stage drops two upper bits, which are copies of the sign.
            localparam IN  = s == 0 ? BITS : BITS - 2 * s + 2;
            localparam OUT = BITS - 2 * s;
            localparam [35:0] TWICE = {arctangent(2 * s + 1) << 1, arctangent(2 * s) << 1};
            wire [BITS-1:0] x_in        = x[s];
            wire [IN-1:0]   y_in        = y[s][IN-1:0];
            wire [17:0]     angle_in    = angle[s];
            wire            mirrored_in = mirrored[s];
            reg [BITS-1:0]  x_d, x_q, turn_x, turn_y;
            reg [IN-1:0]    y_d;
            reg [OUT-1:0]   y_q;
            reg [17:0]      angle_d, angle_q;
            reg             mirrored_d, mirrored_q;
            integer         i;
            always @* begin
                {x_d, turn_x, turn_y} = {3*BITS{1'bx}};
                {y_d, angle_d, mirrored_d} = {(IN+19){1'bx}};
                if (i_used) begin
                    {x_d, y_d, angle_d, mirrored_d} = {x_in, y_in, angle_in, mirrored_in};
                    for (i = 0; i < 2; i = i + 1) begin
                        mirrored_d = mirrored_d ^ y_d[IN-1];
                        y_d        = y_d ^ {IN{y_d[IN-1]}};
                        turn_x     = {{(BITS-IN+1){1'b0}}, y_d[IN-2:0]} >> (2 * s + i);
                        turn_y     = x_d >> (2 * s + i);
                        y_d        = y_d - turn_y[IN-1:0];
                        if (2 * s + i < SETTLED) x_d = x_d + turn_x;
                        angle_d    = angle_d - ({18{mirrored_d}} & TWICE[18*i +: 18]);
                    end
                end
            end
            always @(posedge clk) begin
                x_q        <= x_d;
                y_q        <= y_d[OUT-1:0];
                angle_q    <= angle_d;
                mirrored_q <= mirrored_d;
            end
            assign x[s+1]        = x_q;
            assign y[s+1]        = {{(BITS-OUT+1){y_q[OUT-1]}}, y_q[OUT-2:0]};
            assign angle[s+1]    = angle_q;
            assign mirrored[s+1] = mirrored_q;
            wire unused = &{1'b0, turn_y, y_d};  // their upper bits
        end
    endgenerate

    reg [LATENCY*BESIDE_BITS-1:0] beside_q;
    always @(posedge clk) beside_q <= i_used ? {beside_q[(LATENCY-1)*BESIDE_BITS-1:0], i_beside} : {LATENCY*BESIDE_BITS{1'bx}};
    assign o_beside = beside_q[LATENCY*BESIDE_BITS-1 -: BESIDE_BITS];
endmodule
`default_nettype wire
