// SPDX-License-Identifier: Apache-2.0
//
// Reads the next record out of primary memory while the present one plays, and holds it ready until it is committed.
//
// i_entry/o_take is a valid/ready stream of (index, dwell), taken when i_settled says that the shadow registers are free. The
// record's header goes into the fields below; its timings go into the shadow registers, one a clock. o_ready is first high, and
// the last timing arrives, CHANNELS + 7 clocks after the clock that takes the entry; index 0 (silence) is ready after 2.
// A record that cannot be played is refused: an index above RECORDS, a prescaler of 0, a pulse that is not shorter than its
// cycle, or reserved bits. Then o_refused strobes, and silence takes its place and dwell. i_preempt drops whatever is loading
// or loaded.
// The memory is read without pause in ascending order, and writers write in that order, too. So whoever starts first stays
// first, and a record that is written meanwhile is seen whole or not at all.
// CHANNELS and RECORDS are the core's: a load of up to 1000 channels fits in a 40 kHz period at 50 MHz, and an index has 16
// bits.
// TIMING_BITS is the width of a channel's comparator, PULSE_BITS that of the pulse length.
`default_nettype none
`include "interface.vh"
module memory_controller #(
    parameter CHANNELS     = 100,
    parameter RECORDS      = 400,
    parameter TIMING_BITS  = 16,
    parameter PULSE_BITS   = 8,
    parameter ADDRESS_BITS = $clog2(RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS))  // follows from the others
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_preempt,
    input  wire                    i_entry,
    input  wire                    i_settled,  // the shadow registers may be overwritten
    output wire                    o_take,
    input  wire [15:0]             i_index,
    input  wire [15:0]             i_dwell,
    output wire                    o_reading,  // the word at o_address is being read
    output reg  [ADDRESS_BITS-1:0] o_address,  // of a word
    input  wire [15:0]             i_word,     // two clocks after o_address
    output wire                    o_shift,
    output wire [TIMING_BITS-1:0]  o_timing,
    input  wire                    i_commit,
    output wire                    o_ready,
    output reg                     o_silent,
    output reg  [15:0]             o_index,
    output reg  [15:0]             o_dwell,
    output reg  [23:0]             o_cycle_length,
    output reg  [23:0]             o_prescaler,
    output wire [PULSE_BITS-1:0]   o_pulse_length,
    output reg                     o_refused
);
    localparam WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam WORD_BITS = $clog2(WORDS);
    localparam [26:0] STRIDE = WORDS[26:0];
    localparam [WORD_BITS-1:0] LAST = WORDS[WORD_BITS-1:0] - 1'b1;
    localparam [15:0] TOP_INDEX = RECORDS[15:0];
    localparam [1:0] IDLE = 2'd0, LOAD = 2'd1, READY = 2'd2;

    generate
        if (CHANNELS < 2 || CHANNELS > 1000) channels_out_of_range error();
        if (RECORDS < 1 || RECORDS > 65535) records_out_of_range error();
    endgenerate

    reg [1:0]            state_q;
    reg [WORD_BITS-1:0]  asked_q;    // number of the word whose address is at o_address
    reg [WORD_BITS-1:0]  comes_q;    // number of the word that is being read
    reg [WORD_BITS-1:0]  arrived_q;  // number of the word in i_word
    reg                  coming_q, arrives_q;  // those two words are of the record that is being loaded
    reg                  places_q;   // in this clock the index is checked and the record's address computed
    reg [7:0]            pulse_field_q;
    reg                  unplayable_q;

    wire [26:0] first_word = {11'd0, o_index - 16'd1} * STRIDE;  // the upper bits are 0, because the index is in range
    wire refuse_index = o_index > TOP_INDEX;
    // Used in the clock in which i_word holds the header's last word: the prescaler's upper bits and the reserved bits.
    wire [24:0] pulse_limit = 25'd1 << PULSE_BITS;
    wire unplayable = {i_word[7:0], o_prescaler[15:0]} == 24'd0 || {17'd0, pulse_field_q} >= pulse_limit || i_word[15:8] != 8'd0
                      || (o_cycle_length[23:8] == 16'd0 && pulse_field_q >= o_cycle_length[7:0]);

    assign o_take    = state_q == IDLE && i_entry && i_settled && !i_preempt;
    wire   ends      = coming_q && comes_q == LAST;  // the last word arrives in the next clock
    assign o_reading = state_q == LOAD && !places_q;
    assign o_ready   = state_q == READY;
    // A timing that does not fit the channel's comparator becomes all ones, which never matches: the channel stays silent.
    wire too_wide;
    generate
        if (TIMING_BITS < 16) begin : narrow
            assign too_wide = i_word[15:TIMING_BITS] != {(16-TIMING_BITS){1'b0}};
        end else begin : full
            assign too_wide = 1'b0;
        end
    endgenerate
    assign o_timing = too_wide ? {TIMING_BITS{1'b1}} : i_word[TIMING_BITS-1:0];
    assign o_shift        = arrives_q && arrived_q >= `HG_RECORD_HEADER_WORDS;
    assign o_pulse_length = pulse_field_q[PULSE_BITS-1:0];

    always @(posedge clk) begin
        o_refused <= 1'b0;
        coming_q  <= o_reading && !ends;
        arrives_q <= coming_q;
        if (rst || i_preempt) begin
            state_q   <= IDLE;
            {coming_q, arrives_q} <= 2'b00;
        end else case (state_q)
            IDLE: if (i_entry && i_settled) state_q <= LOAD;
            LOAD: if (places_q && (o_index == 16'd0 || refuse_index)) begin
                state_q   <= READY;
                o_silent  <= 1'b1;
                o_refused <= refuse_index;
            end else if (ends) begin
                state_q   <= READY;
                o_silent  <= unplayable_q;
                o_refused <= unplayable_q;
            end
            default: if (i_commit) state_q <= IDLE;
        endcase
    end

    // The data path needs no reset: the state machine says when its contents count.
    always @(posedge clk) begin
        places_q <= o_take;
        if (o_take) begin
            o_index   <= i_index;
            o_dwell   <= i_dwell;
            asked_q   <= {WORD_BITS{1'b0}};
        end else if (places_q) o_address <= first_word[ADDRESS_BITS-1:0];
        else if (asked_q != LAST) begin
            o_address <= o_address + 1'b1;
            asked_q   <= asked_q + 1'b1;
        end
        comes_q   <= asked_q;
        arrived_q <= comes_q;
        if (arrives_q) begin
            if (arrived_q == 0) o_cycle_length[15:0] <= i_word;
            if (arrived_q == 1) {pulse_field_q, o_cycle_length[23:16]} <= i_word;
            if (arrived_q == 2) o_prescaler[15:0] <= i_word;
            if (arrived_q == 3) {unplayable_q, o_prescaler[23:16]} <= {unplayable, i_word[7:0]};
        end
    end

    wire unused = &{1'b0, first_word};

`ifdef FORMAL
    `include "formal/memory_controller.vh"
`endif
endmodule
`default_nettype wire
