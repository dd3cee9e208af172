// SPDX-License-Identifier: Apache-2.0
//
// The square root of a whole number, rounded down, one a clock.
//
// It is found digit by digit, as on paper: the radicand's next two bits are brought down behind the rest, and the root's next
// bit is 1 when four times the root so far, plus 1, can be subtracted from that. This takes no multiplier, and each stage works
// only with the bits that can be set by then. o_root belongs to the i_radicand of BITS / STEPS clocks before,
// if i_used was set since. In clocks without it the registers are left at x: that costs nothing in hardware, and a simulator can
// skip the computation.
// BITS (2 to 32) is the width of the root. STEPS, which divides it, is how many digits are found between two registers: more
// take fewer registers and a slower clock.
`default_nettype none
module square_root #(
    parameter BITS  = 22,
    parameter STEPS = 2
) (
    input  wire              clk,
    input  wire              i_used,
    input  wire [2*BITS-1:0] i_radicand,
    output wire [BITS-1:0]   o_root
);
    localparam STAGES = BITS / STEPS;

    generate
        if (BITS < 2 || BITS > 32) bits_out_of_range error();
        if (STEPS < 1 || BITS % STEPS != 0) steps_do_not_divide_bits error();
    endgenerate

    // Before each stage: the root so far, the rest, which is at most twice the root, and the radicand's bits still to come.
    wire [BITS:0]     root    [0:STAGES];
    wire [BITS:0]     rest    [0:STAGES];
    wire [2*BITS-1:0] to_come [0:STAGES];
    assign root[0]    = {(BITS+1){1'b0}};
    assign rest[0]    = {(BITS+1){1'b0}};
    assign to_come[0] = i_radicand;
    assign o_root     = root[STAGES][BITS-1:0];

    genvar s;
    generate
        for (s = 0; s < STAGES; s = s + 1) begin : stage
            localparam DIGITS = (s + 1) * STEPS;  // of the root, after this stage
            wire [DIGITS:0]    root_in = root[s][DIGITS:0];
            wire [DIGITS:0]    rest_in = rest[s][DIGITS:0];
            wire [2*BITS-1:0]  to_come_in = to_come[s];
            reg [DIGITS:0]     root_d, root_q, rest_d, rest_q;
            reg [DIGITS+1:0]   brought, trial;
            reg [2*BITS-1:0]   to_come_d, to_come_q;
            integer i;
            always @* begin
                {root_d, rest_d} = {2*(DIGITS+1){1'bx}};
                {brought, trial} = {2*(DIGITS+2){1'bx}};
                to_come_d        = {2*BITS{1'bx}};
                if (i_used) begin
                    {root_d, rest_d, to_come_d} = {root_in, rest_in, to_come_in};
                    for (i = 0; i < STEPS; i = i + 1) begin
                        brought   = {rest_d[DIGITS-1:0], to_come_d[2*BITS-1 -: 2]};
                        trial     = brought - {root_d[DIGITS-1:0], 2'b01};  // below 0 when its top bit is set
                        rest_d    = trial[DIGITS+1] ? brought[DIGITS:0] : trial[DIGITS:0];
                        root_d    = {root_d[DIGITS-1:0], !trial[DIGITS+1]};
                        to_come_d = to_come_d << 2;
                    end
                end
            end
            always @(posedge clk) {root_q, rest_q, to_come_q} <= {root_d, rest_d, to_come_d};
            assign to_come[s+1] = to_come_q;
            if (DIGITS < BITS) begin : more
                assign root[s+1] = {{(BITS-DIGITS){1'b0}}, root_q};
                assign rest[s+1] = {{(BITS-DIGITS){1'b0}}, rest_q};
            end else begin : last
                assign root[s+1] = root_q;
                assign rest[s+1] = rest_q;
            end
        end
    endgenerate

`ifdef FORMAL
    `include "formal/square_root.vh"
`endif
endmodule
`default_nettype wire
