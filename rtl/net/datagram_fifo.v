// SPDX-License-Identifier: Apache-2.0
//
// Carries the bytes of whole datagrams into another clock domain: they are seen there only after i_commit, and i_drop forgets them. Whether
// a datagram is good is known at its very end, so this is what makes a damaged one vanish whole.
//
// A byte that is written while o_full is high is lost; then the writer has to drop the datagram. The other side is a valid/take stream. Both
// take a byte a clock. o_start and o_taken count the bytes that were committed, and taken, for datagram_mark. A register behind the memory, whose
// bytes come late in a clock, leaves time to look at them. BITS: there is room for 2^BITS bytes; 11 is one block RAM of an ECP5.
`default_nettype none
module datagram_fifo #(
    parameter BITS = 12
) (
    input  wire       i_clk,
    input  wire       i_write,
    input  wire [7:0] i_byte,
    input  wire       i_commit,  // not in a clock of i_write, and not with i_drop
    input  wire       i_drop,
    output wire       o_full,
    output wire [BITS:0] o_start,
    input  wire       o_clk,
    output reg        o_valid,
    output reg  [7:0] o_byte,
    input  wire       i_take,
    output reg  [BITS:0] o_taken
);
    localparam [BITS:0] ONE = {{BITS{1'b0}}, 1'b1};
    (* no_rw_check *) reg [7:0] bytes [0:(1<<BITS)-1];  // none is read before it has been committed
    reg  [BITS:0] place_q, start_q, read_q;             // start_q: of the datagram that comes
    wire [BITS:0] committed, taken;
    reg           here_q;  // byte_q waits
    reg  [7:0]    byte_q;
    initial {place_q, start_q, read_q, here_q, o_valid, o_taken} = {4*(BITS+1)+2{1'b0}};
    number_crossing #(.BITS(BITS+1)) forward (.i_clk(i_clk), .i_number(start_q), .o_clk(o_clk), .o_number(committed));
    number_crossing #(.BITS(BITS+1)) back    (.i_clk(o_clk), .i_number(read_q), .o_clk(i_clk), .o_number(taken));

    assign o_start = start_q;
    assign o_full = place_q == {~taken[BITS], taken[BITS-1:0]};
    wire   writes = i_write && !o_full;
    always @(posedge i_clk) begin
        if (writes) bytes[place_q[BITS-1:0]] <= i_byte;
        if (i_drop) place_q <= start_q;
        else if (writes) place_q <= place_q + ONE;
        if (i_commit) start_q <= place_q;
    end

    wire          moves  = !o_valid || i_take;
    wire [BITS:0] read_d = here_q && moves ? read_q + ONE : read_q;
    always @(posedge o_clk) begin
        byte_q <= bytes[read_d[BITS-1:0]];
        here_q <= read_d != committed;
        read_q <= read_d;
        if (moves) {o_valid, o_byte} <= {here_q, byte_q};
        if (o_valid && i_take) o_taken <= o_taken + ONE;
    end
endmodule
`default_nettype wire
