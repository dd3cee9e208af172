// SPDX-License-Identifier: Apache-2.0
// Everything its parts assert about each other is to hold here, whatever is in memory.
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    cover (f_reset_seen_q && !rst && commit && !silent && index != present);
end
