// SPDX-License-Identifier: Apache-2.0
//
// Proves contract 3: a load sees all of a frame's words in its record as they were before the frame, or all as they are after it,
// never some of each.
//
// memory_controller reads records while one frame is written as command_unit writes it: from any word to any other, ascending, one
// word a clock, without pause. Loads follow each other and may be preempted. One frame is enough, because the promise is about
// each frame. The memory is modelled by one bit: bit 0 of a word that arrives is 1 when the frame had written that word before the
// clock of its address. The other bits are 0, because how long a load takes does not depend on the words.
`default_nettype none
// The modules' own assertions are left out, because they would find the planted bugs first.
`undef FORMAL
`include "serial_product.v"
`include "record_header.v"
`include "memory_controller.v"
`default_nettype none
module torn #(
    parameter CHANNELS = 2
) (
    input wire        clk,
    input wire        i_entry,
    input wire        i_second,  // of the two records
    input wire        i_preempt,
    input wire        i_begin  // of the frame; the first one counts
);
    localparam STRIDE = CHANNELS + 4, WORDS = 2 * STRIDE, ADDRESS_BITS = $clog2(WORDS);

    (* anyconst *) wire [4:0] f_from, f_to;  // the frame's first word, and the one after its last

    reg  rst_done_q;
    wire rst = !rst_done_q;
    initial rst_done_q = 1'b0;

    wire        take, reading, shift, ready, silent, refused;
    wire [ADDRESS_BITS-1:0] address;
    // The writer
    reg        f_begun_q;
    reg [4:0]  f_at_q;  // next word to write
    reg        f_written_q, f_shown_q;
    // A word that is being read waits: the core holds the writer for that clock.
    wire       hold  = reading && address == f_at_q[ADDRESS_BITS-1:0];
    wire       write = !rst && !hold && (f_begun_q ? f_at_q != f_to : i_begin);
    wire       ended = (f_begun_q && f_at_q == f_to) || (write && f_at_q + 5'd1 == f_to);  // with this clock at the latest
    initial f_begun_q = 1'b0;
    wire [15:0] word = {15'd0, f_shown_q};
    memory_controller #(.CHANNELS(CHANNELS), .RECORDS(2), .TIMING_BITS(4), .PULSE_BITS(3), .PRESCALER_BITS(1)) loader (
        .clk(clk), .rst(rst), .i_preempt(i_preempt), .i_entry(i_entry), .i_settled(1'b1), .o_take(take), .i_index({14'd0, i_second, !i_second}), .i_dwell(16'd1),
        .o_reading(reading), .o_address(address), .i_word(word), .o_shift(shift), .o_timing(), .i_commit(1'b1),
        .i_foci_base(16'd0), .i_foci_count(16'd0), .i_foci_last(3'd0), .i_foci_cycle(16'd0), .o_amplitudes(), .o_foci(),
        .o_ready(ready), .o_silent(silent), .o_index(), .o_dwell(), .o_cycle_length(), .o_prescaler(), .o_pulse_length(),
        .o_refused(refused));
    // What the present load has seen, by the addresses it read. After the record's last word it may read on; that does not count.
    reg              f_loads_q, f_reading_q, f_read_q, f_done_q, f_old_q, f_new_q, f_met_q, f_ended_q, f_was_old_q;
    reg [4:0]        f_base_q, f_address_q, f_arrived_q, f_count_q;
    wire             f_reads = reading && f_count_q < STRIDE;
    reg [STRIDE-1:0] f_seen_q;
    initial {f_loads_q, f_reading_q, f_read_q, f_done_q, f_was_old_q} = 5'b00000;

    wire        arrives = f_loads_q && f_read_q;
    wire        covered = f_arrived_q >= f_from && f_arrived_q < f_to;
    wire [4:0]  number  = f_arrived_q - f_base_q;
    wire        done    = f_done_q;  // the last word arrives in the clock before
    wire        meets   = f_from < f_base_q + STRIDE && f_to > f_base_q;
    wire        whole   = f_from <= f_base_q && f_to >= f_base_q + STRIDE;

    always @(posedge clk) begin
        assume (f_from < f_to && f_to <= WORDS);
        rst_done_q <= 1'b1;
        if (rst) f_at_q <= f_from;
        if (write) {f_begun_q, f_at_q} <= {1'b1, f_at_q + 1'b1};

        f_done_q    <= ready && f_loads_q && !f_done_q && !i_preempt;
        f_reading_q <= f_reads && !rst && !i_preempt;
        if (f_reads) f_count_q <= f_count_q + 5'd1;
        f_read_q    <= f_reading_q && !i_preempt;
        f_address_q <= {1'b0, address};
        f_arrived_q <= f_address_q;
        f_shown_q   <= f_written_q;
        f_written_q <= !rst && address >= f_from && address < f_at_q;
        if (f_loads_q && write) f_met_q <= 1'b1;
        if (arrives) begin
            if (covered && word[0]) f_new_q <= 1'b1;
            if (covered && !word[0]) f_old_q <= 1'b1;
            if (number < STRIDE) f_seen_q[number[2:0]] <= 1'b1;
        end
        if (rst || i_preempt || done) f_loads_q <= 1'b0;
        if (take) begin
            f_loads_q <= 1'b1;
            f_base_q  <= i_second ? STRIDE : 5'd0;
            f_count_q <= 5'd0;
            f_ended_q <= ended;
            {f_old_q, f_new_q, f_met_q} <= 3'b000;
            f_seen_q <= {STRIDE{1'b0}};
        end
        if (done && f_met_q && f_old_q) f_was_old_q <= 1'b1;

        if (!rst) begin
            assert (!(f_old_q && f_new_q) || !f_loads_q);
            assert (!f_reads || address < WORDS);
            assert (!done || &f_seen_q);                        // every word of the record
            assert (!arrives || number < STRIDE);
            assert (!done || f_ended_q || !f_new_q || f_met_q);  // nothing new before it was written
            assert (!done || !f_ended_q || !f_old_q);           // once written, it is seen
            assert (!done || (f_old_q || f_new_q) == meets);
            cover (done && f_met_q && whole && f_old_q && !ended);
            cover (done && f_met_q && whole && f_new_q && !f_ended_q);
            cover (done && f_met_q && f_old_q && !whole && f_from > f_base_q);
            cover (done && f_met_q && f_new_q && !whole && f_to < f_base_q + STRIDE);
            cover (done && f_was_old_q && f_new_q);             // the second load has it
        end
    end

    wire f_unused = &{1'b0, shift, silent, refused};
endmodule
`default_nettype wire
