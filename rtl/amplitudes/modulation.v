// SPDX-License-Identifier: Apache-2.0
//
// Holds the samples by which all amplitudes are multiplied, and says which one belongs to the present carrier period.
//
// i_period is the strobe that begins a period. i_start and i_stop take effect at the next one, or with i_at_pass_end, which comes with them, at
// the one after the last of the present pass; the later of them counts, and i_stop if both come at once. i_drop takes back what has not
// taken effect. i_first is where the samples begin, in words of two. From a start on, sample i belongs to the periods i · N … (i + 1) · N − 1, counted from 0, with N = i_divider.
// After i_length samples they come from the beginning again if i_loop; if not, the last one stays. i_length, i_divider and i_loop are
// taken when the start takes effect. Stopped, a sample is 255, which is no modulation. o_running is high until stopped, or until the last sample's
// N periods are over. Both outputs change four clocks after i_period, and stay until the next one, which must be four clocks away or more.
// A sample has 8 bits: with 625 widths of a pulse more would hardly be heard or felt, and a word of the link carries two.
// The memory has one port to write and one to read. While o_fetching its word is read for playing; a write and a reply must wait. A
// word arrives at o_word two clocks after its address. DEPTH is how many samples it holds, a power of two from 4 to 65536.
`default_nettype none
module modulation #(
    parameter DEPTH = 4096,
    parameter BITS  = $clog2(DEPTH)  // follows from DEPTH
) (
    input  wire            clk,
    input  wire            rst,
    input  wire            i_write,
    input  wire [BITS-2:0] i_write_address,  // of words of two samples, the earlier one in the low byte
    input  wire [15:0]     i_write_word,
    input  wire [BITS-2:0] i_read_address,
    output reg  [15:0]     o_word,
    output wire            o_fetching,
    input  wire            i_drop,           // strobe
    input  wire            i_start,          // strobe
    input  wire            i_stop,           // strobe
    input  wire            i_at_pass_end,
    input  wire [BITS-2:0] i_first,
    input  wire [BITS:0]   i_length,         // samples, 1 to DEPTH; not 0
    input  wire [15:0]     i_divider,        // periods a sample, 1 to 65535; not 0
    input  wire            i_loop,
    input  wire            i_period,
    output reg             o_running,
    output reg             o_first,          // strobe, a clock after the i_period whose period's sample is the first, in each pass
    output reg  [7:0]      o_sample
);
    generate
        if (DEPTH < 4 || DEPTH > 65536 || DEPTH != (1 << BITS)) depth_out_of_range error();
    endgenerate

    // What is played: the present period's sample, and how many of its periods are still to come.
    reg             plays_q, ended_q, loop_q;
    reg  [BITS-1:0] sample_q, first_q, last_q;
    reg  [15:0]     left_q, divider_q;
    wire            at_end = sample_q == last_q;
    wire            pass_ends = !plays_q || ended_q || (at_end && left_q == 16'd1);
    wire [BITS-1:0] first  = {i_first, 1'b0};
    wire            unused = &{1'b0, i_length[BITS]};  // the low bits of DEPTH are 0, and less 1 all ones

    // What is asked for, until it takes effect.
    reg  starts_q, stops_q, at_pass_end_q;
    wire starts = i_start ? !i_stop : starts_q && !i_stop;
    wire stops  = i_stop || (stops_q && !i_start);
    wire later  = i_start || i_stop ? i_at_pass_end : at_pass_end_q;
    wire now    = i_period && (!later || pass_ends);
    always @(posedge clk) {starts_q, stops_q, at_pass_end_q} <= {{2{!rst && !now && !i_drop}} & {starts, stops}, later};

    initial o_first = 1'b0;
    always @(posedge clk) begin
        o_first <= !rst && i_period && (starts && now || (!(stops && now) && plays_q && !ended_q && left_q == 16'd1 && at_end && loop_q));
        if (rst) {plays_q, ended_q} <= 2'b00;
        else if (i_period) begin
            if (starts && now) begin
                {plays_q, ended_q, loop_q} <= {2'b10, i_loop};
                sample_q  <= first;
                first_q   <= first;
                last_q    <= first + i_length[BITS-1:0] - 1'b1;
                left_q    <= i_divider;
                divider_q <= i_divider;
            end else if (stops && now) {plays_q, ended_q} <= 2'b00;
            else if (left_q != 16'd1) left_q <= left_q - 1'b1;
            else if (at_end && !loop_q) ended_q <= 1'b1;
            else begin
                sample_q <= at_end ? first_q : sample_q + 1'b1;
                left_q   <= divider_q;
            end
        end
    end

    // The sample is read once a period. A number says how many clocks after i_period it is.
    (* no_rw_check *) reg [15:0] words [0:DEPTH/2-1];
    integer w;
    initial for (w = 0; w < DEPTH/2; w = w + 1) words[w] = 16'hffff;
    reg [15:0] word_q;
    reg [3:1]  period_q;
    assign o_fetching = period_q[1];
    wire [BITS-2:0] address = o_fetching ? sample_q[BITS-1:1] : i_read_address;
    always @(posedge clk) begin
        if (i_write) words[i_write_address] <= i_write_word;
        word_q   <= words[address];
        o_word   <= word_q;
        period_q <= rst ? 3'd0 : {period_q[2:1], i_period};
        if (rst) {o_running, o_sample} <= {1'b0, 8'hff};
        else if (period_q[3]) begin
            o_running <= plays_q && !ended_q;
            o_sample  <= !plays_q ? 8'hff : sample_q[0] ? o_word[15:8] : o_word[7:0];
        end
    end

`ifdef FORMAL
    `include "formal/modulation.vh"
`endif
endmodule
`default_nettype wire
