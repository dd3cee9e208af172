// SPDX-License-Identifier: Apache-2.0
//
// Holds all records in an SDRAM, in place of primary_memory. Frames that write, the next record and replies share the chip.
//
// record_store writes a frame's words as one run, and record_fetch reads a record as one run, so that a record is never torn. Waiting runs begin in
// this order: a write, so that no read is older; the next record; a word of a reply. A record that has waited for one write goes before the next
// write. So a record waits for a refresh, a run and its own run at most.
// i_read_address is the address of a reply's word. It is asked for until o_granted, with which o_read_word comes and stays until the next one. All
// other ports are those of record_store, record_fetch and sdram_controller. MIB is the chip's size, 4 or 8. RUN_BITS is as wide as the number of
// words of the longest frame. CHANNELS must be even, so that a record begins with a word of the chip. The chip's times hold up to 60 MHz.
`default_nettype none
`include "interface.vh"
module sdram_memory #(
    parameter CHANNELS     = 100,
    parameter RECORDS      = 16384,
    parameter FOCI         = 8,
    parameter MIB          = 4,
    parameter RUN_BITS     = 9,
    parameter CLOCK_HZ     = 50000000,
    parameter ADDRESS_BITS = $clog2(RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS))  // follows from the others
) (
    input  wire                    clk,
    input  wire                    rst,
    // What a frame writes
    input  wire                    i_more,
    input  wire                    i_write,
    input  wire                    i_ends,
    input  wire [ADDRESS_BITS-1:0] i_write_address,
    input  wire [15:0]             i_write_word,
    output wire                    o_hold,
    output wire                    o_busy,
    // A reply
    input  wire                    i_read,
    input  wire [ADDRESS_BITS-1:0] i_read_address,
    output reg                     o_granted,
    output reg  [15:0]             o_read_word,
    // What is loaded
    input  wire                    i_entry,
    input  wire [15:0]             i_index,
    output wire                    o_entry,
    input  wire                    i_take,
    input  wire [15:0]             i_foci_base,
    input  wire [15:0]             i_foci_count,
    input  wire [2:0]              i_foci_last,
    input  wire                    i_forget,
    input  wire [ADDRESS_BITS-1:0] i_load_address,
    output wire [15:0]             o_word,
    // The chip
    output wire [2:0]              o_sdram_command,
    output wire [1:0]              o_sdram_bank,
    output wire [10:0]             o_sdram_address,
    output wire [31:0]             o_sdram_data,
    output wire                    o_sdram_drive,
    input  wire [31:0]             i_sdram_data
);
    localparam BANK_BITS = MIB == 8 ? 2 : 1, WORD_BITS = BANK_BITS + 19;
    localparam MHZ = (CLOCK_HZ + 999999) / 1000000, START_US = 200;
    localparam [1:0] STORE = 2'd0, FETCH = 2'd1, REPLY = 2'd2;

    generate
        if ((MIB != 4 && MIB != 8) || CHANNELS % 2 != 0 || CLOCK_HZ > 60000000
            || RECORDS * (CHANNELS + `HG_RECORD_HEADER_WORDS) > MIB * 524288) sdram_out_of_range error();
    endgenerate

    wire                 store_asks, store_writes, store_pends, fetch_asks, take, next, valid, done;
    wire [WORD_BITS-1:0] store_first, fetch_first, first;
    wire [RUN_BITS-1:0]  store_last, fetch_last, last;
    wire [31:0]          store_word, word;
    reg  [1:0]           owner_q;     // of the present run
    reg                  waited_q;    // the next record has waited for a run to be written
    reg                  writing_q;
    reg                  replies_q;   // a reply's word was asked for

    wire fetch_turn = fetch_asks && (!store_pends || waited_q);
    wire reply_asks = i_read && !replies_q && !o_granted;
    wire [1:0] owner = fetch_turn ? FETCH : store_asks ? STORE : REPLY;
    wire asks  = fetch_turn || store_asks || (reply_asks && !store_pends);
    wire [31:0] reply_place = {{(32-ADDRESS_BITS){1'b0}}, i_read_address};
    assign first = owner == FETCH ? fetch_first : owner == STORE ? store_first : reply_place[WORD_BITS:1];
    assign last  = owner == FETCH ? fetch_last : owner == STORE ? store_last : {RUN_BITS{1'b0}};
    wire writes  = owner == STORE && store_writes;

    record_store #(.RUN_BITS(RUN_BITS), .WORD_BITS(WORD_BITS), .ADDRESS_BITS(ADDRESS_BITS)) store (
        .clk(clk), .rst(rst), .i_more(i_more), .i_write(i_write), .i_ends(i_ends), .i_address(i_write_address), .i_half(i_write_word),
        .o_hold(o_hold), .o_busy(o_busy), .o_pending(store_pends),
        .o_ask(store_asks), .o_write(store_writes), .o_first(store_first), .o_last(store_last),
        .i_take(take && owner == STORE), .i_next(next), .o_word(store_word),
        .i_valid(valid && owner_q == STORE), .i_word(word), .i_done(done && owner_q == STORE));

    record_fetch #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .FOCI(FOCI), .RUN_BITS(RUN_BITS), .WORD_BITS(WORD_BITS), .ADDRESS_BITS(ADDRESS_BITS)
    ) fetch (
        .clk(clk), .rst(rst), .i_entry(i_entry), .i_index(i_index), .o_entry(o_entry), .i_take(i_take),
        .i_foci_base(i_foci_base), .i_foci_count(i_foci_count), .i_foci_last(i_foci_last), .i_forget(i_forget),
        .i_written(take && writes),
        .o_ask(fetch_asks), .o_first(fetch_first), .o_last(fetch_last), .i_take_run(take && owner == FETCH),
        .i_valid(valid && owner_q == FETCH), .i_word(word), .i_done(done && owner_q == FETCH),
        .i_address(i_load_address), .o_word(o_word));

    sdram_controller #(
        .BANK_BITS(BANK_BITS), .COUNT_BITS(RUN_BITS), .START_CLOCKS(START_US * MHZ),
        .REFRESH_CLOCKS(MHZ * 72 / 10)  // twice as often as data sheets ask: a warm chip forgets sooner
    ) chip (
        .clk(clk), .rst(rst), .i_ask(asks), .i_write(writes), .i_first(first), .i_last(last), .o_take(take),
        .o_next(next), .i_word(store_word), .o_valid(valid), .o_word(word), .o_done(done),
        .o_command(o_sdram_command), .o_bank(o_sdram_bank[BANK_BITS-1:0]), .o_address(o_sdram_address), .o_data(o_sdram_data),
        .o_drive(o_sdram_drive), .i_data(i_sdram_data));
    generate
        if (BANK_BITS == 1) begin : two_banks
            assign o_sdram_bank[1] = 1'b0;
        end
    endgenerate

    always @(posedge clk) begin
        if (take) owner_q <= owner;
        if (take) writing_q <= writes;
        else if (done) writing_q <= 1'b0;
        waited_q <= fetch_asks && !(take && owner == FETCH) && (waited_q || writing_q);
        if (take && owner == REPLY) replies_q <= 1'b1;
        o_granted <= 1'b0;
        if (valid && owner_q == REPLY) begin
            o_read_word <= i_read_address[0] ? word[31:16] : word[15:0];
            {o_granted, replies_q} <= 2'b10;
        end
        if (rst) {writing_q, waited_q, replies_q, o_granted} <= 4'd0;
    end

    wire unused = &{1'b0, reply_place};
endmodule
`default_nettype wire
