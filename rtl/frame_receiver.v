// SPDX-License-Identifier: Apache-2.0
//
// Keeps the bytes of a frame until its CRC has shown that it is whole, and drops the frame if it is not. So nothing behind this
// module ever sees a damaged, truncated or over-long frame.
//
// Bytes come from cobs_decoder, as they arrive, without a handshake. They go into a ring of 16-bit words, so that the next
// frame can arrive while the last one is carried out. At the other side each good frame is one word with its length in bytes
// (without the CRC) and then its bytes in pairs, low byte first: a valid/take stream that never pauses within a frame. o_good
// or o_damaged strobes with i_end. The length word of a good frame can be read two clocks after it.
// WORDS is the size of the ring: a power of two, at least twice the longest frame, so that two frames fit.
`default_nettype none
module frame_receiver #(
    parameter WORDS = 256
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_valid,
    input  wire [7:0]  i_byte,
    input  wire        i_end,
    input  wire        i_intact,
    output reg         o_valid,
    output reg  [15:0] o_word,
    input  wire        i_take,
    output wire        o_right,   // strobe: a frame of right CRC, also when there was no room for it
    output wire        o_good,    // strobe
    output wire        o_damaged  // strobe
);
    localparam BITS = $clog2(WORDS);
    localparam [BITS:0] ONE = {{BITS{1'b0}}, 1'b1};
    localparam [BITS+1:0] TWO = 2, SHORTEST = 4;  // sequence number, command, CRC

    (* no_rw_check *) reg [15:0] ring [0:WORDS-1];  // a word is never read in the clock in which it is written
    reg [BITS:0] start_q;  // where the length of the frame being received goes
    reg [BITS:0] place_q;  // where the next pair of bytes goes
    reg [BITS:0] read_q;
    reg [BITS+1:0] count_q;  // bytes of this frame so far; it cannot overflow before the ring does
    reg [7:0]    low_q;
    reg          full_q;   // a pair of bytes found no room
    reg [15:0]   crc_q;

    `include "crc16.vh"

    wire          is_pair = i_valid && count_q[0] && !full_q;
    wire [BITS:0] used    = place_q - read_q;
    wire          fits    = !used[BITS];
    wire          right   = i_intact && crc_q == 16'd0;
    wire          whole   = right && !full_q && count_q >= SHORTEST;
    wire          empty   = i_intact && count_q == {(BITS+2){1'b0}};
    wire [BITS+1:0] length = count_q - TWO;
    assign o_right   = i_end && right;
    assign o_good    = i_end && whole;
    assign o_damaged = i_end && !whole && !empty;

    wire          write         = o_good || (is_pair && fits);
    wire [BITS-1:0] write_address = o_good ? start_q[BITS-1:0] : place_q[BITS-1:0];
    wire [15:0]   write_word    = o_good ? {{(14-BITS){1'b0}}, length} : {i_byte, low_q};
    wire [BITS:0] length_words  = length[BITS+1:1] + {{BITS{1'b0}}, length[0]};
    wire [BITS:0] start_d       = o_good ? start_q + ONE + length_words : start_q;
    // i_take arrives late in the clock. So the results for both of its values are computed, and it only chooses.
    wire          takes         = o_valid && i_take;
    wire [BITS:0] read_next     = read_q + ONE;
    wire [BITS:0] read_d        = takes ? read_next : read_q;
    // All words before start_q were written at least one clock ago.
    wire          valid_d       = takes ? read_next != start_q : read_q != start_q;

    always @(posedge clk) begin
        if (write) ring[write_address] <= write_word;
        o_word <= ring[read_d[BITS-1:0]];
    end

    always @(posedge clk) begin
        if (i_valid && !count_q[0]) low_q <= i_byte;
        if (rst) begin
            start_q <= {(BITS+1){1'b0}};
            read_q  <= {(BITS+1){1'b0}};
            o_valid <= 1'b0;
        end else begin
            start_q <= start_d;
            read_q  <= read_d;
            o_valid <= valid_d;
        end
        if (rst || i_end) begin
            place_q <= rst ? ONE : start_d + ONE;
            count_q <= {(BITS+2){1'b0}};
            full_q  <= 1'b0;
            crc_q   <= 16'hffff;
        end else if (i_valid) begin
            crc_q <= crc16(crc_q, i_byte);
            if (!full_q) count_q <= count_q + 1'b1;
            if (is_pair) begin
                if (fits) place_q <= place_q + ONE;
                else full_q <= 1'b1;
            end
        end
    end

`ifdef FORMAL
    `include "formal/frame_receiver.vh"
`endif
endmodule
`default_nettype wire
