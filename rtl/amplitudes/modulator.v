// SPDX-License-Identifier: Apache-2.0
//
// Takes the command MODULATE and tells the sample of each carrier period, by modulation.v; without samples (DEPTH 0) it is always 255.
//
// With i_modulates the last i_modulate takes effect: samples begin with i_divider, i_length (0: all from the first) and i_form, or stop when
// i_divider is 0. The other ports are those of modulation, with words of its addresses. DEPTH is 0 or what modulation bears.
`default_nettype none
module modulator #(
    parameter DEPTH = 4096
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_write,
    input  wire [15:0] i_write_address,
    input  wire [15:0] i_write_word,
    input  wire [15:0] i_read_address,
    output wire [15:0] o_word,
    output wire        o_fetching,
    input  wire        i_modulate,    // strobe
    input  wire [15:0] i_divider,
    input  wire [15:0] i_length,
    input  wire [15:0] i_form,        // bit 0: over and over; the others: half the number of the first sample
    input  wire        i_modulates,   // strobe, with i_modulate or later
    input  wire        i_at_pass_end, // with it: when the present pass has ended
    input  wire        i_period,
    output wire        o_running,
    output wire        o_first,       // strobe
    output wire [7:0]  o_sample
);
    generate
        if (DEPTH != 0) begin : with_samples
            localparam BITS = $clog2(DEPTH);
            localparam [16:0] SAMPLES = DEPTH[16:0];
            reg  [15:0]     divider_q;
            reg  [BITS:0]   length_q;
            reg  [BITS-2:0] first_q;
            reg             loop_q, start_q, stop_q, at_pass_end_q;
            wire [15:0]     divider = i_modulate ? i_divider : divider_q;
            wire [16:0]     rest = SAMPLES - {1'b0, i_form[15:1], 1'b0}, length = {1'b0, i_length};
            wire            unused = &{1'b0, rest, length, i_write_address, i_read_address};  // command_check has seen that their upper bits are 0
            always @(posedge clk) begin
                {start_q, stop_q} <= {2{i_modulates && !rst}} & {divider != 16'd0, divider == 16'd0};
                at_pass_end_q     <= i_at_pass_end;
                if (i_modulate) begin
                    {divider_q, loop_q, first_q} <= {i_divider, i_form[0], i_form[BITS-1:1]};
                    length_q <= i_length == 16'd0 ? rest[BITS:0] : length[BITS:0];
                end
            end
            modulation #(.DEPTH(DEPTH)) samples (
                .clk(clk), .rst(rst),
                .i_write(i_write), .i_write_address(i_write_address[BITS-2:0]), .i_write_word(i_write_word),
                .i_read_address(i_read_address[BITS-2:0]), .o_word(o_word), .o_fetching(o_fetching),
                .i_drop(i_modulate), .i_start(start_q), .i_stop(stop_q), .i_at_pass_end(at_pass_end_q), .i_first(first_q), .i_length(length_q), .i_divider(divider_q), .i_loop(loop_q),
                .i_period(i_period), .o_running(o_running), .o_first(o_first), .o_sample(o_sample));
        end else begin : without_samples
            assign {o_word, o_fetching, o_running, o_first, o_sample} = 27'd255;
            wire unused = &{1'b0, clk, rst, i_write, i_write_address, i_write_word, i_read_address, i_modulate, i_divider, i_length,
                            i_form, i_modulates, i_at_pass_end, i_period};
        end
    endgenerate
endmodule
`default_nettype wire
