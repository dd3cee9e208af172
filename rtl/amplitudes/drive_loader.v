// SPDX-License-Identifier: Apache-2.0
//
// The first stage of drive_player: once a record, reads the next record and fills a bank of the drive memory with a word of each channel.
//
// The words are the record's own, or the focus engine's results for the record's foci. i_entry/o_take, i_common and the reading are
// memory_controller's. o_ready comes with the last word, or at once for silence, which has no words; then the fields beside it hold until
// i_take_over, which may come while o_ready is high. i_preempt drops the record that is loading or loaded. Meanwhile the other bank, i_swept,
// is read: o_word is there two clocks after i_channel. o_far strobes when a record is complete one of whose foci was too far to count.
// Geometry is written one word a strobe, while no record of foci is made. The parameters are those of drive_player.
`default_nettype none
`include "interface.vh"
module drive_loader #(
    parameter CHANNELS        = 100,
    parameter RECORDS         = 400,
    parameter TIMING_BITS     = 11,
    parameter PULSE_BITS      = 8,
    parameter WIDTH_BITS      = 10,
    parameter FOCI            = 8,
    parameter MIN_PULSE_CLOCKS = 5,
    parameter MAX_PULSE_CLOCKS = 999,
    parameter MAX_DUTY_256    = 128,
    parameter MAX_CYCLE_CLOCKS = 50000000,
    parameter LEAST_CYCLE     = 288,
    parameter COMMON_CYCLE    = 0,
    parameter CHANNEL_BITS    = $clog2(CHANNELS),  // these follow from the others
    parameter ADDRESS_BITS    = $clog2(RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS))
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_preempt,
    input  wire                    i_entry,
    input  wire                    i_common,
    output wire                    o_take,
    input  wire [15:0]             i_index,
    input  wire [15:0]             i_dwell,
    input  wire [1:0]              i_tag,
    output wire                    o_reading,
    output wire [ADDRESS_BITS-1:0] o_address,
    input  wire [15:0]             i_word,
    input  wire                    i_set_geometry,  // strobe
    input  wire [CHANNEL_BITS+1:0] i_set_address,
    input  wire [15:0]             i_set_word,
    input  wire [15:0]             i_foci_base,     // from parameter_registers, to the gain
    input  wire [15:0]             i_foci_count,
    input  wire [2:0]              i_foci_last,
    input  wire                    i_foci_whole,
    input  wire [15:0]             i_foci_cycle,
    input  wire [17:0]             i_wave_number,
    input  wire [15:0]             i_gain,
    input  wire                    i_take_over,
    output wire                    o_ready,
    output wire                    o_silent,
    output wire                    o_amplitudes,
    output wire [15:0]             o_index,
    output wire [15:0]             o_dwell,
    output wire [1:0]              o_tag,
    output wire [23:0]             o_cycle_length,
    output wire [23:0]             o_prescaler,
    output wire [PULSE_BITS-1:0]   o_pulse_length,
    output wire                    o_refused,       // strobe
    output wire                    o_far,           // strobe
    input  wire                    i_swept,
    input  wire [CHANNEL_BITS-1:0] i_channel,
    output wire [31:0]             o_word           // {amplitude, phase}
);
    wire                   loaded, shift, foci, complete;
    wire [TIMING_BITS-1:0] timing;

    memory_controller #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS),
        .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256),
        .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS), .WIDTH_BITS(WIDTH_BITS), .FOCI(FOCI), .LEAST_CYCLE(LEAST_CYCLE), .COMMON_CYCLE(COMMON_CYCLE)
    ) memory (
        .clk(clk), .rst(rst),
        .i_preempt(i_preempt), .i_entry(i_entry), .i_settled(1'b1), .i_common(i_common), .o_take(o_take), .i_index(i_index), .i_dwell(i_dwell), .i_tag(i_tag),
        .o_reading(o_reading), .o_address(o_address), .i_word(i_word),
        .i_foci_base(i_foci_base), .i_foci_count(i_foci_count), .i_foci_last(i_foci_last), .i_foci_cycle(i_foci_cycle),
        .o_shift(shift), .o_timing(timing),
        .i_commit(i_take_over), .o_ready(loaded), .o_silent(o_silent), .o_amplitudes(o_amplitudes), .o_foci(foci),
        .o_index(o_index), .o_dwell(o_dwell), .o_tag(o_tag), .o_cycle_length(o_cycle_length), .o_prescaler(o_prescaler),
        .o_pulse_length(o_pulse_length), .o_refused(o_refused));
    assign o_ready = loaded && (o_silent || complete);

    wire        engine_valid;
    wire [31:0] engine_word;
    generate
        if (FOCI != 0) begin : with_foci
            reg        loaded_q, started_q, far_q;
            reg  [4:0] focus_word_q;
            wire       engine_last, engine_far, engine_ready;
            wire [CHANNEL_BITS-1:0] engine_channel;
            always @(posedge clk) begin
                // The last word of the foci may come in the clock in which they are first loaded.
                loaded_q  <= loaded && foci && !o_silent && !i_preempt && !rst;
                started_q <= loaded_q && !i_preempt && !rst;
                if (o_take) focus_word_q <= 5'd0;
                else if (shift) focus_word_q <= focus_word_q + 1'b1;
                if (rst || i_preempt || (engine_valid && engine_last)) far_q <= 1'b0;
                else if (engine_valid && engine_far) far_q <= 1'b1;
            end
            focus_engine #(.CHANNELS(CHANNELS)) engine (
                .clk(clk), .rst(rst || i_preempt),
                .i_geometry(i_set_geometry), .i_geometry_address(i_set_address), .i_geometry_word(i_set_word),
                .i_focus(shift && foci), .i_focus_address(focus_word_q), .i_focus_word(i_word),
                .i_start(loaded_q && !started_q), .o_ready(engine_ready), .i_last_focus(i_foci_last), .i_whole(i_foci_whole),
                .i_wave_number(i_wave_number), .i_gain(i_gain),
                .o_valid(engine_valid), .o_last(engine_last), .o_far(engine_far), .o_channel(engine_channel),
                .o_phase(engine_word[15:0]), .o_amplitude(engine_word[31:16]));
            assign o_far = engine_valid && engine_last && (far_q || engine_far);
            wire unused = &{1'b0, engine_ready, engine_channel};
        end else begin : without_foci
            assign {engine_valid, engine_word, o_far} = 34'd0;
            wire unused = &{1'b0, i_set_geometry, i_set_address, i_set_word, i_foci_whole, i_wave_number, i_gain};
        end
    endgenerate

    drive_memory #(.CHANNELS(CHANNELS)) drives (
        .clk(clk), .i_clear(rst || i_preempt || o_take), .i_write(foci ? engine_valid : shift),
        .i_word(foci ? engine_word : o_amplitudes ? {i_word[15:8], i_word[15:8], i_word[7:0], 8'd0} : {16'hffff, i_word}),
        .o_complete(complete), .i_swept(i_swept), .i_channel(i_channel), .o_word(o_word));

    wire unused = &{1'b0, timing};
endmodule
`default_nettype wire
