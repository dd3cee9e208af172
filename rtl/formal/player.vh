// SPDX-License-Identifier: Apache-2.0
// The assertions of its parts do the work: here each part is given what the others make, and memory may hold anything.
`ifdef FORMAL_PLAYER
// Of a board without SYNC; carrier_sync and cycle_controller have proofs of what it does. A silence that is dropped is a
// load that is preempted.
always @* assume (!i_hold && !i_together && !i_drop);
`endif
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    cover (f_reset_seen_q && !rst && commit && !silent && index != present);
end
