// SPDX-License-Identifier: Apache-2.0
//
// sdram_memory and a chip, with the registers of a board's pins between them. Frames write runs of every length; then records are read, as memory_controller
// does, beside a writer that never rests. All words of a record hold the number of its last writing, so one that is torn, or older than what
// had been written when it was asked for, shows. The last line says what was found.
// PHASE_NS is by how much the chip's clock is later than the core's; PAD_NS what a pad takes, either way. The T_… are the chip's.
`timescale 1ns / 1ps
`default_nettype none
module sdram_bench;
    parameter MIB = 4, READS = 300, SEED = 1, PHASE_NS = 5, PAD_NS = 2;
    parameter real T_START = 200000, T_RCD = 21, T_RP = 21, T_RAS = 49, T_RC = 70, T_RRD = 14, T_RFC = 70, T_WR = 39, T_MRD = 39, T_REFRESH = 15625;
    localparam CHANNELS = 100, RECORDS = 16383, RECORD_WORDS = CHANNELS + 4, FEW = 40;
    localparam BANK_BITS = MIB == 8 ? 2 : 1, BITS = $clog2(RECORDS * RECORD_WORDS);

    reg clk = 1'b0, rst = 1'b1, late = 1'b0;
    always #10 clk = !clk;
    always @(clk) late <= #(PHASE_NS + PAD_NS) clk;

    // ---- The board: registers and pads

    wire [2:0]  command;
    wire [1:0]  bank;
    wire [10:0] address;
    wire [31:0] data, pins;
    wire        drive;
    reg  [2:0]  command_q = 3'b111;
    reg  [1:0]  bank_q;
    reg  [10:0] address_q;
    reg  [31:0] data_q, arrived_q;
    reg         drive_q = 1'b0;
    wire [31:0] arrives;
    assign #(PAD_NS) arrives = pins;
    assign pins = drive_q ? data_q : 32'bz;
    always @(posedge clk) begin
        command_q <= #(PAD_NS) command;
        bank_q    <= #(PAD_NS) bank;
        address_q <= #(PAD_NS) address;
        data_q    <= #(PAD_NS) data;
        drive_q   <= #(PAD_NS) drive;
        arrived_q <= arrives;
    end
    sdram_chip #(
        .BANK_BITS(BANK_BITS), .T_START(T_START), .T_RCD(T_RCD), .T_RP(T_RP), .T_RAS(T_RAS), .T_RC(T_RC), .T_RRD(T_RRD), .T_RFC(T_RFC),
        .T_WR(T_WR), .T_MRD(T_MRD), .T_REFRESH(T_REFRESH)
    ) chip (
        .clk(late), .i_ras_n(command_q[2]), .i_cas_n(command_q[1]), .i_we_n(command_q[0]), .i_bank(bank_q[BANK_BITS-1:0]),
        .i_address(address_q), .io_data(pins));

    // ---- The memory and its users

    reg             more = 1'b0, read = 1'b0, entry = 1'b0, take = 1'b0;
    reg  [BITS-1:0] write_address = 0, read_address = 0, load_address = 0;
    reg  [15:0]     write_word = 0, index = 0;
    wire            hold, busy, granted, ready;
    wire [15:0]     read_word, load_word;
    sdram_memory #(.CHANNELS(CHANNELS), .RECORDS(RECORDS), .FOCI(8), .MIB(MIB)) memory (
        .clk(clk), .rst(rst), .i_more(more), .i_write(more && !hold), .i_ends(1'b0), .i_write_address(write_address), .i_write_word(write_word),
        .o_hold(hold), .o_busy(busy), .i_read(read), .i_read_address(read_address), .o_granted(granted), .o_read_word(read_word),
        .i_entry(entry), .i_index(index), .o_entry(ready), .i_take(take), .i_foci_base(16'd100), .i_foci_count(16'd50), .i_foci_last(3'd7),
        .i_forget(1'b0), .i_load_address(load_address), .o_word(load_word),
        .o_sdram_command(command), .o_sdram_bank(bank), .o_sdram_address(address), .o_sdram_data(data), .o_sdram_drive(drive), .i_sdram_data(arrived_q));

    reg [15:0] shadow [0:(1 << BITS) - 1];
    integer    seed = SEED, now = 0;
    always @(posedge clk) now = now + 1;

    function integer any(input integer beyond);  // from 0 on
        any = ($random(seed) & 32'h7fffffff) % beyond;
    endfunction

    // A frame: so many words, the first of which is `word` and the others `step` more each, until all are in the chip.
    integer w;
    task write(input [BITS-1:0] first, input integer count, input [15:0] word, input integer step);
        begin
            write_address = first;
            more = 1'b1;
            for (w = 0; w < count; w = w + 1) begin
                write_word = word + w * step;
                #1 while (hold) begin
                    @(negedge clk);
                    #1;
                end
                shadow[write_address] = write_word;
                @(negedge clk) write_address = write_address + 1'b1;
            end
            more = 1'b0;
            #1 while (busy) begin
                @(negedge clk);
                #1;
            end
        end
    endtask

    integer wrong = 0;
    task check(input [BITS-1:0] from, input [15:0] found);
        if (found !== shadow[from]) begin
            wrong = wrong + 1;
            if (wrong <= 5) $display("word %0d at %0t: found %h, expected %h", from, $realtime, found, shadow[from]);
        end
    endtask
    task ask(input [BITS-1:0] from);
        begin
            {read_address, read} = {from, 1'b1};
            #1 while (!granted) begin
                @(negedge clk);
                #1;
            end
            @(negedge clk) read = 1'b0;
            @(negedge clk);
            #1 check(from, read_word);
        end
    endtask

    // Offers an entry, takes it, and reads the record's words.
    integer k, clocks, asked, differs;
    reg [15:0] first_word;
    task load(input [15:0] which, input [BITS-1:0] first, input integer count, input same);
        begin
            {index, entry} = {which, 1'b1};
            asked = now;
            #1 while (!ready) begin
                @(negedge clk);
                #1;
            end
            clocks = now - asked;
            take = 1'b1;
            @(negedge clk) {take, entry} = 2'b00;
            differs = 0;
            for (k = 0; k < count + 2; k = k + 1) begin
                if (k == 2) first_word = load_word;
                if (k >= 2 && same && load_word !== first_word) differs = 1;
                if (k >= 2 && !same) check(first + k - 2, load_word);
                load_address = first + k;
                @(negedge clk);
                #1;
            end
        end
    endtask

    // ---- What happens

    reg [15:0] indices [0:FEW-1], begun [0:FEW-1], done [0:FEW-1];
    reg [15:0] least;
    integer    n, slot, picked, near, torn = 0, old = 0, worst = 0, writes = 0;
    real       sum = 0;
    reg        over = 1'b0;
    task number_record(input integer which);
        begin
            begun[which] = begun[which] + 16'd1;
            write((indices[which] - 1) * RECORD_WORDS, RECORD_WORDS, begun[which], 0);
            done[which] = begun[which];
            writes = writes + 1;
        end
    endtask
    initial begin
        #100 rst = 1'b0;
        @(negedge clk);
        // Runs of every length around the ends of rows and of banks, and what they hold.
        for (n = 0; n < 60; n = n + 1) begin
            near = 512 * (1 + any(8)) - any(40);
            write(near, 1 + any(n % 4 == 0 ? 242 : 8), any(65536), 7919);
            ask(near);
            ask(near + w - 1);
            if (n % 6 == 0) for (k = 0; k < 20; k = k + 1) ask(near + any(w));
        end
        write(400, 16 * 32, 16'h8001, 257);
        load(RECORDS + 1, 400, 32, 1'b0);        // the first focus record, and the tenth
        load(RECORDS + 10, 400 + 9 * 32, 32, 1'b0);
        write(0, 2 * RECORD_WORDS, 16'h1234, 3);
        load(2, RECORD_WORDS, RECORD_WORDS, 1'b0);
        load(1, 0, RECORD_WORDS, 1'b0);

        for (n = 0; n < FEW; n = n + 1) begin
            indices[n] = n == 0 ? 1 : n == 1 ? RECORDS : n == 2 ? 5 : 1 + any(RECORDS);
            {begun[n], done[n]} = 32'd0;
            number_record(n);
        end
        fork
            while (!over) begin
                slot = any(FEW);
                number_record(slot);
                @(negedge clk);
            end
            begin
                for (n = 0; n < READS; n = n + 1) begin
                    picked = any(FEW);
                    least = done[picked];
                    load(indices[picked], (indices[picked] - 1) * RECORD_WORDS, RECORD_WORDS, 1'b1);
                    if (differs != 0 || ^first_word === 1'bx) torn = torn + 1;
                    else if (first_word - least > 16'h7fff) old = old + 1;
                    sum = sum + clocks;
                    if (clocks > worst) worst = clocks;
                    repeat (any(250)) @(negedge clk);
                end
                over = 1'b1;
            end
        join
        $display("%0d reads, %0d writes, %0d wrong, %0d torn, %0d old, worst %0d clocks, mean %0.1f, %0d refreshes, %0d violations",
                 READS, writes, wrong, torn, old, worst, sum / READS, chip.refreshes, chip.violations);
        $finish(0);
    end
endmodule
`default_nettype wire
