// SPDX-License-Identifier: Apache-2.0
//
// Says what to play next: a stream of (index, dwell) from one selected index, from sequence memory, or from the live FIFO.
//
// Each command strobe changes the mode at once and raises o_preempt for one clock, which makes the memory controller
// drop what it has prepared and the cycle controller change at the next boundary. When a selected index or a sequence has
// had its time, one last entry, silence for ever, is offered. Sequence entries are fetched ahead: 3 clocks each.
// Once, at power-up, the sequence header is looked at without a command: its bit 15 starts the sequence (o_autostart).
`default_nettype none
`include "interface.vh"
module index_source #(
    parameter SEQUENCE_DEPTH = 1024,
    parameter BITS           = $clog2(SEQUENCE_DEPTH)  // follows from it
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_select,  // strobes; arguments valid with them
    input  wire        i_start,
    input  wire        i_stop,
    input  wire        i_live,    // indices were pushed
    input  wire [15:0] i_argument_0,  // index   | first entry
    input  wire [15:0] i_argument_1,  // dwell   | length, 0: as the sequence header says
    input  wire [15:0] i_argument_2,  //         | loops, 0: for ever
    output wire        o_fetching,    // o_sequence_address is in use
    output wire [BITS-1:0] o_sequence_address,
    input  wire [31:0] i_sequence_word,
    input  wire        i_live_valid,
    input  wire [31:0] i_live_entry,
    output wire        o_live_take,
    output wire        o_live_clear,
    output reg         o_preempt,
    output wire        o_entry,
    input  wire        i_take,
    output wire [15:0] o_index,
    output wire [15:0] o_dwell,
    output wire [1:0]  o_mode,
    output wire        o_autostart   // strobe
);
    localparam [1:0] IDLE = 2'd0, SINGLE = 2'd1, SEQUENCE = 2'd2, LIVE = 2'd3;
    localparam [14:0] TOP_ENTRY = SEQUENCE_DEPTH[14:0] - 15'd1;
    localparam [BITS-1:0] ONE = 1;

    reg [1:0]      mode_q;
    reg            offer_q;      // single, sequence, or the last silence: entry_q holds an entry
    reg [31:0]     entry_q;
    reg [2:0]      fetch_q;      // one-hot: address out, being read, word in
    reg            header_q;     // the word being fetched is the sequence header
    reg [BITS-1:0] first_q, last_q, number_q;  // of the sequence's entries; the one to be fetched
    reg [15:0]     loops_q;
    reg            power_up_q;   // since the memories were filled by the bitstream no header has been looked at

    // Arriving words, and what becomes of them
    wire        header    = fetch_q[2] && header_q;
    wire        fetched   = fetch_q[2] && !header_q;
    wire [14:0] length    = i_sequence_word[14:0];
    wire        plays     = length != 15'd0 && length <= TOP_ENTRY && (!power_up_q || o_autostart);
    wire        commanded = i_select || i_start || i_stop;
    wire        enter_live = i_live && mode_q != LIVE;
    wire        taken     = offer_q && i_take && !fetch_q[2];
    wire        at_last   = number_q == last_q;
    wire        sequence_ends = mode_q == SEQUENCE && at_last && loops_q == 16'd1;
    // Offer silence once; nothing follows it.
    wire        finish    = i_stop || (!commanded && !enter_live && ((header && !plays)
                            || (taken && ((mode_q == SINGLE && entry_q[31:16] != 16'd0) || sequence_ends))));
    wire [BITS-1:0] first_d = header ? ONE : i_argument_0[BITS-1:0];

    assign o_mode             = mode_q;
    assign o_fetching         = fetch_q[0];
    assign o_sequence_address = header_q ? {BITS{1'b0}} : number_q;
    assign o_entry            = mode_q == LIVE ? i_live_valid : offer_q;
    assign {o_dwell, o_index} = mode_q == LIVE ? i_live_entry : entry_q;
    assign o_live_take        = mode_q == LIVE && i_take;
    assign o_live_clear       = commanded;
    assign o_autostart        = power_up_q && header && i_sequence_word[`HG_AUTOSTART_BIT] && !rst;

    initial {power_up_q, fetch_q} = 4'b1000;  // so that no chance word can start anything before reset
    always @(posedge clk) begin
        o_preempt <= !rst && (commanded || enter_live);
        fetch_q   <= {fetch_q[1:0], 1'b0};
        if (header) power_up_q <= 1'b0;
        if (rst) begin
            mode_q   <= IDLE;
            offer_q  <= 1'b0;
            fetch_q  <= {2'b00, power_up_q};
            header_q <= 1'b1;
        end else if (commanded || enter_live) begin
            mode_q   <= i_select ? SINGLE : i_start ? SEQUENCE : i_stop ? IDLE : LIVE;
            offer_q  <= i_select || finish;
            fetch_q  <= {2'b00, i_start && !i_select};
            header_q <= i_argument_1 == 16'd0;
        end else begin
            if (finish) mode_q <= IDLE;
            else if (o_autostart) mode_q <= SEQUENCE;
            if (finish || fetched) offer_q <= 1'b1;
            else if (taken) offer_q <= 1'b0;
            if ((header && plays) || (taken && mode_q == SEQUENCE && !sequence_ends)) fetch_q <= 3'b001;
            if (header) header_q <= 1'b0;
        end
    end

    // What no state machine looks at before it says so needs no reset.
    always @(posedge clk) begin
        if (finish) entry_q <= 32'd0;
        else if (i_select) entry_q <= {i_argument_1, i_argument_0};
        else if (fetched) entry_q <= i_sequence_word;
        if (i_start || header) begin
            first_q  <= first_d;
            number_q <= first_d;
            last_q   <= header ? length[BITS-1:0] : i_argument_0[BITS-1:0] + i_argument_1[BITS-1:0] - ONE;
            loops_q  <= header ? i_sequence_word[31:16] : i_argument_2;
        end else if (taken) begin
            number_q <= at_last ? first_q : number_q + ONE;
            if (at_last && loops_q != 16'd0) loops_q <= loops_q - 1'b1;
        end
    end
endmodule
`default_nettype wire
