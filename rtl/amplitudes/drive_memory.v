// SPDX-License-Identifier: Apache-2.0
//
// Holds what each channel is to emit, phase and amplitude, in two banks: one is swept once a carrier period while the other fills.
//
// Words come in the order of the channels, from wherever a record's words are made, and are counted here: o_complete says that the
// bank has one of each channel, so nothing upstream need know how long its words take. i_clear empties the bank that fills, which is
// the other one than i_swept. A word is there two clocks after i_channel.
// CHANNELS is the core's.
`default_nettype none
module drive_memory #(
    parameter CHANNELS     = 100,
    parameter CHANNEL_BITS = $clog2(CHANNELS)  // follows from CHANNELS
) (
    input  wire                    clk,
    input  wire                    i_clear,
    input  wire                    i_write,
    input  wire [31:0]             i_word,     // {amplitude, phase}
    output wire                    o_complete,
    input  wire                    i_swept,    // the bank that is read
    input  wire [CHANNEL_BITS-1:0] i_channel,
    output reg  [31:0]             o_word
);
    localparam [CHANNEL_BITS:0] ALL = CHANNELS[CHANNEL_BITS:0];

    (* no_rw_check *) reg [31:0] words [0:(2<<CHANNEL_BITS)-1];
    reg [CHANNEL_BITS:0] count_q;
    reg [31:0]           word_q;
    assign o_complete = count_q == ALL;
    always @(posedge clk) begin
        if (i_clear) count_q <= {(CHANNEL_BITS+1){1'b0}};
        else if (i_write && !o_complete) count_q <= count_q + 1'b1;
        if (i_write) words[{!i_swept, count_q[CHANNEL_BITS-1:0]}] <= i_word;
        word_q <= words[{i_swept, i_channel}];
        o_word <= word_q;
    end
endmodule
`default_nettype wire
