// SPDX-License-Identifier: Apache-2.0
//
// Reads the next record out of primary memory while the present one plays, and holds it ready until it is committed.
//
// i_entry/o_take is a valid/ready stream of (index, dwell), taken when i_settled says that the shadow registers are free. The
// record's header goes into the fields below; its words (o_timing, or i_word as it is) go on with o_shift, one a clock. o_ready is first high
// CHANNELS + 7 clocks after the clock that takes the entry, with the last timing, or after 33 if that is later; index 0 (silence)
// is ready after 2. A focus record is ready after 7 + 4 clocks a focus, or after 29 if that is later.
// A record that cannot be played is refused: an index above RECORDS; a cycle of no clock (with WIDTH_BITS, of fewer than the 8 that
// period_controller takes for each), or of more than MAX_CYCLE_CLOCKS; a pulse shorter than MIN_PULSE_CLOCKS, longer than
// MAX_PULSE_CLOCKS, or more than MAX_DUTY_256 / 256 of its cycle; or reserved bits. A pulse length of 0 is silence and may be played.
// When a record is refused, o_refused strobes, and silence takes its place and dwell. i_preempt drops whatever is loading or loaded.
// Lengths in clocks are products with the prescaler. They are built bit by bit, in 24 clocks, while the timings arrive; a multiplier
// would be larger than all the rest. The prescaler rotates meanwhile and is as before at the end.
// The memory is read without pause in ascending order, and writers write in that order, too. So whoever starts first stays
// first, and a record that is written meanwhile is seen whole or not at all.
// With WIDTH_BITS, a record may be one of amplitudes, o_amplitudes: record_header.v says of what cycles.
// With FOCI, an index above RECORDS is a focus record, o_foci, without a header; focus_place.v finds it, by i_foci_*.
// CHANNELS and RECORDS are the core's: a load of up to 1000 channels fits in a 40 kHz period at 50 MHz, and an index has 16
// bits.
// TIMING_BITS is the width of a channel's comparator, PULSE_BITS that of the pulse length.
// COMMON_CYCLE, if not 0, is the one length in clocks that a record's cycle may have while i_common is high.
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
    parameter WIDTH_BITS   = 0,
    parameter FOCI         = 0,
    parameter LEAST_CYCLE  = 2,
    parameter COMMON_CYCLE = 0,
    parameter PRESCALER_BITS = 24,  // the field; less only makes proofs shorter, and larger prescalers are then refused
    parameter ADDRESS_BITS = $clog2(RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS))  // follows from the others
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_preempt,
    input  wire                    i_entry,
    input  wire                    i_settled,  // what takes the words is free
    input  wire                    i_common,   // not to change while a record loads
    output wire                    o_take,
    input  wire [15:0]             i_index,
    input  wire [15:0]             i_dwell,
    input  wire [1:0]              i_tag,      // goes with them
    output wire                    o_reading,  // the word at o_address is being read
    output reg  [ADDRESS_BITS-1:0] o_address,  // of a word
    input  wire [15:0]             i_word,     // two clocks after o_address
    input  wire [15:0]             i_foci_base,   // of focus records, in units of four words; these are not to change while one loads
    input  wire [15:0]             i_foci_count,
    input  wire [2:0]              i_foci_last,   // the foci of each, less one
    input  wire [15:0]             i_foci_cycle,  // ticks of one clock
    output wire                    o_shift,
    output wire [TIMING_BITS-1:0]  o_timing,
    input  wire                    i_commit,
    output wire                    o_ready,
    output reg                     o_silent,
    output reg                     o_amplitudes,
    output wire                    o_foci,
    output reg  [15:0]             o_index,
    output reg  [15:0]             o_dwell,
    output reg  [1:0]              o_tag,
    output reg  [23:0]             o_cycle_length,
    output reg  [23:0]             o_prescaler,
    output wire [PULSE_BITS-1:0]   o_pulse_length,
    output reg                     o_refused
);
    localparam WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam FOCI_WORDS = 4 * FOCI;  // the most
    localparam WORD_BITS = $clog2(WORDS > FOCI_WORDS ? WORDS : FOCI_WORDS);
    localparam integer ALL_WORDS = RECORDS * WORDS;
    localparam [26:0] STRIDE = WORDS[26:0];
    localparam [WORD_BITS-1:0] LAST = WORDS[WORD_BITS-1:0] - 1'b1;
    localparam [WORD_BITS-1:0] HEADER = `HG_RECORD_HEADER_WORDS;
    localparam [15:0] TOP_INDEX = RECORDS[15:0];
    localparam [1:0] IDLE = 2'd0, LOAD = 2'd1, READY = 2'd2;

    localparam integer PULSE_WIDTH = $clog2(MAX_PULSE_CLOCKS + 1) > 8 ? $clog2(MAX_PULSE_CLOCKS + 1) : 8;
    localparam integer CYCLE_WIDTH = $clog2(MAX_CYCLE_CLOCKS + 1) > 24 ? $clog2(MAX_CYCLE_CLOCKS + 1) : 24;
    localparam [PULSE_WIDTH-1:0] SHORTEST_PULSE = MIN_PULSE_CLOCKS[PULSE_WIDTH-1:0], LONGEST_PULSE = MAX_PULSE_CLOCKS[PULSE_WIDTH-1:0];
    localparam [CYCLE_WIDTH-1:0] SHORTEST_CYCLE = WIDTH_BITS != 0 ? 8 : 1, LONGEST_CYCLE = MAX_CYCLE_CLOCKS[CYCLE_WIDTH-1:0], COMMON = COMMON_CYCLE[CYCLE_WIDTH-1:0];

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
    reg  [1:0]           seeks_q;    // focus_place is looking for the record
    reg                  places_q;   // in this clock the index is checked and the record's address taken
    reg [7:0]            pulse_field_q;
    reg                  malformed_q;  // reserved bits, too long for PULSE_BITS, or too large a part of the cycle
    reg                  here_q;       // the last timing has arrived, or does so in this clock
    reg                  looked_q;     // at the last focus, too, for its reserved bits
    reg                  foci_q;
    assign o_foci = FOCI != 0 && foci_q;
    wire   seeking = FOCI != 0 && seeks_q != 2'd0;
    reg  [4:0]           steps_q;      // bits of the prescaler that the products still lack
    reg                  header_q;     // the header has arrived

    wire [26:0] first_word = {11'd0, o_index - 16'd1} * STRIDE;  // the upper bits are 0, because the index is in range
    wire [27:0] first_foci;
    wire        no_foci;
    generate
        if (FOCI != 0) begin : with_foci
            focus_place #(.RECORDS(RECORDS), .PRIMARY_WORDS(ALL_WORDS)) place (
                .clk(clk), .i_index(o_index), .i_base(i_foci_base), .i_count(i_foci_count), .i_last(i_foci_last),
                .o_first(first_foci), .o_refused(no_foci));
        end else begin : without_foci
            assign {first_foci, no_foci} = 29'd1;
            wire unused_foci = &{1'b0, i_foci_base, i_foci_count, i_foci_last};
        end
    endgenerate
    wire [31:0] last_focus_word = {27'd0, i_foci_last, 2'b11};
    wire [WORD_BITS-1:0] last = o_foci ? last_focus_word[WORD_BITS-1:0] : LAST;
    wire refuse_index = o_foci ? no_foci : o_index > TOP_INDEX;
    // Used in the clock in which i_word holds the header's last word; of foci, in which they are placed.
    wire amplitudes, has_room, malformed;
    record_header #(
        .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256),
        .WIDTH_BITS(WIDTH_BITS), .LEAST_CYCLE(LEAST_CYCLE), .PRESCALER_BITS(PRESCALER_BITS)
    ) header (
        .i_pulse(pulse_field_q), .i_cycle(o_foci ? {8'd0, i_foci_cycle} : o_cycle_length), .i_prescaler(o_prescaler[15:0]), .i_last_word(i_word),
        .o_amplitudes(amplitudes), .o_has_room(has_room), .o_malformed(malformed));
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
    wire uncommon   = COMMON_CYCLE != 0 && i_common && cycle_clocks != COMMON;
    wire unplayable = malformed_q || uncommon || cycle_over || cycle_clocks > LONGEST_CYCLE || cycle_clocks < SHORTEST_CYCLE
                      || pulse_over || pulse_clocks > LONGEST_PULSE || (pulse_field_q != 8'd0 && pulse_clocks < SHORTEST_PULSE);

    assign o_take    = state_q == IDLE && i_entry && i_settled && !i_preempt;
    wire   ends      = coming_q && comes_q == last;  // the last word arrives in the next clock
    assign o_reading = state_q == LOAD && !places_q && !here_q && !seeking;
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
    assign o_shift        = arrives_q && arrived_q >= (o_foci ? {WORD_BITS{1'b0}} : HEADER);
    assign o_pulse_length = pulse_field_q[PULSE_BITS-1:0];

    always @(posedge clk) begin
        o_refused <= 1'b0;
        coming_q  <= o_reading && !ends;
        arrives_q <= coming_q;
        {places_q, seeks_q} <= !o_take ? {seeks_q, 1'b0} : FOCI != 0 && i_index > TOP_INDEX ? 3'b001 : 3'b100;
        if (rst || i_preempt) begin
            state_q   <= IDLE;
            {coming_q, arrives_q} <= 2'b00;
            {places_q, seeks_q}   <= 3'b000;
        end else case (state_q)
            IDLE: if (i_entry && i_settled) state_q <= LOAD;
            LOAD: if (places_q && (o_index == 16'd0 || refuse_index)) begin
                state_q   <= READY;
                o_silent  <= 1'b1;
                o_refused <= refuse_index;
            end else if ((o_foci ? looked_q : ends || here_q) && checked) begin
                state_q   <= READY;
                o_silent  <= unplayable;
                o_refused <= unplayable;
            end
            default: if (i_commit) state_q <= IDLE;
        endcase
    end

    // The data path needs no reset: the state machine says when its contents count.
    always @(posedge clk) begin
        if (o_take) begin
            o_index   <= i_index;
            o_dwell   <= i_dwell;
            o_tag     <= i_tag;
            foci_q    <= i_index > TOP_INDEX;
            {here_q, looked_q, header_q} <= 3'b000;
        end else if (places_q) begin
            o_address <= o_foci ? first_foci[ADDRESS_BITS-1:0] : first_word[ADDRESS_BITS-1:0];
            asked_q   <= {WORD_BITS{1'b0}};
        end else begin  // beyond the last word, too: what is read there does not count
            o_address <= o_address + 1'b1;
            asked_q   <= asked_q + 1'b1;
        end
        comes_q   <= asked_q;
        arrived_q <= comes_q;
        if (arrives_q && !o_foci) begin
            if (arrived_q == 0) o_cycle_length[15:0] <= i_word;
            if (arrived_q == 1) {pulse_field_q, o_cycle_length[23:16]} <= i_word;
            if (arrived_q == 2) o_prescaler[15:0] <= i_word;
            if (arrived_q == 3) begin
                o_prescaler[23:16] <= i_word[7:0];
                malformed_q        <= malformed;
                o_amplitudes       <= amplitudes;
                header_q           <= 1'b1;
                steps_q            <= PRESCALER_BITS[4:0];
            end
        end
        if (checks) begin
            steps_q <= steps_q - 1'b1;
            o_prescaler[PRESCALER_BITS-1:0] <= {o_prescaler[PRESCALER_BITS-2:0], o_prescaler[PRESCALER_BITS-1]};
        end
        if (ends) here_q <= 1'b1;
        if (here_q && !o_take) looked_q <= 1'b1;
        if (o_foci && places_q) begin  // as if this had come in a header
            {o_amplitudes, header_q, malformed_q} <= {2'b11, !has_room};
            {pulse_field_q, o_cycle_length, o_prescaler} <= {16'd0, i_foci_cycle, 24'd1};
            steps_q <= PRESCALER_BITS[4:0];
        end
        if (o_foci && arrives_q && arrived_q[1:0] == 2'd3 && i_word[7:6] != 2'b00) malformed_q <= 1'b1;
    end

    wire unused = &{1'b0, first_word, first_foci, last_focus_word};

`ifdef FORMAL
    generate
        if (WIDTH_BITS == 0) begin : proof  // of records of timings alone
            `include "formal/memory_controller.vh"
        end
    endgenerate
`endif
endmodule
`default_nettype wire
