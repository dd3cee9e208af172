// SPDX-License-Identifier: Apache-2.0
//
// Knows the peer, which is the first sender of a good datagram until it has been silent for PEER_CLOCKS, and the asker, which is the sender of the
// frame that is to be answered.
//
// Addresses have 12 bytes: MAC, IP, port. The bytes of a sender's address come by i_address while its frame does. At i_taken, o_may says that the
// sender is the peer, or that there was no peer; then the sender is the peer from the next clock on. o_changed strobes with i_taken when there was
// no peer and the sender is not the last one. o_read_byte is the byte at i_read_place, in the same clock.
`default_nettype none
module peers #(
    parameter PEER_CLOCKS = 125000000
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_address,
    input  wire [3:0] i_place,
    input  wire [7:0] i_byte,
    input  wire       i_come,        // a byte of a frame: from the first one on the peer is not forgotten, because the frame may be its own
    input  wire       i_gone,        // the frame is over
    input  wire       i_taken,
    output wire       o_may,
    output wire       o_changed,
    output reg        o_held,        // there is a peer
    input  wire       i_keeps_asker, // an answer to the asker waits: do not take another one
    input  wire       i_keeps_peer,  // a frame to the peer is being sent: do not forget it now
    input  wire       i_reads_asker,
    input  wire [3:0] i_read_place,
    output wire [7:0] o_read_byte
);
    localparam BITS = $clog2(PEER_CLOCKS + 1);
    localparam [BITS-1:0] LIMIT = PEER_CLOCKS[BITS-1:0];
    (* ram_style = "distributed" *) reg [7:0] peer  [0:31];  // in one half, bank_q; who may become it, in the other
    (* ram_style = "distributed" *) reg [7:0] asker [0:15];
    reg [BITS-1:0] silence_q;
    reg            same_q, within_q, bank_q;
    initial {o_held, same_q, within_q, bank_q} = 4'b0100;
    assign o_changed   = i_taken && !o_held && !same_q;
    assign o_may       = same_q || !o_held;
    assign o_read_byte = i_reads_asker ? asker[i_read_place] : peer[{bank_q, i_read_place}];

    always @(posedge clk) begin
        if (i_address && !o_held) peer[{!bank_q, i_place}] <= i_byte;
        if (o_changed && !rst) bank_q <= !bank_q;
        if (i_address && !i_keeps_asker) asker[i_place] <= i_byte;
        if (i_gone || rst) same_q <= 1'b1;
        else if (i_address && i_byte != peer[{bank_q, i_place}]) same_q <= 1'b0;
        within_q <= !rst && !i_gone && (within_q || i_come);
        if (i_taken && o_may) silence_q <= {BITS{1'b0}};
        else if (silence_q != LIMIT) silence_q <= silence_q + 1'b1;
        if (rst) o_held <= 1'b0;
        else if (i_taken) o_held <= 1'b1;  // if it was another one, there is one already
        else if (silence_q == LIMIT && !i_keeps_peer && !within_q && !i_come) o_held <= 1'b0;
    end
endmodule
`default_nettype wire
