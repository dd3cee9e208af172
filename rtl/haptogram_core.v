// SPDX-License-Identifier: Apache-2.0
//
// The instrument (Haptogram Fig. 5): everything from the serial line to the pins, for one clock domain. It only wires modules; the
// picture in README.md shows them. rst is synchronous.
//
// A pin rises one tick and two clocks after the tick that its timing names. o_index and o_cycle_start are delayed alike: a pulse
// that rises in the clock in which o_index changes is the new record's.
// What switches outputs off: DISABLE, a watchdog or guard trip, a break on the line to the host, i_stop, loss of SYNC, and reset.
// INTERFACE.md describes the parameters of parameters.vh, with their ranges and the reason for each; it also lists the named
// configurations of them. Values out of range do not elaborate.
`default_nettype none
`include "interface.vh"
module haptogram_core #(
    `include "parameters.vh"
    parameter CARRIER_HZ = 40000,   // of the cycles before the first record, which starts at the end of one
    parameter PRIMARY_FILE = "",    // $readmemh files: the memories' contents at power-up
    parameter SEQUENCE_FILE = ""
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                i_rx,
    input  wire                i_stop,         // a switch, not synchronous to clk: while it is high, outputs are off
    input  wire                i_sync,         // from the master, not synchronous to clk
    output wire                o_sync,         // of the master
    output wire                o_tx,
    input  wire                i_next,         // the next tile's o_tx, not synchronous to clk; high where there is none
    output wire                o_next,         // to the next tile's i_rx
    input  wire                i_net_valid,    // with NET, bytes of a network port in the place of i_rx, at most one a clock
    input  wire [7:0]          i_net_byte,
    input  wire [2:0]          i_net_old,      // what still comes was sent before a switch-off (bit 0), STOP (1), end of a session (2); see udp_link
    input  wire                i_net_lost,     // strobe: its link was lost
    input  wire                i_net_end,      // strobe: the session ends, because there is another peer, or anybody asked for outputs to be off
    input  wire                i_net_off,      // strobe: somebody there asked for outputs to be off
    input  wire                i_net_stop,     // strobe: somebody there asked for a STOP
    output wire                o_net_off,      // outputs are switched off, and not by what came from there
    output wire                o_net_valid,    // bytes of replies, which end with a zero
    input  wire                i_net_ready,
    output wire [7:0]          o_net_byte,
    input  wire [4:0]          i_identity_place,  // a word of the identity block for who only asks, combinational and constant
    output wire [15:0]         o_identity_word,
    output wire [2:0]          o_sdram_command,   // with SDRAM, the chip that holds the records: see rtl/sdram
    output wire [1:0]          o_sdram_bank,
    output wire [10:0]         o_sdram_address,
    output wire [31:0]         o_sdram_data,
    output wire                o_sdram_drive,
    input  wire [31:0]         i_sdram_data,
    output wire                o_flash_cs_n,      // the flash that it is filled from
    output wire                o_flash_clk,
    output wire                o_flash_data,
    input  wire                i_flash_data,
    input  wire                i_trigger,      // not synchronous to clk
    output wire                o_trigger,
    output wire                o_test,         // for an oscilloscope
    output wire [CHANNELS-1:0] o_pins,
    output wire                o_enabled,      // for the drivers' enable input
    output wire                o_alive,        // changes all the time, as long as there is a clock
    output wire                o_playing,
    output wire                o_fault,        // since outputs were last enabled, the watchdog or the guard has tripped, or SYNC was lost
    output wire [15:0]         o_index,
    output wire                o_cycle_start
);
    localparam RECORD_WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam PRIMARY_WORDS = RECORDS * RECORD_WORDS;
    localparam PRIMARY_BITS = $clog2(PRIMARY_WORDS), SEQUENCE_BITS = $clog2(SEQUENCE_DEPTH);
    // The address of a 16-bit word in any region: primary memory, sequence memory in halves, the 32 words of a block.
    localparam HALVES_OR_BLOCK_BITS = SEQUENCE_BITS < 4 ? 5 : SEQUENCE_BITS + 1;
    localparam SAMPLE_BITS = MODULATION_DEPTH != 0 ? $clog2(MODULATION_DEPTH) - 1 : 0, GEOMETRY_BITS = FOCI != 0 ? $clog2(CHANNELS) + 2 : 0;
    localparam SETTING_BITS = SAMPLE_BITS > GEOMETRY_BITS ? SAMPLE_BITS : GEOMETRY_BITS;
    localparam PLAYED_BITS = PRIMARY_BITS > HALVES_OR_BLOCK_BITS ? PRIMARY_BITS : HALVES_OR_BLOCK_BITS;
    localparam WORD_BITS = PLAYED_BITS > SETTING_BITS ? PLAYED_BITS : SETTING_BITS;
    // The longest frames in bytes, without their CRC: sequence number and command, address, record; or as many foci as bring the 1 Mbaud line to
    // 12,000 a second with something to spare. There is room for two of them, each with a word for its length.
    localparam RECORD_FRAME = 6 + 2 * RECORD_WORDS, FOCI_FRAME = FOCI != 0 ? 4 + 8 * 60 : 0;
    localparam FRAME_BYTES = RECORD_FRAME > FOCI_FRAME ? RECORD_FRAME : FOCI_FRAME;
    localparam RING_BITS = $clog2(2 * (FRAME_BYTES / 2 + 1));
    localparam IDLE_CLOCKS = CLOCK_HZ / CARRIER_HZ;
    localparam MAX_CYCLE_CLOCKS = CLOCK_HZ;  // one second
    // Pulses that merge at changes of focus make up to five times the longest one, if their records' ticks are alike. A pin may
    // be high through one of the guard's windows of MAX_HIGH_CLOCKS / 2 - 1 clocks.
    localparam MAX_PULSE_CLOCKS = (MAX_HIGH_CLOCKS / 2 - 2) / 5;

    `include "parameter_check.vh"

    // What a block takes from one that stands below it.
    wire execute, repeated, refused, header_valid, stopped, expired, guard_trip, out_of_step, sync_lost;

    // ---- The link: frames in, replies out

    wire        frame_valid, frame_take, frame_good, frame_damaged, stale, unplayed, stops, ended, heard, line_broken, alone;
    wire        reply_valid, reply_ready, reply_last;
    wire        image, image_valid, image_read, line_valid;  // an image is read out of the flash
    wire [7:0]  image_byte;
    wire [1:0]  flash;
    wire [15:0] frame_word, reply_word;

    link #(
        .CHANNELS(CHANNELS), .RING_BITS(RING_BITS), .CLOCK_HZ(CLOCK_HZ), .BAUD(BAUD), .CHAIN(CHAIN), .NET(NET), .SDRAM(SDRAM)
    ) serial (
        .clk(clk), .rst(rst),
        .i_rx(i_rx), .o_tx(o_tx), .i_next(i_next), .o_next(o_next),
        .i_net_valid(i_net_valid), .i_net_byte(i_net_byte), .i_net_old(i_net_old), .i_net_lost(i_net_lost), .i_net_end(i_net_end),
        .i_net_off(i_net_off), .i_net_stop(i_net_stop), .i_alone(alone),
        .o_net_valid(o_net_valid), .i_net_ready(i_net_ready), .o_net_byte(o_net_byte),
        .i_image(image), .i_image_valid(image_valid), .i_image_byte(image_byte), .o_line_valid(line_valid),
        .o_valid(frame_valid), .o_word(frame_word), .i_take(frame_take),
        .o_good(frame_good), .o_damaged(frame_damaged),
        .i_done(execute || repeated || refused), .i_off(o_net_off),
        .o_disable(stale), .o_stop(unplayed), .o_stops(stops), .o_heard(heard), .o_ended(ended), .o_break(line_broken),
        .i_reply_valid(reply_valid), .o_reply_ready(reply_ready), .i_reply_word(reply_word), .i_reply_last(reply_last));

    assign o_net_off = stopped || expired || guard_trip || sync_lost;

    // ---- Commands

    wire [15:0] top_index;
    wire        settle, puts, more, write, hold, push, keep, take_back, answer, answered;
    wire [7:0]  command, verdict, status, sequence_number, expected;
    wire [15:0] argument_0, argument_1, argument_2, tail_words, read_words, live_free, live_level;
    wire [WORD_BITS-1:0] command_address, ring_address, ring_start;
    wire        gate_busy, no_push, ring_usable, ring_fits, ring_wraps, ring_complete, ring_split;
    wire [3:0]  region;
    wire        stream_usable, stream_waits, stream_takes, stream_place, stream_keeps, stream_split, closes;
    wire [WORD_BITS-1:0] stream_address;

    command_check #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .WIDTH_BITS(WIDTH_BITS),
        .MODULATION_DEPTH(MODULATION_DEPTH), .FOCI(FOCI), .SCHEDULE(SCHEDULE), .SYNC(SYNC), .STREAM(STREAM), .TRIGGER(TRIGGER), .WORD_BITS(WORD_BITS)
    ) check (
        .clk(clk),
        .i_settle(settle), .i_command(command),
        .i_argument_0(argument_0), .i_argument_1(argument_1), .i_argument_2(argument_2), .i_tail_words(tail_words),
        .i_live_free(live_free), .i_stopped(stopped), .i_out_of_step(out_of_step), .i_top_index(top_index), .i_header_valid(header_valid),
        .i_gate_busy(gate_busy), .i_no_push(no_push), .i_ring_usable(ring_usable), .i_ring_fits(ring_fits),
        .i_stream_usable(stream_usable), .o_status(verdict));

    command_unit #(
        .WORD_BITS(WORD_BITS), .STATUS_WORDS(STREAM != 0 ? `HG_STATUS_WORDS : SCHEDULE != 0 ? `HG_STATUS_UNSTREAMED_WORDS : `HG_STATUS_UNTIMED_WORDS),
        .FOCI(FOCI), .STREAM(STREAM), .NET(NET),
        .LENGTH_BITS(RING_BITS + 2)
    ) commands (
        .clk(clk), .rst(rst),
        .i_valid(frame_valid), .o_take(frame_take), .i_word(frame_word),
        .o_command(command), .o_argument_0(argument_0), .o_argument_1(argument_1), .o_argument_2(argument_2),
        .o_tail_words(tail_words), .o_settle(settle), .i_status(verdict), .i_top_index(top_index),
        .o_execute(execute), .o_repeated(repeated), .o_refused(refused),
        .o_puts(puts), .o_more(more), .o_write(write), .i_hold(hold), .o_address(command_address), .o_region(region),
        .i_ring_address(ring_address), .i_ring_start(ring_start), .i_ring_wraps(ring_wraps), .i_ring_complete(ring_complete),
        .i_ring_split(ring_split), .o_streams(stream_takes), .o_close(closes), .i_stream_wait(stream_waits), .i_stream_place(stream_place), .i_stream_address(stream_address),
        .i_stream_keeps(stream_keeps), .i_stream_split(stream_split), .o_push(push), .o_keep(keep), .o_take_back(take_back),
        .o_answer(answer), .o_status(status), .o_sequence(sequence_number), .o_expected(expected), .o_read_words(read_words),
        .i_answered(answered), .i_ended(ended));

    // An autostart enables the outputs and turns the watchdog off, as if a host had sent ENABLE and WATCHDOG with 0.
    wire autostart;
    // What was sent before a switch-off (stale) does not enable, and what was sent before a STOP (unplayed) does not play.
    wire does_enable   = autostart || (execute && command == `HG_COMMAND_ENABLE && !stale && !ended);
    wire does_watchdog = autostart || (execute && command == `HG_COMMAND_WATCHDOG);
    wire does_sync     = SYNC != 0 && execute && command == `HG_COMMAND_SYNC;
    wire does_reset    = does_sync || (execute && command == `HG_COMMAND_RESET);
    wire asks          = read_words != 16'd0;  // of a command that is carried out: it only asks
    wire does_select   = execute && command == `HG_COMMAND_SELECT && !unplayed;
    wire starts_now    = execute && command == `HG_COMMAND_START;
    wire does_start    = starts_now && !unplayed;
    wire does_modulate = execute && command == `HG_COMMAND_MODULATE;
    wire keeps         = keep && !unplayed;
    wire takes_back    = take_back || (keep && unplayed);
    // What RESET resets: all that plays and supervises. The link goes on, and memories are not reset by anything.
    reg  play_rst;
    initial play_rst = 1'b0;
    always @(posedge clk) play_rst <= rst || does_reset;

    // ---- The address space, and the replies that are read from it

    wire [WORD_BITS-1:0]     reply_address;
    wire [PRIMARY_BITS-1:0]  load_address;
    wire [SEQUENCE_BITS-1:0] sequence_address;
    wire [15:0] primary_word, record_word, register_word, block_word, sample_word, answer_word, sdram_word;
    wire [31:0] sequence_word;
    wire        read, granted, loading, fetching, sampling, sdram_hold, sdram_granted;

    address_space #(
        .PRIMARY_WORDS(PRIMARY_WORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .WORD_BITS(WORD_BITS), .HAS_SAMPLES(MODULATION_DEPTH != 0 ? 1 : 0), .SDRAM(SDRAM),
        .PRIMARY_FILE(PRIMARY_FILE), .SEQUENCE_FILE(SEQUENCE_FILE)
    ) memories (
        .clk(clk), .i_region(region),
        .i_write(write), .i_write_address(command_address), .i_write_word(frame_word), .o_hold(hold),
        .i_read_address(reply_address), .i_register_word(block_word), .i_sample_word(sample_word), .o_granted(granted), .o_read_word(answer_word),
        .i_loading(loading), .i_load_address(load_address), .o_primary_word(primary_word),
        .i_fetching(fetching), .i_sequence_address(sequence_address), .o_sequence_word(sequence_word),
        .i_sampling(sampling), .i_sdram_hold(sdram_hold), .i_sdram_granted(sdram_granted), .i_sdram_word(sdram_word));

    reply_unit #(.WORD_BITS(WORD_BITS)) replies (
        .clk(clk), .rst(rst),
        .i_answer(answer), .i_sequence(sequence_number), .i_command(command), .i_status(status), .i_expected(expected),
        .i_live_level(live_level), .i_address(command_address), .i_words(read_words),
        .i_digest(command == `HG_COMMAND_DIGEST), .o_answered(answered),
        .o_read(read), .o_address(reply_address), .i_granted(granted), .i_read_word(answer_word),
        .o_valid(reply_valid), .i_ready(reply_ready), .o_word(reply_word), .o_last(reply_last));

    // ---- What to play next

    wire        live_valid, live_take, live_clear, preempt, drop, entry, take, follow, followed;
    wire        starts, kept, taken_back, mark, closed, plays_live, modulates, at_pass_end, waiting, late_change;
    wire [15:0] start_0, start_1, start_2, ring_index;
    wire [47:0] period;
    wire [31:0] live_entry;
    wire [15:0] next_index, next_dwell;
    wire [1:0]  source_tag;
    wire [15:0] source_index, source_dwell, stream_index;
    wire [1:0]  mode, source_mode, tag;
    wire        mute, fires, samples;
    wire [15:0] trigger_word;
    wire        source_entry, source_drop, streams, stream_begins, stream_entry, stream_drop;
    wire [3:0]  stream_counts;
    wire        supplants = does_select || starts || plays_live;  // something else than a stream begins
    wire [1:0]  next_tag = TRIGGER != 0 && !streams ? source_tag : 2'b00;
    assign {entry, next_index, next_dwell} = streams ? {stream_entry, stream_index, 16'd0} : {source_entry, source_index, source_dwell};
    assign {mode, drop} = {streams ? `HG_MODE_LIVE : source_mode, source_drop || stream_drop};

    live_fifo #(.DEPTH(LIVE_DEPTH)) live (
        .clk(clk), .rst(play_rst), .i_clear(live_clear),
        .i_push(push), .i_entry({argument_0, FOCI != 0 && command == `HG_COMMAND_PUSH_FOCI ? ring_index : frame_word}),
        .i_keep(kept), .i_take_back(taken_back), .i_mark(mark), .i_closed(closed),
        .o_free(live_free), .o_level(live_level),
        .o_valid(live_valid), .o_entry(live_entry), .i_take(live_take));

    index_source #(.SEQUENCE_DEPTH(SEQUENCE_DEPTH)) source (
        .clk(clk), .rst(play_rst || image_read), .i_fills(image),
        .i_select(does_select), .i_start(starts), .i_stop(stops || (stream_begins && !supplants)), .i_live(plays_live),
        .i_follow(follow && !streams), .o_followed(followed), .i_host((execute && !asks && !image) || heard || line_broken),
        .i_header(write && region == `HG_REGION_SEQUENCE && command_address == {WORD_BITS{1'b0}}), .i_header_word(frame_word[14:0]),
        .o_header_valid(header_valid),
        .i_argument_0(start_0), .i_argument_1(start_1), .i_argument_2(start_2),
        .o_fetching(fetching), .o_sequence_address(sequence_address), .i_sequence_word(sequence_word),
        .i_live_valid(live_valid), .i_live_empty(live_level == 16'd0), .i_live_entry(live_entry), .o_live_take(live_take), .o_live_clear(live_clear),
        .o_preempt(preempt), .o_drop(source_drop), .o_entry(source_entry), .i_take(take && !streams), .o_index(source_index), .o_dwell(source_dwell), .o_tag(source_tag),
        .o_mode(source_mode), .o_alone(alone), .o_autostart(autostart));

    wire disables = stale || line_broken || stopped || expired || out_of_step || rst;
    generate
        if (SCHEDULE != 0) begin : keeps_time
            schedule #(.TRIGGER(TRIGGER)) times (
                .clk(clk), .rst(play_rst), .i_count(period), .i_mode(source_mode),
                .i_gate(execute && command == `HG_COMMAND_GATE), .i_select(does_select), .i_start(does_start), .i_stop(stops),
                .i_modulate(does_modulate), .i_trigger(fires), .i_off(disables || guard_trip), .i_forget((execute && command == `HG_COMMAND_IDENTIFY) || ((starts_now || keep) && unplayed)),
                .i_argument_0(argument_0), .i_argument_1(argument_1), .i_argument_2(argument_2), .o_busy(gate_busy), .o_no_push(no_push),
                .o_start(starts), .o_follow(follow), .i_followed(followed),
                .o_argument_0(start_0), .o_argument_1(start_1), .o_argument_2(start_2),
                .i_push(push), .i_keep(keeps), .i_take_back(takes_back), .i_clear(live_clear),
                .o_keep(kept), .o_take_back(taken_back), .o_mark(mark), .o_closed(closed), .o_live(plays_live),
                .o_modulate(modulates), .o_at_pass_end(at_pass_end), .o_waiting(waiting), .o_late(late_change));
        end else begin : at_once
            assign {starts, start_0, start_1, start_2} = {does_start, argument_0, argument_1, argument_2};
            assign {kept, taken_back, plays_live, modulates} = {keeps, takes_back, keeps, does_modulate};
            assign {gate_busy, no_push, follow, mark, closed, at_pass_end, waiting, late_change} = 8'd0;
            wire unused = &{1'b0, followed, period, fires};
        end
    endgenerate

    // ---- Playing it

    wire record_refused, underrun;

    synchronizer #(.RESET_VALUE(1'b1)) stop_switch (.clk(clk), .rst(rst), .i_foreign(i_stop), .o_synchronous(stopped));

    // The records in an SDRAM: an entry goes on to the player when its record has been fetched.
    wire        to_play;
    wire [15:0] foci_base, foci_count;
    wire [2:0]  foci_last;
    generate
        if (SDRAM != 0) begin : in_sdram
            wire in_primary = region == `HG_REGION_PRIMARY;
            wire unused_busy;
            sdram_memory #(
                .CHANNELS(CHANNELS), .RECORDS(RECORDS), .FOCI(FOCI), .MIB(SDRAM), .RUN_BITS(RING_BITS - 1), .CLOCK_HZ(CLOCK_HZ)
            ) records (
                .clk(clk), .rst(rst),
                .i_more(more && in_primary), .i_write(write && in_primary), .i_ends(ring_wraps && command == `HG_COMMAND_PUSH_FOCI),
                .i_write_address(command_address[PRIMARY_BITS-1:0]), .i_write_word(frame_word), .o_hold(sdram_hold), .o_busy(unused_busy),
                .i_read(read && in_primary), .i_read_address(reply_address[PRIMARY_BITS-1:0]), .o_granted(sdram_granted), .o_read_word(sdram_word),
                .i_entry(entry), .i_index(next_index), .o_entry(to_play), .i_take(take),
                .i_foci_base(foci_base), .i_foci_count(foci_count), .i_foci_last(foci_last),
                .i_forget(puts && region == `HG_REGION_PARAMETERS), .i_load_address(load_address), .o_word(record_word),
                .o_sdram_command(o_sdram_command), .o_sdram_bank(o_sdram_bank), .o_sdram_address(o_sdram_address),
                .o_sdram_data(o_sdram_data), .o_sdram_drive(o_sdram_drive), .i_sdram_data(i_sdram_data));
            wire unused_word = &{1'b0, primary_word};
            flash_image from_flash (
                .clk(clk), .rst(rst), .i_valid(line_valid), .i_ends(line_broken || (NET != 0 && i_net_stop)), .i_failed(frame_damaged || refused),
                .o_active(image), .o_valid(image_valid), .o_byte(image_byte), .o_read(image_read), .o_state(flash),
                .o_cs_n(o_flash_cs_n), .o_clk(o_flash_clk), .o_data(o_flash_data), .i_data(i_flash_data));
        end else begin : in_block_ram
            assign {to_play, record_word} = {entry, primary_word};
            assign {sdram_hold, sdram_granted, sdram_word} = 18'd0;
            assign {o_sdram_command, o_sdram_bank, o_sdram_address, o_sdram_data, o_sdram_drive} = 49'd0;
            assign {image, image_valid, image_read, image_byte, flash} = 13'd0;
            assign {o_flash_cs_n, o_flash_clk, o_flash_data} = 3'b100;
            wire unused_sdram = &{1'b0, i_flash_data, line_valid, puts, more, i_sdram_data, foci_base, foci_count, foci_last};
        end
    endgenerate

    wire lingers, last, in_step, numbered, sync_missed;
    wire [1:0] role;
    wire together = role != `HG_ROLE_ALONE;
    board_sync #(.SYNC(SYNC), .SCHEDULE(SCHEDULE), .PERIOD_CLOCKS(IDLE_CLOCKS)) others (
        .clk(clk), .rst(rst), .play_rst(play_rst), .i_reset(does_reset), .i_takes_role(does_sync), .i_role(argument_0[1:0]),
        .i_sync(i_sync), .o_sync(o_sync), .i_last(last), .o_hold(lingers), .i_cycle_start(o_cycle_start),
        .o_role(role), .o_in_step(in_step), .o_out_of_step(out_of_step), .o_numbered(numbered),
        .o_missed(sync_missed), .o_lost(sync_lost), .o_period(period));

    wire modulated, bent_period, far_foci;
    generate
        if (WIDTH_BITS == 0) begin : one_width
            player #(
                .CHANNELS(CHANNELS), .RECORDS(RECORDS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .IDLE_CLOCKS(IDLE_CLOCKS),
                .MAX_HIGH_CLOCKS(MAX_HIGH_CLOCKS), .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS),
                .MAX_DUTY_256(MAX_DUTY_256), .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS), .SYNC(SYNC)
            ) play (
                .clk(clk), .rst(play_rst),
                .i_preempt(preempt), .i_drop(drop), .i_entry(to_play), .o_take(take), .i_index(next_index), .i_dwell(next_dwell), .i_tag(next_tag),
                .o_reading(loading), .o_address(load_address), .i_word(record_word),
                .i_enable(does_enable), .i_disable(disables), .i_mute(mute),
                .i_together(together), .i_hold(lingers), .o_last(last),
                .o_pins(o_pins), .o_enabled(o_enabled), .o_alive(o_alive), .o_index(o_index), .o_tag(tag), .o_cycle_start(o_cycle_start),
                .o_refused(record_refused), .o_underrun(underrun), .o_guard_trip(guard_trip));
            assign top_index  = RECORDS[15:0];
            assign block_word = TRIGGER != 0 && region == `HG_REGION_TRIGGER ? trigger_word : register_word;
            assign {ring_usable, ring_fits, ring_wraps, ring_complete, ring_split, ring_index, ring_address, ring_start} = 0;
            wire   unused = &{1'b0, at_pass_end, modulates, drop};
            assign {sample_word, sampling, modulated, bent_period, far_foci, samples} = 21'd0;
            assign {stream_usable, stream_waits, stream_place, stream_keeps, stream_split, stream_address, stream_counts} = 0;
            assign {streams, stream_begins, stream_entry, stream_drop, stream_index} = 20'd0;
            assign {foci_base, foci_count, foci_last} = 35'd0;
            wire   unused_stream = &{1'b0, stream_takes, closes};
        end else begin : own_widths
            wire [15:0] parameter_word, ring_word, stream_word, fade;
            wire        go, fades;
            wire [31:0] set_address = {{(32-WORD_BITS){1'b0}}, command_address}, read_address = {{(32-WORD_BITS){1'b0}}, reply_address};
            wire        unused = &{1'b0, set_address[31:16], read_address[31:16]};
            drive_player #(
                .CHANNELS(CHANNELS), .RECORDS(RECORDS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .WIDTH_BITS(WIDTH_BITS),
                .MODULATION_DEPTH(MODULATION_DEPTH), .SLEW(SLEW), .FOCI(FOCI), .IDLE_CLOCKS(IDLE_CLOCKS),
                .MAX_HIGH_CLOCKS(MAX_HIGH_CLOCKS), .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS), .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS),
                .MAX_DUTY_256(MAX_DUTY_256), .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS), .SYNC(SYNC)
            ) play (
                .clk(clk), .rst(play_rst),
                .i_preempt(preempt), .i_drop(drop), .i_entry(to_play), .o_take(take), .i_index(next_index), .i_dwell(next_dwell), .i_tag(next_tag),
                .o_reading(loading), .o_address(load_address), .i_word(record_word),
                .i_set_parameter(write && region == `HG_REGION_PARAMETERS), .i_set_geometry(write && region == `HG_REGION_GEOMETRY),
                .i_set_sample(write && region == `HG_REGION_MODULATION), .i_set_address(set_address[15:0]), .i_set_word(frame_word),
                .i_read_address(read_address[15:0]), .o_parameter_word(parameter_word), .o_sample_word(sample_word),
                .o_fetching(sampling), .o_foci_base(foci_base), .o_foci_count(foci_count), .o_foci_last(foci_last),
                .i_streams(streams || stream_drop), .o_go(go), .i_fades(fades), .i_fade(fade),
                .i_modulate(does_modulate), .i_divider(argument_0), .i_length(argument_1), .i_form(argument_2),
                .i_modulates(modulates), .i_at_pass_end(at_pass_end),
                .i_enable(does_enable), .i_disable(disables), .i_mute(mute),
                .i_together(together), .i_hold(lingers), .o_last(last),
                .o_pins(o_pins), .o_enabled(o_enabled), .o_alive(o_alive), .o_index(o_index), .o_tag(tag), .o_cycle_start(o_cycle_start),
                .o_refused(record_refused), .o_underrun(underrun), .o_guard_trip(guard_trip),
                .o_modulated(modulated), .o_samples(samples), .o_bent(bent_period), .o_far(far_foci));
            assign block_word = region == `HG_REGION_PARAMETERS ? parameter_word
                              : FOCI != 0 && region == `HG_REGION_RING ? ring_word
                              : STREAM != 0 && region == `HG_REGION_STREAM ? stream_word
                              : TRIGGER != 0 && region == `HG_REGION_TRIGGER ? trigger_word : register_word;
            // An index has 16 bits; focus records above that cannot be named.
            if (FOCI != 0) begin : with_foci
                wire [16:0] top = RECORDS[16:0] + {1'b0, foci_count};
                assign top_index = top[16] ? 16'hffff : top[15:0];
                focus_ring #(
                    .PRIMARY_WORDS(PRIMARY_WORDS), .RECORDS(RECORDS), .LIVE_DEPTH(LIVE_DEPTH), .WORD_BITS(WORD_BITS)
                ) ring (
                    .clk(clk),
                    .i_set(write && region == `HG_REGION_RING), .i_set_address(set_address[4:0]), .i_set_word(frame_word),
                    .i_read_address(read_address[4:0]), .o_word(ring_word),
                    .i_foci_last(foci_last), .i_top_index(top_index), .i_live_free(live_free), .i_tail_words(tail_words),
                    .o_usable(ring_usable), .o_fits(ring_fits),
                    .i_settle(settle), .i_write(write), .i_address(command_address), .i_keep(keep && command == `HG_COMMAND_PUSH_FOCI),
                    .o_address(ring_address), .o_start(ring_start), .o_wraps(ring_wraps), .o_complete(ring_complete),
                    .o_index(ring_index), .o_split(ring_split));
            end else begin : without_foci
                assign top_index = RECORDS[15:0];
                assign {ring_usable, ring_fits, ring_wraps, ring_complete, ring_split, ring_index, ring_address, ring_start, ring_word} = 0;
                wire unused_count = &{1'b0, foci_base, foci_count, foci_last};
            end
            if (STREAM != 0) begin : with_stream
                // Whatever else is to play or switches outputs off ends a stream, and so does another session, or a word that says where foci lie.
                wire moves   = write && region == `HG_REGION_PARAMETERS && set_address[15:2] == 14'd0 && set_address[1:0] != 2'd3;
                wire sets    = write && region == `HG_REGION_STREAM;
                reg  forgets_q;
                always @(posedge clk) forgets_q <= supplants || followed || stops || unplayed || disables || guard_trip || play_rst || moves
                                                   || (execute && command == `HG_COMMAND_IDENTIFY);
                pattern_stream #(
                    .SLOTS(STREAM), .CHANNELS(CHANNELS), .RECORDS(RECORDS), .FOCI(FOCI), .WORD_BITS(WORD_BITS)
                ) patterns (
                    .clk(clk), .i_forget(forgets_q),
                    .i_set(sets), .i_set_address(set_address[4:0]), .i_set_word(frame_word), .i_read_address(read_address[4:0]), .o_word(stream_word),
                    .i_foci_base(foci_base), .i_foci_count(foci_count), .i_foci_last(foci_last),
                    .o_usable(stream_usable), .i_settle(settle && command == `HG_COMMAND_STREAM), .i_period({argument_2, argument_1, argument_0}),
                    .i_take(stream_takes), .i_close(closes), .o_wait(stream_waits), .o_place(stream_place), .o_address(stream_address),
                    .o_keeps(stream_keeps), .o_split(stream_split),
                    .o_late(stream_counts[0]), .o_lost(stream_counts[1]), .o_early(stream_counts[2]), .o_repeated(stream_counts[3]),
                    .i_go(go), .i_count(period), .o_begins(stream_begins), .o_streams(streams), .o_drop(stream_drop),
                    .o_entry(stream_entry), .o_index(stream_index), .i_take_entry(take && streams), .o_fades(fades), .o_fade(fade));
            end else begin : without_stream
                assign {stream_usable, stream_waits, stream_place, stream_keeps, stream_split, stream_address, stream_counts} = 0;
                assign {streams, stream_begins, stream_entry, stream_drop, stream_index, stream_word, fades, fade} = 53'd0;
                wire unused_stream = &{1'b0, stream_takes, closes, go, foci_base};
            end
        end
    endgenerate

    // ---- Triggers

    generate
        if (TRIGGER != 0) begin : with_trigger
            wire [31:0] address = {{(32-WORD_BITS){1'b0}}, command_address};
            wire        unused_address = &{1'b0, address[31:5]};
            trigger #(.CHANNELS(CHANNELS)) triggers (
                .clk(clk), .rst(rst),
                .i_set(write && region == `HG_REGION_TRIGGER), .i_set_address(address[4:0]), .i_set_word(frame_word),
                .i_answer(answer), .i_read_address(reply_address[4:0]), .o_word(trigger_word),
                .i_pins(o_pins), .i_enabled(o_enabled), .i_playing(o_playing), .i_cycle_start(o_cycle_start), .i_tag(tag), .i_index(o_index),
                .i_samples(samples), .o_trigger(o_trigger), .o_test(o_test), .i_trigger(i_trigger), .o_fires(fires), .o_mute(mute));
        end else begin : without_trigger
            assign {trigger_word, o_trigger, o_test, fires, mute} = 20'd0;
            wire unused_trigger = &{1'b0, i_trigger, tag, samples, source_tag};
        end
    endgenerate

    // ---- Supervision

    wire [15:0] watchdog_ms;

    watchdog #(.CLOCK_HZ(CLOCK_HZ), .DEFAULT_MS(WATCHDOG_MS)) dog (
        .clk(clk), .rst(play_rst),
        .i_running(o_enabled), .i_kick(execute && command != `HG_COMMAND_IDENTIFY),
        .i_set(does_watchdog), .i_milliseconds(autostart ? 16'd0 : argument_0), .o_milliseconds(watchdog_ms),
        .o_expired(expired));

    wire [15:0] identity_word;
    identity_block #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .LIVE_DEPTH(LIVE_DEPTH),
        .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .CLOCK_HZ(CLOCK_HZ), .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS),
        .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256), .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS),
        .WIDTH_BITS(WIDTH_BITS), .MODULATION_DEPTH(MODULATION_DEPTH), .SLEW(SLEW), .FOCI(FOCI), .SCHEDULE(SCHEDULE), .SYNC(SYNC), .CHAIN(CHAIN), .NET(NET), .STREAM(STREAM), .TRIGGER(TRIGGER),
        .FRAME_BYTES(FRAME_BYTES)
    ) identity (.i_address(reply_address[4:0]), .o_word(identity_word));
    generate
        if (NET != 0) begin : asked_by_anybody
            identity_block #(
                .CHANNELS(CHANNELS), .RECORDS(RECORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .LIVE_DEPTH(LIVE_DEPTH),
                .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS), .CLOCK_HZ(CLOCK_HZ), .MIN_PULSE_CLOCKS(MIN_PULSE_CLOCKS),
                .MAX_PULSE_CLOCKS(MAX_PULSE_CLOCKS), .MAX_DUTY_256(MAX_DUTY_256), .MAX_CYCLE_CLOCKS(MAX_CYCLE_CLOCKS),
                .WIDTH_BITS(WIDTH_BITS), .MODULATION_DEPTH(MODULATION_DEPTH), .SLEW(SLEW), .FOCI(FOCI), .SCHEDULE(SCHEDULE), .SYNC(SYNC), .CHAIN(CHAIN), .NET(NET), .STREAM(STREAM), .TRIGGER(TRIGGER),
                .FRAME_BYTES(FRAME_BYTES)
            ) identity_again (.i_address(i_identity_place), .o_word(o_identity_word));
        end else begin : asked_by_the_host
            assign o_identity_word = 16'd0;
            wire unused_place = &{1'b0, i_identity_place};
        end
    endgenerate

    register_file #(.SCHEDULE(SCHEDULE), .STREAM(STREAM)) registers (
        .clk(clk), .rst(play_rst),
        .i_read(read), .i_is_identity(region == `HG_REGION_IDENTITY), .i_address(reply_address[4:0]), .i_identity_word(identity_word), .o_word(register_word),
        .i_enabled(o_enabled), .i_stopped(stopped), .i_modulated(modulated), .i_mode(mode), .i_present_index(o_index), .i_live_level(live_level), .i_watchdog_ms(watchdog_ms),
        .i_sync({numbered, in_step, role}),
        .i_underrun(underrun), .i_record_refused(record_refused),
        .i_frame_good(frame_good), .i_frame_damaged(frame_damaged), .i_frame_repeated(repeated), .i_frame_refused(refused),
        .i_watchdog_trip(expired), .i_guard_trip(guard_trip), .i_bent_period(bent_period), .i_far_foci(far_foci),
        .i_sync_missed(sync_missed), .i_sync_lost(sync_lost),
        .i_late_change(late_change), .i_stream(stream_counts), .i_waiting(waiting), .i_streaming(streams), .i_flash(flash), .i_answer(answer), .i_period(period));

    reg fault_q;
    initial fault_q = 1'b0;
    always @(posedge clk) begin
        if (play_rst) fault_q <= 1'b0;
        else if (guard_trip || expired || (sync_lost && o_enabled)) fault_q <= 1'b1;
        else if (does_enable) fault_q <= 1'b0;
    end
    assign o_fault   = fault_q;
    assign o_playing = o_enabled && o_index != 16'd0;
endmodule
`default_nettype wire
