// SPDX-License-Identifier: Apache-2.0
// Stamps are kept a second way: the clock of the last change of the pin, as it was sampled, and that of the last rise of the output.
reg        f_past_valid_q, f_was_active_q;
reg [47:0] f_differs_q;  // the clock in which the pin took the level that the input has not yet
initial {f_past_valid_q, f_was_active_q} = 2'b00;
wire [47:0] f_pin = clock_q - 48'd2;
wire [47:0] f_since = f_was_active_q ? f_differs_q : f_pin;
always @(posedge clk) begin
    f_past_valid_q <= 1'b1;
    f_was_active_q <= differs && !turns && !rst;  // it has differed since a clock before
    f_differs_q    <= f_since;
    if (f_past_valid_q) begin
        assert (clock_q == $past(clock_q) + 48'd1);
        // In: whatever counts has lasted, and its stamp is that of its first clock.
        assert (f_was_active_q == (stays_q != 16'd0));
        if (stays_q != 16'd0) assert (f_pin - f_differs_q == {32'd0, stays_q});
        if ($past(comes && !rst)) assert (in_clock_q == $past(f_since) && in_count_q == $past(in_count_q) + 16'd1);
        if (!$past(comes && !rst)) assert (in_clock_q == $past(in_clock_q) && in_count_q == $past(in_count_q));
        if (active_q != $past(active_q) && !$past(rst)) assert ($past(stays_q) >= $past(least_q));
        if ($past(rst)) assert (!active_q && !o_fires && !o_trigger);
        if (o_fires && !$past(in_level)) assert (active_q && !$past(active_q));
        if (o_fires && $past(in_level)) assert ($past(active_q));
        // Out: it rises with an event alone, and that has the clock in which it does.
        if (o_trigger && !$past(o_trigger)) assert ($past(happens) && out_clock_q == clock_q);
        if ($past(happens)) assert (out_clock_q == clock_q && out_count_q == $past(out_count_q) + 16'd1);
        if (!$past(happens)) assert (out_count_q == $past(out_count_q) && out_clock_q == $past(out_clock_q));
        if ($past(happens && !rst)) assert (o_trigger && high_q == ($past(length_q) == 24'd0 ? 24'd1 : $past(length_q)));
    end
    cover (f_past_valid_q && o_fires && stays_q == 16'd0 && least_q == 16'd2);
    cover (o_trigger && event_q == `HG_EVENT_PERIOD && out_count_q == 16'd2);
    cover (o_mute && i_enabled);
end
