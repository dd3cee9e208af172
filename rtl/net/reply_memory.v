// SPDX-License-Identifier: Apache-2.0
//
// Gathers replies in the instrument's clock domain until they are worth a datagram, for the transmitter in the PHY's clock domain.
//
// i_byte is a valid/ready stream; a zero ends a reply, and only whole replies count. o_length bytes are to be sent from o_place on as soon as
// GATHER_BYTES wait or the first byte has waited for GATHER_CLOCKS of o_clk; until then o_length is 0. i_sent says that i_sent_length bytes were
// sent; five clocks later o_length counts again. o_byte is the byte at i_place, two clocks later. While i_forget is high there is no peer, and
// whole replies are thrown away. BITS: there is room for 2^BITS bytes, and a reply must not be longer than that.
`default_nettype none
module reply_memory #(
    parameter BITS = 10,
    parameter GATHER_BYTES  = 512,
    parameter GATHER_CLOCKS = 6250
) (
    input  wire            i_clk,
    input  wire            i_valid,
    output wire            o_ready,
    input  wire [7:0]      i_byte,
    input  wire            o_clk,
    input  wire            i_forget,
    output reg  [BITS:0]   o_length,
    output wire [BITS-1:0] o_place,
    input  wire [BITS-1:0] i_place,
    output reg  [7:0]      o_byte,
    input  wire            i_sent,
    input  wire [BITS:0]   i_sent_length
);
    localparam AGE_BITS = $clog2(GATHER_CLOCKS + 1);
    localparam [BITS:0] ONE = {{BITS{1'b0}}, 1'b1}, NONE = {(BITS+1){1'b0}}, ENOUGH = GATHER_BYTES[BITS:0];
    localparam [AGE_BITS-1:0] OLD = GATHER_CLOCKS[AGE_BITS-1:0];
    (* no_rw_check *) reg [7:0] bytes [0:(1<<BITS)-1];  // none is read before its reply is whole
    reg  [BITS:0] place_q, whole_q, gone_q;             // gone_q: what was sent
    reg  [7:0]    byte_q;                               // a block RAM's own output takes most of 8 ns
    reg  [BITS:0] waiting_q;
    reg  [AGE_BITS-1:0] age_q;
    reg                 some_q, enough_q, old_q;
    wire [BITS:0] whole, gone;
    initial {place_q, whole_q, gone_q, waiting_q, o_length, age_q, some_q, enough_q, old_q} = {5*(BITS+1)+AGE_BITS+3{1'b0}};
    number_crossing #(.BITS(BITS+1)) forward (.i_clk(i_clk), .i_number(whole_q), .o_clk(o_clk), .o_number(whole));
    number_crossing #(.BITS(BITS+1)) back    (.i_clk(o_clk), .i_number(gone_q), .o_clk(i_clk), .o_number(gone));
    assign o_place = gone_q[BITS-1:0];
    assign o_ready = place_q != {~gone[BITS], gone[BITS-1:0]};

    always @(posedge i_clk) if (i_valid && o_ready) begin
        bytes[place_q[BITS-1:0]] <= i_byte;
        place_q <= place_q + ONE;
        if (i_byte == 8'd0) whole_q <= place_q + ONE;
    end
    always @(posedge o_clk) begin
        byte_q <= bytes[i_place];
        o_byte <= byte_q;
        if (i_sent) gone_q <= gone_q + i_sent_length;
        else if (i_forget) gone_q <= whole;
        // A step a clock, because 8 ns are short. All of it has settled when the gap behind a frame is over.
        waiting_q <= whole - gone_q;
        some_q    <= waiting_q != NONE;
        enough_q  <= waiting_q >= ENOUGH;
        old_q     <= age_q == OLD;
        if (i_sent || !some_q) age_q <= {AGE_BITS{1'b0}};
        else if (age_q != OLD) age_q <= age_q + 1'b1;
        o_length <= old_q || enough_q ? waiting_q : NONE;
    end
endmodule
`default_nettype wire
