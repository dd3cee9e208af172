// SPDX-License-Identifier: Apache-2.0
//
// Says what to play next: a stream of (index, dwell) from one selected index, from sequence memory, or from the live FIFO.
//
// Each command strobe changes the mode at once and raises o_preempt for one clock, which makes the memory controller
// drop what it has prepared and the cycle controller change at the next boundary. When a selected index or a sequence has
// had its time, one last entry, silence for ever, is offered. Sequence entries are fetched ahead: 2 clocks each.
`default_nettype none
module index_source #(
    parameter SEQUENCE_DEPTH = 1024
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
    output wire [15:0] o_sequence_address,
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
    output wire [1:0]  o_mode
);
    localparam [1:0] IDLE = 2'd0, SINGLE = 2'd1, SEQUENCE = 2'd2, LIVE = 2'd3;
    localparam [15:0] TOP_ENTRY = SEQUENCE_DEPTH[15:0] - 16'd1;

    reg [1:0]  mode_q;
    reg        offer_q;      // single, sequence, or the last silence: entry_q holds an entry
    reg [31:0] entry_q;
    reg [1:0]  fetch_q;      // one-hot: address out, word in
    reg        header_q;     // the word being fetched is the sequence header
    reg [15:0] first_q, entry_number_q, left_q, length_q, loops_q;

    wire enter_live = i_live && mode_q != LIVE;
    wire [15:0] header_length = i_sequence_word[15:0];

    assign o_mode             = mode_q;
    assign o_fetching         = fetch_q[0];
    assign o_sequence_address = header_q ? 16'd0 : entry_number_q;
    assign o_entry            = mode_q == LIVE ? i_live_valid : offer_q;
    assign {o_dwell, o_index} = mode_q == LIVE ? i_live_entry : entry_q;
    assign o_live_take        = mode_q == LIVE && i_take;
    assign o_live_clear       = i_select || i_start || i_stop;

    always @(posedge clk) begin
        o_preempt <= !rst && (i_select || i_start || i_stop || enter_live);
        fetch_q   <= {fetch_q[0], 1'b0};
        if (rst) begin
            mode_q  <= IDLE;
            offer_q <= 1'b0;
            fetch_q <= 2'b00;
        end else if (i_select) begin
            mode_q  <= SINGLE;
            offer_q <= 1'b1;
            entry_q <= {i_argument_1, i_argument_0};
            fetch_q <= 2'b00;
        end else if (i_start) begin
            mode_q         <= SEQUENCE;
            offer_q        <= 1'b0;
            header_q       <= i_argument_1 == 16'd0;
            first_q        <= i_argument_0;
            entry_number_q <= i_argument_0;
            length_q       <= i_argument_1;
            left_q         <= i_argument_1;
            loops_q        <= i_argument_2;
            fetch_q        <= 2'b01;
        end else if (i_stop) begin
            finish;
        end else if (enter_live) begin
            mode_q  <= LIVE;
            offer_q <= 1'b0;
            fetch_q <= 2'b00;
        end else if (fetch_q[1] && header_q) begin
            header_q       <= 1'b0;
            first_q        <= 16'd1;
            entry_number_q <= 16'd1;
            length_q       <= header_length;
            left_q         <= header_length;
            loops_q        <= i_sequence_word[31:16];
            if (header_length == 16'd0 || header_length > TOP_ENTRY) finish;
            else fetch_q <= 2'b01;
        end else if (fetch_q[1]) begin
            offer_q <= 1'b1;
            entry_q <= i_sequence_word;
        end else if (offer_q && i_take) begin
            offer_q <= 1'b0;
            if (mode_q == SINGLE && o_dwell != 16'd0) finish;
            if (mode_q == SEQUENCE) next_entry;
        end
    end

    task finish;  // offer silence once; nothing follows it
        begin
            mode_q  <= IDLE;
            offer_q <= 1'b1;
            entry_q <= 32'd0;
            fetch_q <= 2'b00;
        end
    endtask

    task next_entry;
        begin
            left_q         <= left_q - 1'b1;
            entry_number_q <= entry_number_q + 1'b1;
            fetch_q        <= 2'b01;
            if (left_q == 16'd1) begin
                left_q         <= length_q;
                entry_number_q <= first_q;
                if (loops_q == 16'd1) finish;
                if (loops_q != 16'd0) loops_q <= loops_q - 1'b1;
            end
        end
    endtask
endmodule
`default_nettype wire
