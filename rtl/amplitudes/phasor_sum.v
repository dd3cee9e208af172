// SPDX-License-Identifier: Apache-2.0
//
// Adds up amplitude · e^(j·phase) over a channel's foci, one focus a clock, and tells the phase and the length of the sum.
//
// i_first and i_last frame a sum of 1 to 8 foci, whose clocks need not follow each other. The sine is read from a table of a
// quarter turn in 1,024 steps; polar.v tells the sum's angle. The phase of a lone focus comes out as it came in. A focus that is
// i_far counts as amplitude 0.
// o_amplitude is the length times i_gain, but 65535 (full) at most: one focus of amplitude 255 is full at a gain of 39953, eight
// of them that meet in phase at an eighth of it. With i_whole every sum is full, but for one whose length rounds to 0, which stays
// 0. Of that the channel has 255 − i_lacks parts of 255. o_far says that one of the foci was far. Where o_amplitude is 0, o_phase means nothing.
// Latency: 15 clocks from the last focus. i_gain must not change meanwhile; i_whole and i_lacks count with i_last.
`default_nettype none
module phasor_sum (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_valid,
    input  wire        i_first,
    input  wire        i_last,
    input  wire        i_far,
    input  wire        i_whole,
    input  wire [15:0] i_phase,      // 2^16 is one turn
    input  wire [7:0]  i_amplitude,
    input  wire [15:0] i_gain,
    input  wire [7:0]  i_lacks,
    output reg         o_valid,
    output reg         o_far,
    output reg  [15:0] o_phase,
    output reg  [15:0] o_amplitude
);
    localparam BITS = 23;  // of the sum's parts: 8 foci · 255 · 2^17, of which the last 6 bits are left out

    // sin((index + 1/2) · (1/4)/1024 turn) · 2^16, rounded down, by the sine's series with 30 bits. The half steps make a sine
    // of any quarter from this one: by reading backwards, and by complementing, because each word stands for a half more.
    function [15:0] sine(input integer index);
        reg [63:0] angle, square, series, k;
        begin
            angle  = (({32'd0, index} * 64'd2 + 64'd1) * 64'd3373259426) >> 12;  // π · 2^30
            square = (angle * angle) >> 30;
            series = 64'd1 << 30;
            for (k = 64'd12; k != 64'd0; k = k - 64'd2)
                series = (64'd1 << 30) - ((square * series) >> 30) / (k * (k + 64'd1));
            angle = (angle * series) >> 44;
            sine  = angle[15:0];
        end
    endfunction
    (* rom_style = "block" *) reg [15:0] quarter [0:1023];
    integer n;
    initial for (n = 0; n < 1024; n = n + 1) quarter[n] = sine(n);

    // What a sum must know beside its parts: of the foci until it is there, then of itself until its length is told.
    localparam TOLD = 13;
    reg [3:0]    first_q, last_q, far_q;
    reg [TOLD:0] valid_q;  // of the foci in clocks 1 to 4, then of the sums
    reg [4:0]    whole_q;
    reg [79:0]   phase_q;
    reg [39:0]   lacks_q;
    wire         used = i_valid || valid_q != {(TOLD+1){1'b0}};  // as square_root's i_used
    reg          lone_5_q, far_5_q;
    always @(posedge clk) begin
        valid_q <= rst ? {(TOLD+1){1'b0}} : {valid_q[TOLD-1:4], valid_q[3] && last_q[3], valid_q[2:0], i_valid};
        first_q <= {first_q[2:0], i_first};
        last_q  <= {last_q[2:0], i_last};
        far_q   <= {far_q[2:0], i_far};
        whole_q <= {whole_q[3:0], i_whole};
        phase_q <= used ? {phase_q[63:0], i_phase} : 80'bx;
        lacks_q <= {lacks_q[31:0], i_lacks};
        if (valid_q[3]) begin
            lone_5_q <= first_q[3];  // and last, if it is a sum
            far_5_q  <= far_q[3] || (far_5_q && !first_q[3]);
        end
    end

    // By clocks: 1 addresses, 2 table, 3 factors, 4 products, 5 sum.
    reg [9:0]              sine_at_q, cosine_at_q;
    reg [1:0]              quarter_1_q, quarter_2_q;
    reg [15:0]             sine_2_q, cosine_2_q;
    reg signed [17:0]      sine_3_q, cosine_3_q;
    reg [23:0]             amplitude_q;  // of clocks 1 to 3
    reg signed [25:0]      im_4_q, re_4_q;
    reg signed [BITS-1:0]  im_5_q, re_5_q;
    wire signed [8:0]      amplitude = {1'b0, amplitude_q[23:16]};
    wire signed [BITS-1:0] im_4 = {{3{im_4_q[25]}}, im_4_q[25:6]};
    wire signed [BITS-1:0] re_4 = {{3{re_4_q[25]}}, re_4_q[25:6]};
    always @(posedge clk) begin
        sine_at_q   <= i_phase[13:4] ^ {10{i_phase[14]}};
        cosine_at_q <= i_phase[13:4] ^ {10{!i_phase[14]}};
        quarter_1_q <= i_phase[15:14];
        sine_2_q    <= quarter[sine_at_q];
        cosine_2_q  <= quarter[cosine_at_q];
        quarter_2_q <= quarter_1_q;
        sine_3_q    <= {quarter_2_q[1], sine_2_q ^ {16{quarter_2_q[1]}}, 1'b1};
        cosine_3_q  <= {^quarter_2_q, cosine_2_q ^ {16{^quarter_2_q}}, 1'b1};
        amplitude_q <= {amplitude_q[15:0], i_far ? 8'd0 : i_amplitude};
        im_4_q      <= sine_3_q * amplitude;
        re_4_q      <= cosine_3_q * amplitude;
        if (valid_q[3]) begin
            im_5_q <= first_q[3] ? im_4 : im_5_q + im_4;
            re_5_q <= first_q[3] ? re_4 : re_5_q + re_4;
        end
    end

    wire [15:0] angle, lone_phase;
    wire [22:0] length;
    wire        lone, far, whole;
    wire [7:0]  lacks;
    polar #(.BESIDE_BITS(27)) phasor (
        .clk(clk), .i_used(used), .i_re(re_5_q), .i_im(im_5_q), .i_beside({lone_5_q, far_5_q, whole_q[4], phase_q[79:64], lacks_q[39:32]}),
        .o_angle(angle), .o_length(length), .o_beside({lone, far, whole, lone_phase, lacks}));

    wire [17:0] rounded = length[22:5];  // as long as a factor of a multiplier
    wire [33:0] product = {16'd0, rounded} * {18'd0, i_gain};
    reg  [19:0] scaled_q;
    reg  [15:0] told_phase_q;
    reg  [7:0]  part_q;
    reg         silent_q, whole_14_q, far_14_q;
    // 255 parts are 256 of 256, so that full stays full.
    wire [15:0] of_full = silent_q ? 16'd0 : whole_14_q || scaled_q[19:16] != 4'd0 ? 16'hffff : scaled_q[15:0];
    wire [24:0] parted  = {9'd0, of_full} * {16'd0, {1'b0, part_q} + {8'd0, part_q[7]}};
    always @(posedge clk) begin
        scaled_q     <= product[33:14];
        silent_q     <= rounded == 18'd0;
        whole_14_q   <= whole;
        part_q       <= ~lacks;
        far_14_q     <= far;
        told_phase_q <= lone ? lone_phase : angle;
        o_phase      <= told_phase_q;
        o_far        <= far_14_q;
        o_valid      <= valid_q[TOLD] && !rst;
        o_amplitude  <= parted[23:8];
    end

    wire unused = &{1'b0, im_4_q[5:0], re_4_q[5:0], length[4:0], product[13:0], parted[24], parted[7:0]};
endmodule
`default_nettype wire
