// SPDX-License-Identifier: Apache-2.0
//
// Computes phase and amplitude of every channel from one to eight foci, so that a record of foci is as good as one of timings.
//
// Geometry, four words a channel: x, y, z (signed, in 1/128 mm, in the tile's frame); then the offset of its phase (of a turn,
// times 256) in bits 15:8, and what its amplitude lacks of full (times 255) in bits 7:0.
// A focus, four words: the lower 16 bits of x, y and z (signed, 18 bits, in the same unit); then the amplitude in bits 15:8, 0 in
// bits 7:6, and the upper bits of z, y and x in 5:4, 3:2 and 1:0. Foci are written into one of two banks while the other is played.
// i_start/o_ready hands over the bank with foci 0 to i_last_focus. Results follow in the order of the channels, one each
// i_last_focus + 1 clocks; the first is there 34 + i_last_focus clocks after the start, the last, with o_last, after
// 33 + CHANNELS · (i_last_focus + 1). focus_phase.v and phasor_sum.v say what they mean; o_far: a focus was too far to count.
// i_wave_number and i_gain must not change while results come. Geometry that is written then can spoil them. rst drops all.
// CHANNELS is the core's. Until geometry is written, all channels are at the origin.
`default_nettype none
module focus_engine #(
    parameter CHANNELS     = 100,
    parameter CHANNEL_BITS = $clog2(CHANNELS)  // follows from CHANNELS
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_geometry,          // write a word of geometry
    input  wire [CHANNEL_BITS+1:0] i_geometry_address,  // {channel, word}
    input  wire [15:0]             i_geometry_word,
    input  wire                    i_focus,             // write a word of a focus
    input  wire [4:0]              i_focus_address,     // {focus, word}
    input  wire [15:0]             i_focus_word,
    input  wire                    i_start,             // after the last word
    output wire                    o_ready,
    input  wire [2:0]              i_last_focus,        // the number of foci, less one
    input  wire                    i_whole,             // all channels at full amplitude
    input  wire [17:0]             i_wave_number,
    input  wire [15:0]             i_gain,
    output wire                    o_valid,
    output wire                    o_last,
    output wire                    o_far,
    output reg  [CHANNEL_BITS-1:0] o_channel,
    output wire [15:0]             o_phase,
    output wire [15:0]             o_amplitude
);
    localparam [CHANNEL_BITS-1:0] LAST = CHANNELS[CHANNEL_BITS-1:0] - 1'b1;

    generate
        if (CHANNELS < 2 || CHANNELS > 1000) channels_out_of_range error();
    endgenerate

    // Channels, and within them foci, are counted. bank_q is the one that is written.
    reg                    run_q, whole_q, bank_q;
    reg [CHANNEL_BITS-1:0] channel_q;
    reg [2:0]              focus_q, last_focus_q;
    wire last_focus = focus_q == last_focus_q;
    wire ends       = last_focus && channel_q == LAST;
    wire starts     = i_start && o_ready;
    assign o_ready  = !run_q || ends;
    always @(posedge clk) begin
        if (rst) run_q <= 1'b0;
        else if (o_ready) run_q <= i_start;
        if (rst) bank_q <= 1'b0;
        else if (starts) bank_q <= !bank_q;
        if (starts) begin
            channel_q    <= {CHANNEL_BITS{1'b0}};
            focus_q      <= 3'd0;
            last_focus_q <= i_last_focus;
            whole_q      <= i_whole;
        end else begin
            focus_q <= last_focus ? 3'd0 : focus_q + 1'b1;
            if (last_focus) channel_q <= channel_q + 1'b1;
        end
    end

    // A channel's geometry comes two clocks after its number, as from any block RAM (primary_memory.v), and its focus with it.
    (* no_rw_check *) reg [63:0] geometry [0:CHANNELS-1];
    integer g;
    initial for (g = 0; g < CHANNELS; g = g + 1) geometry[g] = 64'd0;
    reg [63:0] foci [0:15];
    reg [63:0] place_1_q, place_q, source_q;
    reg [3:0]  source_1_q;
    reg        valid_1_q, first_1_q, last_1_q, whole_1_q;
    reg        valid_2_q, first_2_q, last_2_q, whole_2_q;
    integer w;
    always @(posedge clk) begin
        for (w = 0; w < 4; w = w + 1) begin
            if (i_geometry && i_geometry_address[1:0] == w[1:0])
                geometry[i_geometry_address[CHANNEL_BITS+1:2]][16*w +: 16] <= i_geometry_word;
            if (i_focus && i_focus_address[1:0] == w[1:0])
                foci[{bank_q, i_focus_address[4:2]}][16*w +: 16] <= i_focus_word;
        end
        place_1_q  <= geometry[channel_q];
        place_q    <= place_1_q;
        source_1_q <= {!bank_q, focus_q};
        source_q   <= foci[source_1_q];
        {first_1_q, last_1_q, whole_1_q} <= {focus_q == 3'd0, last_focus, whole_q};
        {first_2_q, last_2_q, whole_2_q} <= {first_1_q, last_1_q, whole_1_q};
        valid_1_q <= run_q && !rst;
        valid_2_q <= valid_1_q && !rst;
    end

    // What corrects elements, the offset and the lack, costs 9 LUTs, 5 carry cells of two, a multiplier and 376 flip-flops of an ECP5:
    // yosys -p "read_verilog -Irtl rtl/*.v; chparam -set CHANNELS 100 focus_engine; synth_ecp5 -top focus_engine; stat"
    // and again with 8'd0 for place_q[63:56] and place_q[55:48]. Boards of timings have it in their records, for nothing.
    wire        phase_valid, phase_far, first, last, whole;
    wire [15:0] phase;
    wire [7:0]  amplitude;
    wire [7:0]  lacks;
    focus_phase #(.BESIDE_BITS(19)) way (
        .clk(clk), .rst(rst), .i_valid(valid_2_q),
        .i_focus_x({source_q[49:48], source_q[15:0]}), .i_focus_y({source_q[51:50], source_q[31:16]}),
        .i_focus_z({source_q[53:52], source_q[47:32]}),
        .i_x(place_q[15:0]), .i_y(place_q[31:16]), .i_z(place_q[47:32]), .i_offset(place_q[63:56]),
        .i_wave_number(i_wave_number), .i_beside({first_2_q, last_2_q, whole_2_q, place_q[55:48], source_q[63:56]}),
        .o_valid(phase_valid), .o_phase(phase), .o_far(phase_far), .o_beside({first, last, whole, lacks, amplitude}));
    phasor_sum sum (
        .clk(clk), .rst(rst), .i_valid(phase_valid), .i_first(first), .i_last(last), .i_far(phase_far), .i_whole(whole),
        .i_phase(phase), .i_amplitude(amplitude), .i_gain(i_gain), .i_lacks(lacks),
        .o_valid(o_valid), .o_far(o_far), .o_phase(o_phase), .o_amplitude(o_amplitude));

    assign o_last = o_valid && o_channel == LAST;
    always @(posedge clk) begin
        if (rst || o_last) o_channel <= {CHANNEL_BITS{1'b0}};
        else if (o_valid) o_channel <= o_channel + 1'b1;
    end

    wire unused = &{1'b0, source_q[55:54]};
endmodule
`default_nettype wire
