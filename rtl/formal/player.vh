// SPDX-License-Identifier: Apache-2.0
// The assertions of its parts do the work: here each part is given what the others make, and memory may hold anything.
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    cover (f_reset_seen_q && !rst && commit && !silent && index != present);
end
