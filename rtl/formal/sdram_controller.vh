// SPDX-License-Identifier: Apache-2.0
// What sdram_controller promises the chip. It is derived from the pins alone: how many clocks ago each command was there.
reg        f_reset_seen_q, f_open_q, f_set_q;
reg [4:0]  f_activate_q, f_precharge_q, f_refresh_q, f_write_q, f_read_q;  // clocks since the last one; 31 is long ago
reg [3:0]  f_refreshes_q;                                                  // up to 15
reg [10:0] f_row_q;
reg [BANK_BITS-1:0] f_bank_q;
reg [WORD_BITS-1:0] f_address_q;    // of the present run's next word
reg [COUNT_BITS:0]  f_left_q;       // words of it that are still to come
reg [2:0]           f_coming_q;
initial {f_reset_seen_q, f_open_q, f_set_q, f_refreshes_q, f_left_q, f_coming_q} = 0;
initial {f_activate_q, f_precharge_q, f_refresh_q, f_write_q, f_read_q} = {25{1'b1}};

wire f_activates = o_command == ACTIVATE, f_precharges = o_command == PRECHARGE, f_refreshes = o_command == REFRESH;
wire f_writes = o_command == WRITE, f_reads = o_command == READ, f_sets = o_command == MODE;
// As it will be in the next clock.
wire       f_open_d      = f_activates || (f_open_q && !f_precharges);
wire       f_set_d       = f_set_q || f_sets;
wire [4:0] f_activate_d  = f_activates ? 5'd1 : f_activate_q + {4'd0, f_activate_q != 5'd31};
wire [4:0] f_precharge_d = f_precharges ? 5'd1 : f_precharge_q + {4'd0, f_precharge_q != 5'd31};
wire [4:0] f_refresh_d   = f_refreshes || f_sets ? 5'd1 : f_refresh_q + {4'd0, f_refresh_q != 5'd31};  // a new mode needs its time, too
wire [4:0] f_write_d     = f_writes ? 5'd1 : f_write_q + {4'd0, f_write_q != 5'd31};
wire [4:0] f_read_d      = f_reads ? 5'd1 : f_read_q + {4'd0, f_read_q != 5'd31};
wire [10:0] f_row_d      = f_activates ? o_address : f_row_q;
wire [BANK_BITS-1:0] f_bank_d = f_activates ? o_bank : f_bank_q;
wire [COUNT_BITS:0]  f_left_d = f_left_q - {{COUNT_BITS{1'b0}}, f_reads || f_writes};
wire [5:0] f_rest = {2'd0, rest_q}, f_stay = {2'd0, open_q};

always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    {f_open_q, f_set_q, f_row_q, f_bank_q} <= {f_open_d, f_set_d, f_row_d, f_bank_d};
    {f_activate_q, f_precharge_q, f_refresh_q, f_write_q, f_read_q} <= {f_activate_d, f_precharge_d, f_refresh_d, f_write_d, f_read_d};
    if (f_refreshes && f_refreshes_q != 4'd15) f_refreshes_q <= f_refreshes_q + 4'd1;
    f_coming_q <= {f_coming_q[1:0], f_reads};
    if (f_reads || f_writes) f_address_q <= f_address_q + 1'b1;
    f_left_q <= f_left_d;
    if (o_take) {f_address_q, f_left_q} <= {i_first, {1'b0, i_last} + 1'b1};
    // After a reset the chip is set up anew, behind a pause that is longer than all its times.
    if (rst) begin
        {f_open_q, f_set_q, f_refreshes_q, f_left_q, f_coming_q} <= 0;
        {f_activate_q, f_precharge_q, f_refresh_q, f_write_q, f_read_q} <= {25{1'b1}};
    end

    if (f_reset_seen_q) begin
        // The pins
        case (o_command)
            ACTIVATE:  assert (f_set_q && !f_open_q && f_precharge_q >= ROW_CLOCKS && f_refresh_q >= FRESH_CLOCKS && f_activate_q >= ACTIVE_CLOCKS + ROW_CLOCKS);
            READ, WRITE: begin
                assert (f_open_q && f_activate_q >= ROW_CLOCKS && o_address[10:8] == 3'd0);
                assert (f_left_q != 0 && {f_row_q, o_bank, o_address[7:0]} == f_address_q && o_bank == f_bank_q);
                assert (f_writes == o_drive);
            end
            PRECHARGE: assert (o_address[10] && (!f_open_q || (f_activate_q >= ACTIVE_CLOCKS && f_write_q >= WRITTEN_CLOCKS)));
            REFRESH:   assert (!f_open_q && f_precharge_q >= ROW_CLOCKS && f_refresh_q >= FRESH_CLOCKS);
            MODE:      assert (!f_set_q && !f_open_q && f_refreshes_q >= FIRST_REFRESHES && f_refresh_q >= FRESH_CLOCKS && o_address == 11'h020 && o_bank == 0);
            default:   assert (o_command == NOP);
        endcase
        assert (!o_drive || f_read_q > 5'd2);
        assert (o_valid == f_coming_q[2]);
        assert (!o_take || f_left_d == 0);

        // What makes that inductive
        assert (state_q <= CLOSE);
        assert (f_set_d == (state_q != START && state_q != SET_UP));
        assert (f_open_d == (state_q == RUN || state_q == CLOSE));
        if (state_q == SET_UP) assert (set_up_q <= FIRST_REFRESHES && {1'b0, f_refreshes_q} + {4'd0, f_refreshes} + {1'b0, set_up_q} >= FIRST_REFRESHES);
        if (state_q == OPEN || state_q == IDLE || state_q == SET_UP) assert ({1'b0, f_precharge_d} + f_rest >= ROW_CLOCKS);
        if (state_q != START) assert ({1'b0, f_refresh_d} + f_rest >= FRESH_CLOCKS || state_q == RUN || state_q == CLOSE);
        if (state_q == RUN || state_q == CLOSE) assert (f_refresh_d >= FRESH_CLOCKS);
        if (state_q == OPEN || state_q == IDLE) assert ({1'b0, f_activate_d} + f_rest >= ACTIVE_CLOCKS + ROW_CLOCKS);
        if (state_q == RUN) assert ({1'b0, f_activate_d} + f_rest >= ROW_CLOCKS);
        if (state_q == RUN || state_q == CLOSE) assert ({1'b0, f_activate_d} + f_stay >= ACTIVE_CLOCKS);
        if (state_q == CLOSE) assert ({1'b0, f_write_d} + f_rest >= WRITTEN_CLOCKS || f_write_d == f_activate_d);
        assert (coming_q == {f_coming_q, f_reads});
        if (state_q == START || state_q == SET_UP)
            assert (coming_q == 4'd0 && f_left_d == 0 && f_activate_d == 5'd31 && f_write_d == 5'd31 && f_read_d == 5'd31);
        if (state_q == IDLE) assert (f_left_d == 0);
        if (state_q == OPEN || state_q == RUN)
            assert (f_left_d == {1'b0, left_q} + 1'b1 && address_q == f_address_q + {{(WORD_BITS-1){1'b0}}, f_reads || f_writes});
        if (state_q == RUN) assert (f_row_d == row && f_bank_d == bank);
        if (state_q == CLOSE) assert (goes_on_q ? f_left_d == {1'b0, left_q} + 1'b1 && address_q == f_address_q + {{(WORD_BITS-1){1'b0}}, f_reads || f_writes} : f_left_d == 0);
        // Nothing is driven for two clocks behind a word that was asked for.
        if (writes_q && (state_q == OPEN || state_q == RUN || state_q == CLOSE)) assert (f_read_d > 5'd2);
        assert (f_coming_q[0] == (f_read_q == 5'd1) && (f_coming_q[1] || f_read_q != 5'd2) && (f_coming_q[2] || f_read_q != 5'd3));
        cover (f_sets);
        cover (f_writes && o_done);
        cover (o_valid && o_done);
        cover (f_refreshes && f_set_q);
    end
end
