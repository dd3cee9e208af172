// SPDX-License-Identifier: Apache-2.0
// What memory_controller promises. It is derived from the clock that took the entry and from the addresses that were read, not
// from the state machine.
localparam [15:0] F_CHANNELS = CHANNELS[15:0];
localparam [15-WORD_BITS:0] F_PAD = 0;  // makes 16 bits of a word's number
localparam [15:0] F_HEADER = `HG_RECORD_HEADER_WORDS;
// Clocks from the one after taking an entry: to the last word, to the end of the products, and to ready.
localparam [15:0] F_ARRIVED = F_CHANNELS + 16'd6, F_CHECKED = 16'd7 + PRESCALER_BITS;
localparam [15:0] F_LOADED  = F_ARRIVED > F_CHECKED ? F_ARRIVED : F_CHECKED + 16'd1;
reg        f_reset_seen_q, f_taken_q, f_reading_q, f_read_q, f_ready_q;
reg [15:0] f_since_q;   // clocks since the one after the entry was taken
reg [15:0] f_shifts_q;  // since then
reg [15:0] f_index_q, f_dwell_q;
reg [ADDRESS_BITS-1:0] f_base_q, f_address_q, f_arrived_q;  // of words; the solver cannot handle wider products
reg [15:0] f_header_0_q, f_header_1_q, f_header_2_q, f_header_3_q;
initial f_reset_seen_q = 1'b0;

wire [26:0] f_first_word = {11'd0, i_index - 16'd1} * STRIDE;
wire [26:0] f_asked     = {11'd0, F_PAD, asked_q};
wire [26:0] f_comes     = {11'd0, F_PAD, comes_q};
wire        f_unused    = &{1'b0, f_first_word, f_asked, f_comes};
wire        f_loads     = f_index_q != 16'd0 && f_index_q <= TOP_INDEX;
wire        f_loading   = f_taken_q && f_loads && f_since_q < F_ARRIVED;
wire [ADDRESS_BITS-1:0] f_narrow = f_arrived_q - f_base_q;
wire [26:0] f_number    = {{(27-ADDRESS_BITS){1'b0}}, f_narrow};  // of the word in i_word
wire [23:0] f_cycle     = {f_header_1_q[7:0], f_header_0_q};
wire [23:0] f_prescaler = {f_header_3_q[7:0], f_header_2_q};
wire [7:0]  f_pulse     = f_header_1_q[15:8];
wire        f_small     = {1'b0, f_prescaler} >> PRESCALER_BITS == 25'd0;
// serial_product has a proof of its own; here its results are taken as they are.
wire        f_playable  = !cycle_over && cycle_clocks != 0 && cycle_clocks <= LONGEST_CYCLE
                          && (f_pulse == 0 || (!pulse_over && pulse_clocks >= SHORTEST_PULSE && pulse_clocks <= LONGEST_PULSE))
                          && 256 * {24'd0, f_pulse} <= {8'd0, f_cycle} * MAX_DUTY_256 && f_pulse >> PULSE_BITS == 0 && f_header_3_q[15:8] == 0 && f_small;
wire [15:0] f_turns     = f_since_q < 16'd7 ? 16'd0 : f_since_q < F_CHECKED ? f_since_q - 16'd7 : PRESCALER_BITS;  // of the prescaler
wire [PRESCALER_BITS-1:0]   f_low    = f_prescaler[PRESCALER_BITS-1:0];
wire [PRESCALER_BITS-1:0]   f_turned = f_low << f_turns | f_low >> (PRESCALER_BITS - f_turns);
reg  [23:0] f_bits_q;   // that went into the products
wire [TIMING_BITS-1:0] f_narrowed = i_word >> (TIMING_BITS - 1) > 1 ? {TIMING_BITS{1'b1}} : i_word[TIMING_BITS-1:0];

always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    f_reading_q    <= o_reading && !i_preempt && !rst && f_since_q != F_ARRIVED - 16'd1;  // what is read behind the last one does not count
    f_read_q       <= f_reading_q && !i_preempt && !rst;
    f_address_q    <= o_address;
    f_arrived_q    <= f_address_q;
    f_ready_q      <= o_ready;
    if (f_since_q != 16'hffff) f_since_q <= f_since_q + 16'd1;
    if (o_shift) f_shifts_q <= f_shifts_q + 16'd1;
    if (f_read_q && f_number == 0) f_header_0_q <= i_word;
    if (f_read_q && f_number == 1) f_header_1_q <= i_word;
    if (f_read_q && f_number == 2) f_header_2_q <= i_word;
    if (f_read_q && f_number == 3) f_header_3_q <= i_word;
    if (!header_q) f_bits_q <= 24'd0;
    else if (checks) f_bits_q <= {f_bits_q[22:0], next_bit};
    if (o_take) begin
        {f_index_q, f_dwell_q, f_since_q, f_shifts_q} <= {i_index, i_dwell, 16'd0, 16'd0};
        f_base_q <= f_first_word[ADDRESS_BITS-1:0];
    end
    if (rst || i_preempt) f_taken_q <= 1'b0;
    else if (o_take) f_taken_q <= 1'b1;
    else if (o_ready && i_commit) f_taken_q <= 1'b0;

    if (f_reset_seen_q) begin
        assert (o_take == (i_entry && i_settled && !i_preempt && !f_taken_q));
        assert (o_ready == (f_taken_q && f_since_q >= (f_loads ? F_LOADED : 16'd1)));
        assert (o_reading == (f_loading && f_since_q != 16'd0) && (!f_taken_q || places_q == (f_since_q == 16'd0)));
        assert ((state_q == IDLE) == !f_taken_q && state_q != 2'd3);
        assert (seeks_q == 2'd0);  // of foci alone
        assert (!f_taken_q || f_base_q == first_word[ADDRESS_BITS-1:0]);
        assert (coming_q == (f_loading && f_since_q >= 16'd2) && f_reading_q == coming_q);
        assert (arrives_q == (f_taken_q && f_loads && f_since_q >= 16'd3 && f_since_q <= F_ARRIVED) && f_read_q == arrives_q);
        assert (!arrives_q || ({F_PAD, arrived_q} == f_since_q - 16'd3 && f_number == {11'd0, F_PAD, arrived_q}));
        if (f_loading) begin
            assert (f_since_q > F_ARRIVED - 16'd2 || places_q || {F_PAD, asked_q} == f_since_q - 16'd1);
            assert (f_since_q > F_ARRIVED - 16'd2 || places_q || o_address == f_base_q + f_asked[ADDRESS_BITS-1:0]);
            assert (!coming_q || ({F_PAD, comes_q} == f_since_q - 16'd2 && f_address_q == f_base_q + f_comes[ADDRESS_BITS-1:0]));
            assert (f_shifts_q == (f_since_q < 16'd7 ? 16'd0 : f_since_q - 16'd7));
            assert (f_since_q < 16'd4 || o_cycle_length[15:0] == f_header_0_q);
            assert (f_since_q < 16'd5 || {pulse_field_q, o_cycle_length[23:16]} == f_header_1_q);
            assert (f_since_q != 16'd6 || o_prescaler[15:0] == f_header_2_q);
        end
        if (f_taken_q && f_loads) begin
            assert (f_since_q < F_ARRIVED || f_shifts_q + {15'd0, f_since_q == F_ARRIVED} == F_CHANNELS);
            assert (here_q == (f_since_q >= F_ARRIVED) && header_q == (f_since_q >= 16'd7));
            if (header_q) begin
                assert ({11'd0, steps_q} == PRESCALER_BITS - f_turns && o_prescaler[PRESCALER_BITS-1:0] == f_turned);
                assert ({1'b0, o_prescaler} >> PRESCALER_BITS == {1'b0, f_prescaler} >> PRESCALER_BITS);
                assert (f_bits_q == ((f_prescaler & ~(24'hffffff << PRESCALER_BITS)) >> steps_q));
                assert (o_cycle_length == f_cycle && pulse_field_q == f_pulse);
                assert (malformed_q == !(256 * {24'd0, f_pulse} <= {8'd0, f_cycle} * MAX_DUTY_256 && f_pulse >> PULSE_BITS == 0 && f_header_3_q[15:8] == 0 && f_small));
                assert (f_pulse != 0 || (pulse_clocks == 0 && !pulse_over));
            end
        end
        // The right words, in order, and all of them, the last one in the first clock of ready.
        if (o_shift) begin
            assert (arrives_q && f_read_q && f_shifts_q < F_CHANNELS);
            assert (f_number == {11'd0, F_HEADER + f_shifts_q} && o_timing == f_narrowed);
        end
        if (o_ready && f_loads) begin
            assert (o_shift == (f_since_q == F_ARRIVED) && f_shifts_q + {15'd0, o_shift} == F_CHANNELS && o_silent == !f_playable);
            assert (o_cycle_length == f_cycle && o_prescaler == f_prescaler && {pulse_field_q} == f_pulse);
        end
        if (o_ready && !f_loads) assert (o_silent);
        if (f_taken_q) assert (o_index == f_index_q && o_dwell == f_dwell_q);
        assert (o_refused == (f_taken_q && o_ready && !f_ready_q && o_silent && f_index_q != 16'd0) || $past(rst || i_preempt));
        if ($past(rst || i_preempt)) assert (!o_ready && !o_shift && !o_reading && !o_refused);
        cover (o_ready && f_loads && !o_silent && i_commit && f_since_q == F_LOADED);
        cover (o_refused && f_loads);
        cover (o_refused && !f_loads);
        cover (o_shift && i_preempt);
    end
end
