// SPDX-License-Identifier: Apache-2.0
//
// The byte side of the port's receiver, with who its peer is: what tests/modules/net_frames.py sends it comes out as what was made of it.
`default_nettype none
module net_receiver_bench #(
    parameter PEER_CLOCKS = 200000
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_dv,
    input  wire        i_er,
    input  wire [7:0]  i_data,
    output wire        o_write,
    output wire [7:0]  o_byte,
    output wire        o_commit,
    output wire        o_drop,
    output wire [4:0]  o_counts,  // strobes: accepted, refused, damaged; and DISABLE, STOP
    output wire        o_answer,
    output wire [1:0]  o_answer_kind,
    output wire [10:0] o_answer_length,
    output wire [15:0] o_answer_sum,
    output wire [7:0]  o_asked,
    input  wire        i_answered
);
    wire       valid, ended, good, address, come, gone, taken, may;
    wire [7:0] data, come_byte;
    wire [3:0] place;
    wire       held, changed;
    wire [7:0] peer_byte;
    wire [10:0] come_place;
    wire       unused = &{1'b0, held, changed, peer_byte, come_place};
    eth_receiver frames (
        .clk(clk), .rst(rst), .i_dv(i_dv), .i_er(i_er), .i_data(i_data), .o_valid(valid), .o_byte(data), .o_end(ended), .o_good(good));
    udp_receiver datagrams (
        .clk(clk), .rst(rst), .i_valid(valid), .i_byte(data), .i_end(ended), .i_good(good),
        .o_write(o_write), .o_byte(o_byte), .i_full(1'b0), .o_commit(o_commit), .o_drop(o_drop), .o_address(address), .o_address_place(place),
        .o_come(come), .o_come_byte(come_byte), .o_come_place(come_place), .o_gone(gone), .o_taken(taken), .i_may(may),
        .o_answer(o_answer), .o_answer_kind(o_answer_kind), .o_answer_length(o_answer_length), .o_answer_sum(o_answer_sum),
        .o_asked(o_asked), .i_answered(i_answered), .o_disable(o_counts[3]), .o_stop(o_counts[4]),
        .o_accepted(o_counts[0]), .o_refused(o_counts[1]), .o_damaged(o_counts[2]));
    peers #(.PEER_CLOCKS(PEER_CLOCKS)) who (
        .clk(clk), .rst(rst), .i_address(address), .i_place(place), .i_byte(come_byte), .i_come(come), .i_gone(gone), .i_taken(taken),
        .o_may(may), .o_changed(changed), .o_held(held), .i_keeps_asker(1'b0), .i_keeps_peer(1'b0), .i_reads_asker(1'b0), .i_read_place(4'd0), .o_read_byte(peer_byte));
endmodule
`default_nettype wire
