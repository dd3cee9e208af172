// SPDX-License-Identifier: Apache-2.0
//
// The instrument (Haptogram Fig. 5): everything from the serial line to the pins, for one clock domain. It only wires modules; the
// picture in README.md shows them. rst is synchronous.
//
// A pin rises one tick and two clocks after the tick that its timing names. o_index and o_cycle_start are delayed alike: a pulse
// that rises in the clock in which o_index changes is the new record's.
// What switches outputs off: DISABLE, a watchdog or guard trip, a break on the serial line, i_stop, and reset.
// The parameters without a comment are described in INTERFACE.md, with their ranges and the reason for each; it also lists the
// named configurations of them. Values out of range do not elaborate.
`default_nettype none
`include "interface.vh"
module haptogram_core #(
    parameter CHANNELS        = `HG_DEFAULT_CHANNELS,
    parameter RECORDS         = `HG_DEFAULT_RECORDS,
    parameter SEQUENCE_DEPTH  = `HG_DEFAULT_SEQUENCE_DEPTH,
    parameter LIVE_DEPTH      = `HG_DEFAULT_LIVE_DEPTH,
    parameter TIMING_BITS     = `HG_DEFAULT_TIMING_BITS,
    parameter PULSE_BITS      = `HG_DEFAULT_PULSE_BITS,
    parameter CLOCK_HZ        = `HG_DEFAULT_CLOCK_HZ,
    parameter BAUD            = `HG_DEFAULT_BAUD,
    parameter WATCHDOG_MS     = `HG_DEFAULT_WATCHDOG_MS,
    parameter MAX_HIGH_CLOCKS = `HG_DEFAULT_MAX_HIGH_CLOCKS,
    parameter MIN_PULSE_CLOCKS = `HG_DEFAULT_MIN_PULSE_CLOCKS,
    parameter MAX_DUTY_256    = `HG_DEFAULT_MAX_DUTY_256,
    parameter CARRIER_HZ      = 40000,  // of the cycles before the first record, which starts at the end of one
    parameter PRIMARY_FILE    = "",     // $readmemh files: the memories' contents at power-up
    parameter SEQUENCE_FILE   = ""
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                i_rx,
    input  wire                i_stop,         // a switch, not synchronous to clk: while it is high, outputs are off
    output wire                o_tx,
    output wire [CHANNELS-1:0] o_pins,
    output wire                o_enabled,      // for the drivers' enable input
    output wire                o_alive,        // changes all the time, as long as there is a clock
    output wire                o_playing,
    output wire                o_fault,        // the watchdog or the guard has tripped since outputs were last enabled
    output wire [15:0]         o_index,
    output wire                o_cycle_start
);
    localparam RECORD_WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam PRIMARY_WORDS = RECORDS * RECORD_WORDS;
    localparam PRIMARY_BITS = $clog2(PRIMARY_WORDS), SEQUENCE_BITS = $clog2(SEQUENCE_DEPTH);
    // The address of a 16-bit word in any region: primary memory, sequence memory in halves, the 32 words of a block.
    localparam HALVES_OR_BLOCK_BITS = SEQUENCE_BITS < 4 ? 5 : SEQUENCE_BITS + 1;
    localparam WORD_BITS = PRIMARY_BITS > HALVES_OR_BLOCK_BITS ? PRIMARY_BITS : HALVES_OR_BLOCK_BITS;
    // Room for two of the longest frames: length word, sequence number and command, address, record.
    localparam RING_BITS = $clog2(2 * (RECORD_WORDS + 4));
    localparam IDLE_CLOCKS = CLOCK_HZ / CARRIER_HZ;
    localparam MAX_CYCLE_CLOCKS = CLOCK_HZ;  // one second
    // Pulses that merge at changes of focus make up to five times the longest one, if their records' ticks are alike. A pin may
    // be high through one of the guard's windows of MAX_HIGH_CLOCKS / 2 - 1 clocks.
    localparam MAX_PULSE_CLOCKS = (MAX_HIGH_CLOCKS / 2 - 2) / 5;

    // ---- The link: frames in, replies out

    wire        frame_valid, frame_take, frame_good, frame_damaged, urgent_disable, urgent_stop, line_broken;
    wire        reply_valid, reply_ready, reply_last;
    wire [15:0] frame_word, reply_word;

    link #(
        .CHANNELS(CHANNELS), .RING_BITS(RING_BITS), .CLOCK_HZ(CLOCK_HZ), .BAUD(BAUD)
    ) serial (
        .clk(clk), .rst(rst),
        .i_rx(i_rx), .o_tx(o_tx),
        .o_valid(frame_valid), .o_word(frame_word), .i_take(frame_take),
        .o_good(frame_good), .o_damaged(frame_damaged),
        .i_done(execute || repeated || refused), .i_session(session), .i_expected(expected),
        .o_disable(urgent_disable), .o_stop(urgent_stop), .o_break(line_broken),
        .i_reply_valid(reply_valid), .o_reply_ready(reply_ready), .i_reply_word(reply_word), .i_reply_last(reply_last));

    // ---- Commands

    wire        settle, execute, repeated, refused, session, write, hold, push, keep, take_back, answer, answered;
    wire [7:0]  command, verdict, status, sequence_number, expected;
    wire [15:0] argument_0, argument_1, argument_2, tail_words, read_words, live_free, live_level;
    wire [WORD_BITS-1:0] command_address;
    wire [3:0]  region;

    command_check #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .WORD_BITS(WORD_BITS)
    ) check (
        .clk(clk),
        .i_settle(settle), .i_command(command),
        .i_argument_0(argument_0), .i_argument_1(argument_1), .i_argument_2(argument_2), .i_tail_words(tail_words),
        .i_live_free(live_free), .i_stopped(stopped), .i_header_valid(header_valid),
        .o_status(verdict));

    command_unit #(
        .RECORDS(RECORDS), .WORD_BITS(WORD_BITS), .LENGTH_BITS(RING_BITS + 2)
    ) commands (
        .clk(clk), .rst(rst),
        .i_valid(frame_valid), .o_take(frame_take), .i_word(frame_word),
        .o_command(command), .o_argument_0(argument_0), .o_argument_1(argument_1), .o_argument_2(argument_2),
        .o_tail_words(tail_words), .o_settle(settle), .i_status(verdict),
        .o_execute(execute), .o_repeated(repeated), .o_refused(refused), .o_session(session),
        .o_write(write), .i_hold(hold), .o_address(command_address), .o_region(region),
        .o_push(push), .o_keep(keep), .o_take_back(take_back),
        .o_answer(answer), .o_status(status), .o_sequence(sequence_number), .o_expected(expected), .o_read_words(read_words),
        .i_answered(answered));

    // An autostart enables the outputs and turns the watchdog off, as if a host had sent ENABLE and WATCHDOG with 0.
    wire autostart;
    wire does_enable   = autostart || (execute && command == `HG_COMMAND_ENABLE);
    wire does_disable  = execute && command == `HG_COMMAND_DISABLE;
    wire does_watchdog = autostart || (execute && command == `HG_COMMAND_WATCHDOG);
    wire does_reset    = execute && command == `HG_COMMAND_RESET;
    wire asks          = read_words != 16'd0;  // of a command that is carried out: it only asks
    // While a STOP waits for its turn, nothing that was sent before it starts to play.
    reg  urgent_stop_q;
    always @(posedge clk) urgent_stop_q <= urgent_stop && !rst;
    wire does_select   = execute && command == `HG_COMMAND_SELECT && !urgent_stop;
    wire does_start    = execute && command == `HG_COMMAND_START && !urgent_stop;
    wire does_stop     = (execute && command == `HG_COMMAND_STOP) || (urgent_stop && !urgent_stop_q);
    wire keeps         = keep && !urgent_stop;
    // What RESET resets: all that plays and supervises. The link goes on, and memories are not reset by anything.
    reg  play_rst;
    initial play_rst = 1'b0;
    always @(posedge clk) play_rst <= rst || does_reset;

    // ---- The address space, and the replies that are read from it

    wire [WORD_BITS-1:0]     reply_address;
    wire [PRIMARY_BITS-1:0]  load_address;
    wire [SEQUENCE_BITS-1:0] sequence_address;
    wire [15:0] primary_word, register_word, answer_word;
    wire [31:0] sequence_word;
    wire        read, granted, loading, fetching;

    address_space #(
        .PRIMARY_WORDS(PRIMARY_WORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .WORD_BITS(WORD_BITS),
        .PRIMARY_FILE(PRIMARY_FILE), .SEQUENCE_FILE(SEQUENCE_FILE)
    ) memories (
        .clk(clk), .i_region(region),
        .i_write(write), .i_write_address(command_address), .i_write_word(frame_word), .o_hold(hold),
        .i_read_address(reply_address), .i_register_word(register_word), .o_granted(granted), .o_read_word(answer_word),
        .i_loading(loading), .i_load_address(load_address), .o_primary_word(primary_word),
        .i_fetching(fetching), .i_sequence_address(sequence_address), .o_sequence_word(sequence_word));

    reply_unit #(.WORD_BITS(WORD_BITS)) replies (
        .clk(clk), .rst(rst),
        .i_answer(answer), .i_sequence(sequence_number), .i_command(command), .i_status(status), .i_expected(expected),
        .i_live_level(live_level), .i_address(command_address), .i_words(read_words),
        .i_digest(command == `HG_COMMAND_DIGEST), .o_answered(answered),
        .o_read(read), .o_address(reply_address), .i_granted(granted), .i_read_word(answer_word),
        .o_valid(reply_valid), .i_ready(reply_ready), .o_word(reply_word), .o_last(reply_last));

    // ---- What to play next

    wire        live_valid, live_take, live_clear, preempt, entry, take, header_valid;
    wire [31:0] live_entry;
    wire [15:0] next_index, next_dwell;
    wire [1:0]  mode;

    live_fifo #(.DEPTH(LIVE_DEPTH)) live (
        .clk(clk), .rst(play_rst), .i_clear(live_clear),
        .i_push(push), .i_entry({argument_0, frame_word}), .i_keep(keeps), .i_take_back(take_back || (keep && urgent_stop)),
        .o_free(live_free), .o_level(live_level),
        .o_valid(live_valid), .o_entry(live_entry), .i_take(live_take));

    index_source #(.SEQUENCE_DEPTH(SEQUENCE_DEPTH)) source (
        .clk(clk), .rst(play_rst),
        .i_select(does_select), .i_start(does_start), .i_stop(does_stop), .i_live(keeps), .i_host(execute && !asks),
        .i_header(write && region == `HG_REGION_SEQUENCE && command_address == {WORD_BITS{1'b0}}), .i_header_word(frame_word[14:0]),
        .o_header_valid(header_valid),
        .i_argument_0(argument_0), .i_argument_1(argument_1), .i_argument_2(argument_2),
        .o_fetching(fetching), .o_sequence_address(sequence_address), .i_sequence_word(sequence_word),
        .i_live_valid(live_valid), .i_live_entry(live_entry), .o_live_take(live_take), .o_live_clear(live_clear),
        .o_preempt(preempt), .o_entry(entry), .i_take(take), .o_index(next_index), .o_dwell(next_dwell),
        .o_mode(mode), .o_autostart(autostart));

    // ---- Playing it

    wire expired, record_refused, underrun, guard_trip, stopped;

    synchronizer #(.RESET_VALUE(1'b1)) stop_switch (.clk(clk), .rst(rst), .i_foreign(i_stop), .o_synchronous(stopped));

    player #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .IDLE_CLOCKS(IDLE_CLOCKS),
        .MAX_HIGH_CLOCKS(MAX_HIGH_CLOCKS), .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS),
        .MAX_DUTY_256(MAX_DUTY_256), .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS)
    ) play (
        .clk(clk), .rst(play_rst),
        .i_preempt(preempt), .i_entry(entry), .o_take(take), .i_index(next_index), .i_dwell(next_dwell),
        .o_reading(loading), .o_address(load_address), .i_word(primary_word),
        .i_enable(does_enable), .i_disable(does_disable || urgent_disable || line_broken || stopped || rst), .i_expired(expired),
        .o_pins(o_pins), .o_enabled(o_enabled), .o_alive(o_alive), .o_index(o_index), .o_cycle_start(o_cycle_start),
        .o_refused(record_refused), .o_underrun(underrun), .o_guard_trip(guard_trip));

    // ---- Supervision

    wire [15:0] watchdog_ms;

    watchdog #(.CLOCK_HZ(CLOCK_HZ), .DEFAULT_MS(WATCHDOG_MS)) dog (
        .clk(clk), .rst(play_rst),
        .i_running(o_enabled), .i_kick(execute && command != `HG_COMMAND_IDENTIFY),
        .i_set(does_watchdog), .i_milliseconds(autostart ? 16'd0 : argument_0), .o_milliseconds(watchdog_ms),
        .o_expired(expired));

    register_file #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .LIVE_DEPTH(LIVE_DEPTH),
        .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .CLOCK_HZ(CLOCK_HZ), .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS),
        .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256), .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS)
    ) registers (
        .clk(clk), .rst(play_rst),
        .i_read(read), .i_is_identity(region == `HG_REGION_IDENTITY), .i_address(reply_address[4:0]), .o_word(register_word),
        .i_enabled(o_enabled), .i_stopped(stopped), .i_mode(mode), .i_present_index(o_index), .i_live_level(live_level), .i_watchdog_ms(watchdog_ms),
        .i_underrun(underrun), .i_record_refused(record_refused),
        .i_frame_good(frame_good), .i_frame_damaged(frame_damaged), .i_frame_repeated(repeated), .i_frame_refused(refused),
        .i_watchdog_trip(expired), .i_guard_trip(guard_trip));

    reg fault_q;
    always @(posedge clk) begin
        if (play_rst) fault_q <= 1'b0;
        else if (guard_trip || (expired && !does_enable)) fault_q <= 1'b1;
        else if (does_enable) fault_q <= 1'b0;
    end
    assign o_fault   = fault_q;
    assign o_playing = o_enabled && o_index != 16'd0;
endmodule
`default_nettype wire
