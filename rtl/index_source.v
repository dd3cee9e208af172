// SPDX-License-Identifier: Apache-2.0
//
// Says what to play next: a stream of (index, dwell) from one selected index, from sequence memory, or from the live FIFO.
//
// A command strobe changes the mode at once and raises o_preempt for one clock. Then the memory controller drops the record that it has
// prepared, and the cycle controller changes at the next cycle boundary. When a selected index or a sequence has ended, one last entry is
// offered: silence for ever. o_mode stays until that entry is taken, which is when the last audible index begins to play; with amplitudes, up to a
// carrier period before. So whoever reads present index 0 and mode idle knows that nothing is to come. Sequence entries are fetched ahead and
// take 3 clocks each. o_entry/i_take is valid/ready.
// With i_follow a START waits for the end of what plays, and begins without a preempt, so that its first entry follows the last one: a selected
// index whose dwell is 0 at once, another one after its dwell, a sequence after its last entry, or after the last entry of its present pass when it
// is played for ever, live indices when none is left. If the silence behind the end was offered already, it may have been loaded; o_drop then
// asks for that silence alone to be dropped.
// After a reset the sequence header is read without a command. If its autostart bit is set, and no host has taken over since power-up, the sequence
// starts and o_autostart strobes. So a bitstream with an image plays without a host, and goes on after the PLL has lost its lock for a moment. While
// i_fills is high the memories are being filled, and the header starts nothing. SEQUENCE_DEPTH is the core's.
`default_nettype none
`include "interface.vh"
module index_source #(
    parameter SEQUENCE_DEPTH = 1024,
    parameter BITS           = $clog2(SEQUENCE_DEPTH)  // follows from it
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_select,  // strobes of commands; their arguments are valid in the same clock
    input  wire        i_start,
    input  wire        i_stop,
    input  wire        i_live,    // strobe: indices can be played
    input  wire        i_follow,  // a START waits for the end of what plays; its arguments are valid while no command strobes
    output wire        o_followed,  // it begins
    input  wire        i_host,    // strobe: a host has done more than ask
    input  wire        i_fills,
    input  wire        i_header,  // strobe: a host writes the lower half of the sequence header, i_header_word
    input  wire [14:0] i_header_word,  // its length
    output reg         o_header_valid,  // its length is in range
    input  wire [15:0] i_argument_0,  // select: index; start: first entry
    input  wire [15:0] i_argument_1,  // select: dwell; start: length, 0 as the sequence header says
    input  wire [15:0] i_argument_2,  // start: loops, 0 for ever
    output wire        o_fetching,    // o_sequence_address is in use
    output wire [BITS-1:0] o_sequence_address,
    input  wire [31:0] i_sequence_word,
    input  wire        i_live_valid,
    input  wire        i_live_empty,
    input  wire [31:0] i_live_entry,
    output wire        o_live_take,
    output wire        o_live_clear,
    output reg         o_preempt,
    output reg         o_drop,    // strobe: silence that was prepared is not wanted
    output wire        o_entry,
    input  wire        i_take,
    output wire [15:0] o_index,
    output wire [15:0] o_dwell,
    output wire [1:0]  o_tag,         // of an entry of a sequence: {it has a mark, a pass begins with it}
    output wire [1:0]  o_mode,
    output wire        o_alone,      // no host has taken over since power-up
    output wire        o_autostart   // strobe
);
    localparam [1:0] IDLE = `HG_MODE_IDLE, SINGLE = `HG_MODE_SINGLE, SEQUENCE = `HG_MODE_SEQUENCE, LIVE = `HG_MODE_LIVE;
    localparam [14:0] TOP_ENTRY = SEQUENCE_DEPTH[14:0] - 15'd1;
    localparam [BITS-1:0] ONE = 1;

    reg [1:0]      mode_q;
    reg [1:0]      ended_q;      // the mode whose last entry was taken, while the silence behind it is offered
    reg            offer_q;      // entry_q holds an entry to be played (not used in live mode)
    reg [31:0]     entry_q;
    reg [1:0]      tag_q;        // of it
    reg [2:0]      fetch_q;      // one-hot: the address is out, the word is being read, the word is here
    reg            header_q;     // the word being fetched is the sequence header
    reg [BITS-1:0] first_q, last_q, number_q;  // first and last entry of the sequence; the one to be fetched
    reg [15:0]     loops_q;
    reg            after_reset_q;  // neither a header has been looked at since reset, nor a command come
    reg            alone_q;      // no host has taken over since power-up

    // The word that arrives, and what becomes of it.
    wire        header    = fetch_q[2] && header_q;
    wire        fetched   = fetch_q[2] && !header_q;
    wire [14:0] length    = i_sequence_word[14:0];
    wire        in_range  = length != 15'd0 && length <= TOP_ENTRY;
    wire        new_in_range = i_header_word != 15'd0 && i_header_word <= TOP_ENTRY;  // i_header arrives late in the clock
    wire        plays     = in_range && (!after_reset_q || o_autostart);
    wire        commanded = i_select || i_start || i_stop;
    wire        enter_live = i_live && mode_q != LIVE;
    wire        taken     = offer_q && i_take && !fetch_q[2];
    wire        at_last   = number_q == last_q;
    wire        sequence_ends = mode_q == SEQUENCE && at_last && loops_q == 16'd1;
    wire        at_end    = mode_q == IDLE   ? fetch_q == 3'd0
                          : mode_q == SINGLE ? (entry_q[31:16] == 16'd0 ? !offer_q : taken)
                          : mode_q == LIVE   ? i_live_empty && !i_live
                          : taken && at_last && loops_q[15:1] == 15'd0;
    wire        follows   = i_follow && at_end && !commanded && !enter_live && !rst;
    // Silence is offered as the last entry.
    wire        finish    = i_stop || (!commanded && !enter_live && !follows && ((header && !plays)
                            || (taken && ((mode_q == SINGLE && entry_q[31:16] != 16'd0) || sequence_ends))));
    wire        starts    = i_start || follows;
    wire [BITS-1:0] first_d = starts ? i_argument_0[BITS-1:0] : ONE;

    assign o_mode             = mode_q | ended_q;  // one of them is IDLE, which is 0
    assign o_alone            = alone_q;
    assign o_followed         = follows;
    assign o_fetching         = fetch_q[0];
    assign o_sequence_address = header_q ? {BITS{1'b0}} : number_q;
    assign o_entry            = mode_q == LIVE ? i_live_valid : offer_q;
    assign {o_dwell, o_index} = mode_q == LIVE ? i_live_entry : entry_q;
    assign o_tag              = mode_q == LIVE ? 2'b00 : tag_q;
    assign o_live_take        = mode_q == LIVE && i_take;
    assign o_live_clear       = commanded;
    assign o_autostart        = after_reset_q && alone_q && !i_fills && header && in_range && i_sequence_word[`HG_AUTOSTART_BIT] && !rst;

    initial {alone_q, after_reset_q, fetch_q} = 5'b11000;  // so nothing starts before reset, whatever the registers wake up with
    always @(posedge clk) begin
        o_preempt <= !rst && (commanded || enter_live);
        o_drop    <= follows && mode_q == IDLE && (!offer_q || i_take);
        fetch_q   <= {fetch_q[1:0], 1'b0};
        if (header || commanded || enter_live) after_reset_q <= 1'b0;
        if (i_host) alone_q <= 1'b0;
        if (header || i_header) o_header_valid <= i_header ? new_in_range : in_range;
        if (rst || commanded || enter_live || follows || (offer_q && i_take)) ended_q <= IDLE;
        if (rst) begin
            after_reset_q <= 1'b1;
            mode_q   <= IDLE;
            offer_q  <= 1'b0;
            fetch_q  <= 3'b001;
            header_q <= 1'b1;
        end else if (commanded || enter_live) begin
            mode_q   <= i_select ? SINGLE : i_start ? SEQUENCE : i_stop ? IDLE : LIVE;
            offer_q  <= i_select || finish;
            fetch_q  <= {2'b00, i_start && !i_select};
            header_q <= i_argument_1 == 16'd0;
        end else if (follows) begin
            mode_q   <= SEQUENCE;
            offer_q  <= 1'b0;
            fetch_q  <= 3'b001;
            header_q <= i_argument_1 == 16'd0;
        end else begin
            if (finish) {mode_q, ended_q} <= {IDLE, mode_q};
            else if (o_autostart) mode_q <= SEQUENCE;
            if (finish || fetched) offer_q <= 1'b1;
            else if (taken) offer_q <= 1'b0;
            if ((header && plays) || (taken && mode_q == SEQUENCE && !sequence_ends)) fetch_q <= 3'b001;
            if (header) header_q <= 1'b0;
        end
    end

    // These registers need no reset: they are read only after they have been written.
    always @(posedge clk) begin
        if (finish) {tag_q, entry_q} <= 34'd0;
        else if (i_select) {tag_q, entry_q} <= {2'b00, i_argument_1, i_argument_0};
        else if (fetched) begin
            entry_q <= {i_sequence_word[31:16], 1'b0, i_sequence_word[14:0]};
            tag_q   <= {i_sequence_word[`HG_MARK_BIT], number_q == first_q};
        end
        if (starts || header) begin
            first_q  <= first_d;
            number_q <= first_d;
            last_q   <= starts ? i_argument_0[BITS-1:0] + i_argument_1[BITS-1:0] - ONE : length[BITS-1:0];
            loops_q  <= starts ? i_argument_2 : i_sequence_word[31:16];
        end else if (taken) begin
            number_q <= at_last ? first_q : number_q + ONE;
            if (at_last && loops_q != 16'd0) loops_q <= loops_q - 1'b1;
        end
    end

`ifdef FORMAL
    `include "formal/index_source.vh"
`endif
endmodule
`default_nettype wire
