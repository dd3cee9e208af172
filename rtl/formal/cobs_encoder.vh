// SPDX-License-Identifier: Apache-2.0
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (f_reset_seen_q) begin
        // While either side pauses, nothing changes.
        assert (!o_valid || (state_q == SEND && o_byte == frame[read_q]));
        if ($past(!rst && o_valid && !i_ready)) begin
            assert (o_valid && o_byte == $past(o_byte));
        end
        if ($past(!rst && o_ready && !i_valid)) begin
            assert (o_ready && {code_q, place_q, run_q} == $past({code_q, place_q, run_q}));
        end
        if ($past(!rst && o_valid && i_ready)) begin
            assert (o_ready || (o_valid && read_q == $past(read_q) + ONE));
        end
        cover (o_valid && $past(o_valid && !i_ready));
        cover (o_ready && $past(o_valid));
    end
end
