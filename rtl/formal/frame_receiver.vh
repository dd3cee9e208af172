// SPDX-License-Identifier: Apache-2.0
`include "formal/crc16_bitwise.vh"
// Any one place in the ring, and any one word of a frame (word 0 is its length), are followed.
`ifdef FORMAL_FRAME_RECEIVER
(* anyconst *) wire [BITS-1:0] f_at;
(* anyconst *) wire [BITS:0]   f_number;
`else
wire [BITS-1:0] f_at     = {BITS{1'b0}};
wire [BITS:0]   f_number = ONE;
`endif
reg          f_reset_seen_q;
reg [15:0]   f_crc_q, f_bytes_q, f_pair_q, f_kept_q, f_word_q;
reg [BITS:0] f_kept_place_q;
initial f_reset_seen_q = 1'b0;
wire [15:0]   f_count   = {{(14-BITS){1'b0}}, count_q};
wire [15:0]   f_pairs   = f_bytes_q >> 1;
wire [15:0]   f_wanted  = {{(15-BITS){1'b0}}, f_number};
wire [BITS:0] f_readable = start_q - read_q;
wire [BITS-1:0] f_from_read = f_at - read_q[BITS-1:0];
wire          f_visible = {1'b0, f_from_read} < f_readable;
wire [15:0]   f_word    = ring[f_at];
wire [BITS:0] f_place   = start_q + f_number;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    f_word_q       <= f_word;
    if (rst || i_end) {f_crc_q, f_bytes_q} <= {16'hffff, 16'd0};
    else if (i_valid && f_bytes_q != 16'hffff) {f_crc_q, f_bytes_q} <= {crc16_bitwise(f_crc_q, i_byte), f_bytes_q + 16'd1};
    if (i_valid && f_bytes_q[0] && f_pairs + 16'd1 == f_wanted) f_pair_q <= {i_byte, low_q};
    if (o_good) {f_kept_place_q, f_kept_q} <= {f_place, f_number == 0 ? f_bytes_q - 16'd2 : f_pair_q};
    if (f_reset_seen_q) begin
        assert (f_readable <= WORDS[BITS:0] && used <= WORDS[BITS:0] + ONE && place_q - start_q <= used);
        assert (f_bytes_q == 16'hffff || f_crc_q == crc_q);
        assert (full_q || (f_bytes_q == f_count && place_q == start_q + ONE + f_pairs[BITS:0]));
        // A right CRC is seen also where there is no room.
        if (f_bytes_q != 16'hffff) assert (o_right == (i_end && i_intact && f_crc_q == 16'd0));
        cover (o_right && !o_good && f_bytes_q == 16'd4);
        assert (f_bytes_q >= f_count && (f_bytes_q == 16'd0 || f_pairs <= {{(15-BITS){1'b0}}, used} || full_q));
        assert ((used <= WORDS[BITS:0] || place_q == start_q + ONE) && (!full_q || f_count != 16'd0));
        // A frame is kept whole, or not at all.
        assert (!o_good || (i_end && i_intact && f_crc_q == 16'd0 && f_bytes_q >= 16'd4));
        assert (!o_good || place_q == start_q + ONE + f_pairs[BITS:0]);
        assert (!i_end || o_good || o_damaged || (i_intact && f_bytes_q == 16'd0));
        assert ($past(rst) ? start_q == 0 && !o_valid : $past(o_good) || start_q == $past(start_q));
        if (f_visible && $past(f_visible) && !$past(rst)) assert (f_word == f_word_q);
        if (o_valid) assert (f_readable != 0 && o_word == ring[read_q[BITS-1:0]]);
        if (!full_q && f_number != 0 && f_pairs >= f_wanted) assert (ring[f_place[BITS-1:0]] == f_pair_q);
        if ($past(o_good && f_wanted <= (f_count - 16'd1) >> 1) && !$past(rst)) assert (ring[f_kept_place_q[BITS-1:0]] == f_kept_q);
        cover (o_good && f_bytes_q == 16'd5);
        cover (o_damaged && f_bytes_q == 16'd4 && i_intact);
        cover (o_damaged && full_q && f_crc_q == 16'd0);
        cover (o_valid && i_take && read_q == f_kept_place_q && f_number == 2 && !o_good);
    end
end
