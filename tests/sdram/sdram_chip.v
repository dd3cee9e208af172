// SPDX-License-Identifier: Apache-2.0
//
// An SDRAM of 32 bits at its pins, with CKE and CS on and DQM off, as the Colorlight boards have it. It holds what was written, and notes
// everything that a chip would not bear: commands that come too soon after another one, a refresh that is overdue, pins that
// move while they are sampled, both ends driving.
//
// The times are in ns, those of the slowest grade (-7) of ESMT's M12L64322A and M12L16161A; those of two clocks are given for 50 MHz.
// A word that is read can be sampled from T_ACCESS behind the clock edge after the command's until T_HOLD_OUT behind the edge after that.
`timescale 1ns / 1ps
`default_nettype none
module sdram_chip #(
    parameter BANK_BITS = 2,
    parameter real T_START = 200000, T_RCD = 21, T_RP = 21, T_RAS = 49, T_RC = 70, T_RRD = 14, T_RFC = 70, T_WR = 39, T_MRD = 39,
    parameter real T_REFRESH = 15625,  // 64 ms for 4,096 rows
    parameter real T_SETUP = 2.5, T_HOLD = 1, T_ACCESS = 8, T_HOLD_OUT = 2.5
) (
    input  wire                 clk,
    input  wire                 i_ras_n,
    input  wire                 i_cas_n,
    input  wire                 i_we_n,
    input  wire [BANK_BITS-1:0] i_bank,
    input  wire [10:0]          i_address,
    inout  wire [31:0]          io_data
);
    localparam BANKS = 1 << BANK_BITS;
    localparam [2:0] MODE = 3'b000, REFRESH = 3'b001, PRECHARGE = 3'b010, ACTIVATE = 3'b011, WRITE = 3'b100, READ = 3'b101, NOP = 3'b111;

    reg [31:0]      cells [0:(1 << (BANK_BITS + 19)) - 1];
    reg [BANKS-1:0] open;
    reg [10:0]      row [0:BANKS-1];
    reg             mode_set, precharged, drives;
    reg [1:0]       comes;  // a word that was asked for, in the next clock and in the one after
    reg [31:0]      word, next_word, out;
    real            activated [0:BANKS-1], closed [0:BANKS-1], written [0:BANKS-1];
    real            refreshed, was_set, moved, edge_at;
    integer         violations, refreshes, b;
    wire [2:0]      command = {i_ras_n, i_cas_n, i_we_n};
    assign io_data = drives ? out : 32'bz;

    task note(input [8*40-1:0] what);
        begin
            violations = violations + 1;
            if (violations <= 20) $display("violation: %0s at %0t", what, $realtime);
        end
    endtask
    // So much time must have passed since then.
    task least(input real since, input real time_ns, input [8*40-1:0] what);
        if ($realtime - since < time_ns) note(what);
    endtask

    initial begin
        {open, mode_set, precharged, drives, comes} = 0;
        {violations, refreshes} = 64'd0;
        refreshed = -1000000.0; was_set = -1000000.0; moved = -1000000.0; edge_at = -1000000.0;
        for (b = 0; b < BANKS; b = b + 1) begin
            activated[b] = -1000000.0; closed[b] = -1000000.0; written[b] = -1000000.0;
        end
    end

    always @(command or i_bank or i_address or io_data) begin
        if (!drives && $realtime - edge_at < T_HOLD && $realtime > T_START) note("hold");
        moved = $realtime;
    end

    task close(input integer bank);
        if (open[bank]) begin
            least(activated[bank], T_RAS, "tRAS");
            least(written[bank], T_WR, "tWR");
            open[bank] = 1'b0;
            closed[bank] = $realtime;
        end
    endtask

    always @(posedge clk) begin
        edge_at = $realtime;
        if (command !== NOP) begin
            if ($realtime < T_START) note("start");
            if ($realtime - moved < T_SETUP && !drives) note("set-up");
            least(refreshed, T_RFC, "tRFC");
            least(was_set, T_MRD, "tMRD");
        end
        comes = {comes[0], 1'b0};
        word  = next_word;
        case (command)
            ACTIVATE: begin
                if (!mode_set) note("a row before the mode");
                if (open[i_bank]) note("a row in an open bank");
                if ($realtime - refreshed > T_REFRESH) note("refresh is overdue");
                least(closed[i_bank], T_RP, "tRP");
                least(activated[i_bank], T_RC, "tRC");
                for (b = 0; b < BANKS; b = b + 1) least(activated[b], T_RRD, "tRRD");
                {open[i_bank], row[i_bank]} = {1'b1, i_address};
                activated[i_bank] = $realtime;
            end
            READ, WRITE: begin
                if (!open[i_bank]) note("a word without a row");
                if (i_address[10:8] !== 3'd0) note("no such column, or an automatic precharge");
                least(activated[i_bank], T_RCD, "tRCD");
                if (command === READ) {comes[0], next_word} = {1'b1, cells[{row[i_bank], i_bank, i_address[7:0]}]};
                else begin
                    if (drives || comes != 2'b00) note("both ends drive");
                    if (io_data === 32'bz) note("a word that nobody drives");
                    cells[{row[i_bank], i_bank, i_address[7:0]}] = io_data;
                    written[i_bank] = $realtime;
                end
            end
            PRECHARGE: begin
                for (b = 0; b < BANKS; b = b + 1) if (i_address[10] || b == {{(32-BANK_BITS){1'b0}}, i_bank}) close(b);
                precharged = 1'b1;
            end
            REFRESH: begin
                if (open != {BANKS{1'b0}} || !precharged) note("a refresh beside an open row");
                for (b = 0; b < BANKS; b = b + 1) least(closed[b], T_RP, "tRP");
                refreshes = refreshes + 1;
                refreshed = $realtime;
            end
            MODE: begin
                if (open != {BANKS{1'b0}} || refreshes < 8) note("the mode is set too early");
                if (i_address !== 11'h020 || i_bank !== {BANK_BITS{1'b0}}) note("another mode");
                mode_set = 1'b1;
                was_set  = $realtime;
            end
            NOP: ;
            default: note("no such command");
        endcase
    end

    // Between two words nobody knows what is there.
    always @(posedge clk) begin
        #(T_HOLD_OUT) out = 32'hxxxxxxxx;
        drives = 1'b0;
        #(T_ACCESS - T_HOLD_OUT) if (comes[1]) {drives, out} = {1'b1, word};
    end
endmodule
`default_nettype wire
