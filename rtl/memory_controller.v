// SPDX-License-Identifier: Apache-2.0
//
// Reads the next record out of primary memory while the present one plays, and holds it ready until it is committed.
//
// i_entry/o_take is a valid/ready stream of (index, dwell), taken when i_settled says that the shadow registers are free. The
// record's header goes into the fields below; its timings go into the shadow registers, one a clock. o_ready is first high
// CHANNELS + 7 clocks after the clock that takes the entry, with the last timing, or after 33 if that is later; index 0 (silence)
// is ready after 2.
// A record that cannot be played is refused: an index above RECORDS; a cycle of no clock, or of more than MAX_CYCLE_CLOCKS; a
// pulse shorter than MIN_PULSE_CLOCKS, longer than MAX_PULSE_CLOCKS, or more than MAX_DUTY_256 / 256 of its cycle; or reserved
// bits. A pulse length of 0 is silence and may be played. When a record is refused, o_refused strobes, and silence takes its
// place and dwell. i_preempt drops whatever is loading or loaded.
// Lengths in clocks are products with the prescaler. They are built bit by bit, in 24 clocks, while the timings arrive; a multiplier
// would be larger than all the rest. The prescaler rotates meanwhile and is as before at the end.
// The memory is read without pause in ascending order, and writers write in that order, too. So whoever starts first stays
// first, and a record that is written meanwhile is seen whole or not at all.
// CHANNELS and RECORDS are the core's: a load of up to 1000 channels fits in a 40 kHz period at 50 MHz, and an index has 16
// bits.
// TIMING_BITS is the width of a channel's comparator, PULSE_BITS that of the pulse length.
// MIN_PULSE_CLOCKS and MAX_DUTY_256 are the core's. MAX_PULSE_CLOCKS (from 1) is what output_guard bears, MAX_CYCLE_CLOCKS one second.
`default_nettype none
`include "interface.vh"
module memory_controller #(
    parameter CHANNELS     = 100,
    parameter RECORDS      = 400,
    parameter TIMING_BITS  = 16,
    parameter PULSE_BITS   = 8,
    parameter MIN_PULSE_CLOCKS = 5,
    parameter MAX_PULSE_CLOCKS = 999,
    parameter MAX_DUTY_256     = 128,
    parameter MAX_CYCLE_CLOCKS = 50000000,
    parameter PRESCALER_BITS = 24,  // the field; less only makes proofs shorter, and larger prescalers are then refused
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

    localparam integer PULSE_WIDTH = $clog2(MAX_PULSE_CLOCKS + 1) > 8 ? $clog2(MAX_PULSE_CLOCKS + 1) : 8;
    localparam integer CYCLE_WIDTH = $clog2(MAX_CYCLE_CLOCKS + 1) > 24 ? $clog2(MAX_CYCLE_CLOCKS + 1) : 24;
    localparam [PULSE_WIDTH-1:0] SHORTEST_PULSE = MIN_PULSE_CLOCKS[PULSE_WIDTH-1:0], LONGEST_PULSE = MAX_PULSE_CLOCKS[PULSE_WIDTH-1:0];
    localparam [31:0] LARGEST_DUTY = MAX_DUTY_256;
    localparam [CYCLE_WIDTH-1:0] LONGEST_CYCLE = MAX_CYCLE_CLOCKS[CYCLE_WIDTH-1:0];

    generate
        if (MIN_PULSE_CLOCKS < 1 || MIN_PULSE_CLOCKS > MAX_PULSE_CLOCKS) min_pulse_clocks_out_of_range error();
        if (MAX_DUTY_256 < 1 || MAX_DUTY_256 > 255) max_duty_256_out_of_range error();
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
    reg                  malformed_q;  // reserved bits, too long for PULSE_BITS, or too large a part of the cycle
    reg                  here_q;       // the last timing has arrived, or does so in this clock
    reg  [4:0]           steps_q;      // bits of the prescaler that the products still lack
    reg                  header_q;     // the header has arrived

    wire [26:0] first_word = {11'd0, o_index - 16'd1} * STRIDE;  // the upper bits are 0, because the index is in range
    wire refuse_index = o_index > TOP_INDEX;
    // Used in the clock in which i_word holds the header's last word: the prescaler's upper bits and the reserved bits.
    wire [24:0] pulse_limit = 25'd1 << PULSE_BITS;
    wire malformed = {17'd0, pulse_field_q} >= pulse_limit || i_word[15:8] != 8'd0
                     || {1'b0, i_word[7:0], o_prescaler[15:0]} >> PRESCALER_BITS != 25'd0
                     || {16'd0, pulse_field_q, 8'd0} > {8'd0, o_cycle_length} * LARGEST_DUTY;
    wire checks  = header_q && steps_q != 5'd0;
    wire next_bit = o_prescaler[PRESCALER_BITS-1];
    wire checked = header_q && steps_q == 5'd0;
    wire [PULSE_WIDTH-1:0] pulse_clocks;
    wire [CYCLE_WIDTH-1:0] cycle_clocks;
    wire                   pulse_over, cycle_over;
    serial_product #(.FACTOR_BITS(8), .PRODUCT_BITS(PULSE_WIDTH)) pulse_product (
        .clk(clk), .i_clear(!header_q), .i_step(checks), .i_bit(next_bit), .i_factor(pulse_field_q),
        .o_product(pulse_clocks), .o_over(pulse_over));
    serial_product #(.FACTOR_BITS(24), .PRODUCT_BITS(CYCLE_WIDTH)) cycle_product (
        .clk(clk), .i_clear(!header_q), .i_step(checks), .i_bit(next_bit), .i_factor(o_cycle_length),
        .o_product(cycle_clocks), .o_over(cycle_over));
    wire unplayable = malformed_q || cycle_over || cycle_clocks > LONGEST_CYCLE || cycle_clocks == {CYCLE_WIDTH{1'b0}}
                      || pulse_over || pulse_clocks > LONGEST_PULSE || (pulse_field_q != 8'd0 && pulse_clocks < SHORTEST_PULSE);

    assign o_take    = state_q == IDLE && i_entry && i_settled && !i_preempt;
    wire   ends      = coming_q && comes_q == LAST;  // the last word arrives in the next clock
    assign o_reading = state_q == LOAD && !places_q && !here_q;
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
            end else if ((ends || here_q) && checked) begin
                state_q   <= READY;
                o_silent  <= unplayable;
                o_refused <= unplayable;
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
            {here_q, header_q} <= 2'b00;
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
            if (arrived_q == 3) begin
                o_prescaler[23:16] <= i_word[7:0];
                malformed_q        <= malformed;
                header_q           <= 1'b1;
                steps_q            <= PRESCALER_BITS[4:0];
            end
        end
        if (checks) begin
            steps_q <= steps_q - 1'b1;
            o_prescaler[PRESCALER_BITS-1:0] <= {o_prescaler[PRESCALER_BITS-2:0], o_prescaler[PRESCALER_BITS-1]};
        end
        if (ends) here_q <= 1'b1;
    end

    wire unused = &{1'b0, first_word};

`ifdef FORMAL
    `include "formal/memory_controller.vh"
`endif
endmodule
`default_nettype wire
