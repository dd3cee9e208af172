// SPDX-License-Identifier: Apache-2.0
//
// Keeps the carrier cycles of several boards in step over one wire, SYNC, although each board has a crystal of its own.
//
// Nothing but the last clock of a cycle is ever changed: it lasts longer while o_hold is high. No tick is skipped, because channels
// find the ends of their pulses by comparing ticks for equality. The master makes every second cycle a clock longer, which is
// more than crystals differ by, so a slave comes to the end of its cycle first and waits there for the master.
// SYNC rises LEAD clocks before the master's cycle ends. It is high for 8, 16 or 24 clocks: a 0, a 1 or a mark, of which sync_number
// makes the cycle's number. Longer pulses, as of a function generator, say nothing. A slave
//   seeks:   it waits 8 clocks in every cycle until the edge comes when it is due. After 512 such cycles in a row it is in step.
//   follows: it looks for the edge only where it must come, within 8 clocks, and counts how many clocks it waits in 512 cycles.
//   goes on: without an edge it waits as often as it did, so it drifts by a clock in 512 cycles at most. After 16 cycles in a row
//            without an edge in time it is out of step (o_lost) and seeks.
// i_last is the last clock of a cycle of cycle_controller, which repeats it while o_hold. Of i_symbol and o_symbol 0 and 1 are bits, 2 is
// the mark, 3 is none. i_symbol is of the master's next cycle; o_symbol, with the strobe o_ends, is of a slave's.
// PERIOD_CLOCKS (256 to 2000) is the cycle of all boards. Crystals may differ by 1 / (2 · PERIOD_CLOCKS), 400 ppm.
`default_nettype none
`include "interface.vh"
module carrier_sync #(
    parameter PERIOD_CLOCKS = 1250
) (
    input  wire       clk,
    input  wire       rst,
    input  wire [1:0] i_role,      // changes with rst only
    input  wire       i_sync,      // the wire, not synchronous to clk
    output reg        o_sync,
    input  wire       i_last,
    output wire       o_hold,
    input  wire [1:0] i_symbol,
    output reg  [1:0] o_symbol,
    output wire       o_ends,
    output reg        o_in_step,   // of a slave
    output wire       o_missed,    // strobe: it had no edge in time while it was in step
    output wire       o_lost       // strobe: it is not in step any more
);
    localparam LEAD  = 48;
    // Clocks from the master's decision to raise SYNC to a slave's first one of since_q: at least, so a slave is early by up to one.
    localparam DELAY = 6;
    localparam integer RISE_CLOCK = PERIOD_CLOCKS - LEAD, FIRST_CLOCK = PERIOD_CLOCKS - 2 - (LEAD - DELAY) - 8;
    localparam [10:0] RISE = RISE_CLOCK[10:0], FIRST = FIRST_CLOCK[10:0];
    localparam [6:0] DUE = LEAD[6:0] - DELAY[6:0], UNHEARD = 7'h7f;
    localparam [3:0] MOST = 4'd8;  // clocks that a cycle may wait

    generate
        if (PERIOD_CLOCKS < 256 || PERIOD_CLOCKS > 2000) period_clocks_out_of_range error();
    endgenerate

    wire master = i_role == `HG_ROLE_MASTER, slave = i_role == `HG_ROLE_SLAVE;

    // ---- The wire

    reg  [10:0] clock_q;  // of this cycle
    reg  [6:0]  since_q;  // clocks since the edge, until UNHEARD
    reg         level_q;
    reg         turn_q;   // of the master's cycles every second one is longer
    wire        longer  = !turn_q;
    wire        level;
    synchronizer #(.RESET_VALUE(1'b0)) wire_end (.clk(clk), .rst(rst), .i_foreign(i_sync), .o_synchronous(level));
    wire [10:0] place = clock_q - FIRST;
    wire        expected = place < 11'd16 && since_q == UNHEARD;
    wire        rises = master ? clock_q == RISE + {10'd0, longer} : slave && level && !level_q && (!o_in_step || expected);
    initial o_sync = 1'b0;
    always @(posedge clk) begin
        level_q <= level;
        o_sync  <= !rst && master && since_q < {2'd0, i_symbol + 2'd1, 3'd0};
        if (rst || i_role == `HG_ROLE_ALONE) since_q <= UNHEARD;
        else if (rises) since_q <= 7'd0;
        else if (since_q != UNHEARD) since_q <= since_q + 1'b1;
        if (rst || o_ends) clock_q <= 11'd0;
        else if (clock_q != 11'h7ff && i_role != `HG_ROLE_ALONE) clock_q <= clock_q + 1'b1;
        // The middle of each place in which SYNC may have fallen.
        if (o_ends) o_symbol <= 2'd3;
        else if (rises) o_symbol <= 2'd0;
        else if (since_q == 7'd11 || since_q == 7'd19 || since_q == 7'd27) o_symbol <= o_symbol + {1'b0, level};
    end

    // ---- How long the cycle's last clock lasts

    reg  [3:0] waited_q;
    reg  [8:0] part_q;    // of a clock that is to be waited in later cycles
    reg  [8:0] rate_q;    // of a clock that was waited a cycle
    wire       unheard = since_q == UNHEARD, early = since_q < DUE, late = since_q > DUE + 7'd7;
    wire [9:0] parts   = {1'b0, part_q} + {1'b0, rate_q};
    wire       waits   = !slave ? master && longer && waited_q == 4'd0
                       : o_in_step && unheard ? parts[9] && waited_q == 4'd0
                       : (early || (late && !o_in_step)) && waited_q != MOST;
    assign o_hold = waits;
    assign o_ends = i_last && !waits;

    // ---- In step or not

    reg  [8:0] cycles_q;  // in time, of the 512 in which waits_q counts
    reg  [8:0] waits_q;
    reg  [3:0] misses_q;
    wire       in_time = !early && since_q < DUE + 7'd2 && waited_q < 4'd3;
    wire [9:0] all     = {1'b0, waits_q} + {6'd0, waited_q};
    wire [8:0] most    = all[9] ? 9'h1ff : all[8:0];
    assign o_missed = slave && o_in_step && o_ends && !in_time;
    assign o_lost   = o_missed && misses_q == 4'hf;
    always @(posedge clk) begin
        if (rst || o_ends) waited_q <= 4'd0;
        else if (i_last && waits) waited_q <= waited_q + 1'b1;
        if (rst) turn_q <= 1'b0;
        else if (o_ends) turn_q <= !turn_q;
        if (rst) {o_in_step, cycles_q, waits_q, misses_q} <= 23'd0;
        else if (o_ends && slave) begin
            {cycles_q, waits_q} <= in_time ? {cycles_q + 1'b1, most} : 18'd0;
            if (in_time && cycles_q == 9'h1ff) {o_in_step, rate_q, waits_q} <= {1'b1, most, 9'd0};
            if (o_lost) o_in_step <= 1'b0;
            misses_q <= in_time || !o_in_step ? 4'd0 : misses_q + 1'b1;
            // Right after a clock was waited, between none and a cycle's share is left to wait: half of that is the best guess.
            part_q   <= in_time && waited_q != 4'd0 ? {1'b0, rate_q[8:1]} : in_time && parts[9] ? 9'h1ff : parts[8:0];
        end
    end

`ifdef FORMAL
    `include "formal/carrier_sync.vh"
`endif
endmodule
`default_nettype wire
