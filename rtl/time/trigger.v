// SPDX-License-Identifier: Apache-2.0
//
// The trigger pins and the test output: marks events at o_trigger with their clocks, and says when the trigger input comes.
//
// o_trigger rises one clock after the event at the pins (i_cycle_start, i_playing) and stays high for the number of clocks asked for. i_trigger
// may be any signal: a change counts after it has lasted for in_least clocks behind its first. o_fires starts the command that waits for the
// trigger. While o_mute is high no pulse may reach the pins. This module never enables outputs; it only holds them low, or says when something
// begins.
// The clock counts from power-up. A stamp is the clock in which the pin has its new level, for both pins alike, whatever in_least is.
// The settings are written one word a strobe; o_word follows i_read_address by one clock. Read-only words are those of the last i_answer.
// Settings, clock and counts have no reset; rst ends a pulse and makes the input inactive.
`default_nettype none
`include "interface.vh"
module trigger #(
    parameter CHANNELS = 100
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_set,          // strobe
    input  wire [4:0]  i_set_address,
    input  wire [15:0] i_set_word,
    input  wire        i_answer,       // strobe: a reply begins
    input  wire [4:0]  i_read_address,
    output reg  [15:0] o_word,
    // What happens at the pins
    input  wire [CHANNELS-1:0] i_pins,
    input  wire        i_enabled,
    input  wire        i_playing,
    input  wire        i_cycle_start,  // strobe, with
    input  wire [1:0]  i_tag,          // {an entry with a mark begins, a pass begins}
    input  wire [15:0] i_index,
    input  wire        i_samples,      // strobe: the modulation has taken its first sample
    output wire        o_trigger,
    output wire        o_test,
    // What comes from outside
    input  wire        i_trigger,      // not synchronous to clk
    output reg         o_fires,
    output wire        o_mute
);
    localparam CHANNEL_BITS = $clog2(CHANNELS);
    localparam [16:0] LATENCY = 17'd2;  // of the synchronizer

    reg [47:0] clock_q;
    wire [47:0] clock_d = clock_q + 48'd1;
    initial clock_q = 48'd0;
    always @(posedge clk) clock_q <= clock_d;

    // ---- Settings

    reg [2:0]  event_q, in_form_q;
    reg [15:0] periods_q, least_q;
    reg [23:0] length_q;
    reg [1:0]  test_q;
    reg [CHANNEL_BITS-1:0] channel_q;
    wire [15:0] set_word = i_set_word;
    initial {event_q, in_form_q, periods_q, least_q, length_q, test_q, channel_q} = {(64+CHANNEL_BITS){1'b0}};
    always @(posedge clk) if (i_set) case (i_set_address)
        `HG_TRIGGER_OUT_FORM:        event_q         <= set_word[2:0];
        `HG_TRIGGER_OUT_PERIODS:     periods_q       <= set_word;
        `HG_TRIGGER_OUT_LENGTH_LOW:  length_q[15:0]  <= set_word;
        `HG_TRIGGER_OUT_LENGTH_HIGH: length_q[23:16] <= set_word[7:0];
        `HG_TRIGGER_IN_FORM:         in_form_q       <= set_word[2:0];
        `HG_TRIGGER_IN_LEAST:        least_q         <= set_word;
        `HG_TRIGGER_TEST_FORM:       test_q          <= set_word[1:0];
        `HG_TRIGGER_TEST_CHANNEL:    channel_q       <= set_word[CHANNEL_BITS-1:0];
        default: ;
    endcase

    // ---- Out

    reg        playing_q, samples_q, happens;
    reg [15:0] left_q;   // carrier periods before the next one that is an event
    reg [23:0] high_q;   // clocks for which the output is still high
    reg [15:0] out_count_q;
    reg [47:0] out_clock_q;
    assign o_trigger = high_q != 24'd0;
    always @* case (event_q)
        `HG_EVENT_START:   happens = i_playing && !playing_q;
        `HG_EVENT_MARK:    happens = i_cycle_start && i_enabled && i_tag[1];
        `HG_EVENT_PASS:    happens = i_cycle_start && i_enabled && i_tag[0];
        `HG_EVENT_PERIOD:  happens = i_cycle_start && left_q == 16'd0;
        `HG_EVENT_SAMPLES: happens = i_cycle_start && samples_q;
        default:           happens = 1'b0;
    endcase

    initial {playing_q, samples_q, left_q, high_q, out_count_q, out_clock_q} = 106'd0;
    always @(posedge clk) begin
        playing_q <= i_playing;
        samples_q <= i_samples || (samples_q && !i_cycle_start);
        if (i_set && (i_set_address == `HG_TRIGGER_OUT_FORM || i_set_address == `HG_TRIGGER_OUT_PERIODS)) left_q <= 16'd0;
        else if (i_cycle_start) left_q <= left_q != 16'd0 ? left_q - 16'd1 : periods_q == 16'd0 ? 16'd0 : periods_q - 16'd1;
        if (rst) high_q <= 24'd0;
        else if (happens) high_q <= length_q == 24'd0 ? 24'd1 : length_q;
        else if (o_trigger) high_q <= high_q - 24'd1;
        if (happens) {out_count_q, out_clock_q} <= {out_count_q + 16'd1, clock_d};
    end

    // ---- In

    wire       level;
    reg  [1:0] known_q;   // the synchronizer shows the pin since the last reset
    reg        active_q;
    reg [15:0] stays_q;   // clocks for which the input has differed from that
    reg [15:0] in_count_q;
    reg [47:0] in_clock_q;
    wire low = in_form_q[0], in_level = in_form_q[1], gates = in_form_q[2];
    synchronizer #(.RESET_VALUE(1'b0)) pin (.clk(clk), .rst(rst), .i_foreign(i_trigger), .o_synchronous(level));
    wire differs = (known_q[1] && (level != low)) != active_q;
    wire turns   = differs && stays_q >= least_q;
    wire comes   = turns && !active_q;
    assign o_mute = gates && !active_q;

    initial {known_q, active_q, stays_q, o_fires, in_count_q, in_clock_q} = 84'd0;
    always @(posedge clk) begin
        known_q <= rst ? 2'd0 : {known_q[0], 1'b1};
        stays_q <= rst || turns || !differs ? 16'd0 : stays_q + 16'd1;
        active_q <= !rst && active_q != turns;
        o_fires  <= !rst && (in_level ? active_q : comes);
        if (comes && !rst) {in_count_q, in_clock_q} <= {in_count_q + 16'd1, clock_q - {31'd0, {1'b0, stays_q} + LATENCY}};
    end

    // ---- Test

    reg        cycles_q, changes_q;
    reg [15:0] index_q;
    wire [(1<<CHANNEL_BITS)-1:0] pins = {{((1<<CHANNEL_BITS)-CHANNELS){1'b0}}, i_pins};
    assign o_test = test_q == `HG_TEST_CARRIER ? pins[channel_q] : test_q == `HG_TEST_CYCLE ? cycles_q : test_q == `HG_TEST_INDEX && changes_q;
    initial {cycles_q, changes_q, index_q} = 18'd0;
    always @(posedge clk) begin
        cycles_q  <= cycles_q ^ i_cycle_start;
        changes_q <= changes_q ^ (i_index != index_q);
        index_q   <= i_index;
    end

    // ---- What is told

    reg [175:0] told_q;
    always @(posedge clk) begin
        if (i_answer) told_q <= {in_clock_q, in_count_q, out_clock_q, out_count_q, clock_q};
        case (i_read_address)
            `HG_TRIGGER_OUT_FORM:        o_word <= {13'd0, event_q};
            `HG_TRIGGER_OUT_PERIODS:     o_word <= periods_q;
            `HG_TRIGGER_OUT_LENGTH_LOW:  o_word <= length_q[15:0];
            `HG_TRIGGER_OUT_LENGTH_HIGH: o_word <= {8'd0, length_q[23:16]};
            `HG_TRIGGER_IN_FORM:         o_word <= {13'd0, in_form_q};
            `HG_TRIGGER_IN_LEAST:        o_word <= least_q;
            `HG_TRIGGER_TEST_FORM:       o_word <= {14'd0, test_q};
            `HG_TRIGGER_TEST_CHANNEL:    o_word <= {{(16-CHANNEL_BITS){1'b0}}, channel_q};
            `HG_TRIGGER_NOW_LOW:         o_word <= told_q[15:0];
            `HG_TRIGGER_NOW_MIDDLE:      o_word <= told_q[31:16];
            `HG_TRIGGER_NOW_HIGH:        o_word <= told_q[47:32];
            `HG_TRIGGER_OUT_COUNT:       o_word <= told_q[63:48];
            `HG_TRIGGER_OUT_LOW:         o_word <= told_q[79:64];
            `HG_TRIGGER_OUT_MIDDLE:      o_word <= told_q[95:80];
            `HG_TRIGGER_OUT_HIGH:        o_word <= told_q[111:96];
            `HG_TRIGGER_IN_COUNT:        o_word <= told_q[127:112];
            `HG_TRIGGER_IN_LOW:          o_word <= told_q[143:128];
            `HG_TRIGGER_IN_MIDDLE:       o_word <= told_q[159:144];
            default:                     o_word <= told_q[175:160];
        endcase
    end

`ifdef FORMAL
    `include "formal/trigger.vh"
`endif
endmodule
`default_nettype wire
