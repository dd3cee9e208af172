// SPDX-License-Identifier: Apache-2.0
//
// Lets START, PUSH and MODULATE wait: for a carrier period, or START and MODULATE for the end of what plays.
//
// GATE names the period that the next command waits for. A waiting command has been answered already; this module holds its arguments and
// says when its turn comes. A command that waits for a period goes on when i_count is one less, because a change takes effect with the next
// period. So the change begins in the named period or, if its first record takes longer than a period to load, in a later one, never
// before. If that moment had passed when the command came, the command acts at once, and o_late strobes. Commands can wait for one period
// at a time: o_busy says that the arguments name another one.
// With TRIGGER, START and MODULATE can also wait for i_trigger. Whatever switches outputs off ends that wait: a command that was armed
// while outputs were on does not begin after outputs have been enabled again.
// If a START and a PUSH wait for the same period, the later one stays, as without a gate.
// Indices that are pushed behind a gate go into the live FIFO at once, and o_closed keeps the FIFO from giving them out. A START that does
// not wait empties the FIFO. If a PUSH is writing then, the rest of that PUSH is taken back, too.
`default_nettype none
`include "interface.vh"
module schedule #(
    parameter TRIGGER = 0
) (
    input  wire        clk,
    input  wire        rst,
    input  wire [47:0] i_count,       // the period at the pins
    input  wire [1:0]  i_mode,
    // Commands: strobes, and their arguments
    input  wire        i_gate,
    input  wire        i_select,
    input  wire        i_start,
    input  wire        i_stop,
    input  wire        i_modulate,
    input  wire        i_trigger,     // it comes, when TRIGGER is not 0
    input  wire        i_off,         // outputs are switched off: nothing waits for the trigger any more
    input  wire        i_forget,      // the gate's command is not carried out, or a new session has begun
    input  wire [15:0] i_argument_0,
    input  wire [15:0] i_argument_1,
    input  wire [15:0] i_argument_2,
    output wire        o_busy,        // GATE would be refused with these arguments; valid two clocks after they are in place
    output wire        o_no_push,     // the next command cannot be a PUSH, whose indices would come too early or not at all
    // START, to index_source
    output wire        o_start,       // strobe
    output wire        o_follow,      // a START waits for the end of what plays
    input  wire        i_followed,    // strobe: it has begun
    output wire [15:0] o_argument_0,
    output wire [15:0] o_argument_1,
    output wire [15:0] o_argument_2,
    // PUSH, to live_fifo and index_source
    input  wire        i_push,
    input  wire        i_keep,
    input  wire        i_take_back,
    input  wire        i_clear,       // strobe: the FIFO is emptied
    output wire        o_keep,
    output wire        o_take_back,
    output wire        o_mark,        // strobe, with o_keep: what is kept is behind the gate
    output wire        o_closed,      // what is behind the mark must wait
    output wire        o_live,        // strobe: indices can be played
    // MODULATE, to modulation
    output wire        o_modulate,    // strobe: the arguments of the last MODULATE take effect
    output wire        o_at_pass_end, // with o_modulate: when the samples' present pass has ended
    output wire        o_waiting,
    output wire        o_late         // strobe
);
    localparam [47:0] NONE = 48'd0, END = {48{1'b1}}, AT_TRIGGER = END - 48'd1;

    // ---- The gate

    reg  [47:0] gate_q;     // the last period that was named
    reg         armed_q;    // the next command waits
    reg         at_end_q;   // for the end of what plays
    reg         reached_q;  // the period is the next one, or has come
    reg         differs_q;  // the arguments name another one
    reg         start_q, follow_q, live_q, modulate_q;  // what waits; follow_q alone is not for the period
    wire [47:0] named      = {i_argument_2, i_argument_1, i_argument_0};
    wire        for_period = armed_q && !at_end_q;
    wire        gated      = for_period && !reached_q;
    wire        uses_gate  = i_start || i_keep || i_modulate;
    assign o_busy    = differs_q && (start_q || live_q || modulate_q);
    // Nothing waits for the trigger that outputs were not enabled for.
    wire by_trigger = TRIGGER != 0 && gate_q == AT_TRIGGER;
    wire disarms    = by_trigger && i_off;
    wire for_end    = armed_q && at_end_q;
    assign o_no_push = armed_q && (at_end_q || by_trigger);
    assign o_waiting = start_q || follow_q || live_q || modulate_q;
    assign o_late    = uses_gate && for_period && reached_q && !by_trigger;

    always @(posedge clk) begin
        reached_q <= by_trigger ? i_trigger : i_count + 48'd1 >= gate_q;
        differs_q <= named != gate_q && named != NONE && named != END;
        if (i_gate && named != NONE && named != END) gate_q <= named;
        if (i_gate) {armed_q, at_end_q} <= {named != NONE, named == END};
        else if (rst || uses_gate || i_stop || i_forget) armed_q <= 1'b0;
    end

    // ---- START

    reg [47:0] waiting_q;  // its arguments
    wire others = i_select || i_start || i_stop;
    wire fires  = start_q && reached_q && !others && !disarms;
    assign o_start  = (i_start && !(armed_q && (at_end_q || !reached_q))) || fires;
    assign o_follow = follow_q && !others;
    assign {o_argument_2, o_argument_1, o_argument_0} = i_select || i_start ? named : waiting_q;

    always @(posedge clk) begin
        if (i_start) waiting_q <= named;
        if (rst || i_select || i_stop || (o_live && i_mode != `HG_MODE_LIVE)) {start_q, follow_q} <= 2'b00;
        else if (i_start) {start_q, follow_q} <= {gated && !disarms, for_end};
        else begin
            if (fires || disarms || (o_keep && gated)) start_q <= 1'b0;  // indices that were sent later play in its place
            if (i_followed) follow_q <= 1'b0;
        end
    end

    // ---- PUSH

    reg  pushing_q;  // provisional indices are in the FIFO
    reg  cut_q;      // some of them are gone
    assign o_keep      = i_keep && !cut_q;
    assign o_take_back = i_take_back || (i_keep && cut_q);
    assign o_mark      = o_keep && gated && !live_q;
    assign o_closed    = live_q;
    assign o_live      = (o_keep && !gated && !live_q) || (live_q && reached_q);

    always @(posedge clk) begin
        if (rst || i_keep || i_take_back) {pushing_q, cut_q} <= 2'b00;
        else begin
            if (i_push) pushing_q <= 1'b1;
            if (i_clear && (i_push || pushing_q)) cut_q <= 1'b1;
        end
        if (rst || i_clear) live_q <= 1'b0;
        else if (o_mark) live_q <= 1'b1;
        else if (reached_q) live_q <= 1'b0;
    end

    // ---- MODULATE

    wire modulates = modulate_q && reached_q && !i_modulate && !disarms;
    assign o_modulate    = (i_modulate && !gated) || modulates;
    assign o_at_pass_end = i_modulate && for_end;
    always @(posedge clk) begin
        if (rst || i_stop || disarms) modulate_q <= 1'b0;
        else if (i_modulate) modulate_q <= gated;
        else if (modulates) modulate_q <= 1'b0;
    end

`ifdef FORMAL
    `include "formal/schedule.vh"
`endif
endmodule
`default_nettype wire
