// SPDX-License-Identifier: Apache-2.0
//
// Fetches the next record out of an SDRAM into a buffer, from which memory_controller reads the record as from block RAM.
//
// The module stands between index_source and memory_controller: o_entry follows i_entry when the record of i_index is in the buffer; i_take is
// memory_controller's. i_index is compared a clock later, because it may come out of a block RAM. So an offered entry must stay until it is
// taken, or memory_controller must not take in the clock in which another entry replaces it. There are two buffers: one is read while the next
// record comes into the other. Index 0 needs none. For a record that memory_controller will refuse, any words are fetched.
// A fetched record is forgotten when something is written before the record is taken (i_written), and at i_forget, when foci may lie elsewhere. So
// a record is never older than if it were read in the clock in which its entry is taken.
// o_word is the 16-bit word at i_address of the record that was taken last, two clocks later.
// o_ask and the other ports of a run are those of sdram_controller. CHANNELS, RECORDS and FOCI are the core's.
`default_nettype none
`include "interface.vh"
module record_fetch #(
    parameter CHANNELS      = 100,
    parameter RECORDS       = 16384,
    parameter FOCI          = 8,
    parameter RUN_BITS      = 9,
    parameter WORD_BITS     = 21,
    parameter ADDRESS_BITS  = 22
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    i_entry,
    input  wire [15:0]             i_index,
    output wire                    o_entry,
    input  wire                    i_take,
    input  wire [15:0]             i_foci_base,  // as of memory_controller
    input  wire [15:0]             i_foci_count,
    input  wire [2:0]              i_foci_last,
    input  wire                    i_forget,
    input  wire                    i_written,    // strobe: a run is about to be written
    output wire                    o_ask,
    output wire [WORD_BITS-1:0]    o_first,
    output wire [RUN_BITS-1:0]     o_last,
    input  wire                    i_take_run,
    input  wire                    i_valid,
    input  wire [31:0]             i_word,
    input  wire                    i_done,
    input  wire [ADDRESS_BITS-1:0] i_address,
    output reg  [15:0]             o_word
);
    localparam RECORD_HALVES = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam RECORD_WORDS = RECORD_HALVES / 2;
    localparam MOST_WORDS = RECORD_WORDS > 2 * FOCI ? RECORD_WORDS : 2 * FOCI;
    localparam BUFFER_BITS = $clog2(MOST_WORDS);
    localparam [25:0] STRIDE = RECORD_WORDS[25:0];
    localparam [15:0] TOP_RECORD = RECORDS[15:0];
    localparam [9:0]  LAST_OF_RECORD = RECORD_WORDS[9:0] - 10'd1;
    localparam [2:0] IDLE = 3'd0, PLACE = 3'd1, ASK = 3'd2, READ = 3'd3, FULL = 3'd4;

    reg [2:0]           state_q;
    reg [1:0]           steps_q;   // until the record is placed
    reg                 stale_q;
    reg                 offered_q, same_q, silent_q;  // of the entry of a clock ago: there was one, of index_q, of index 0
    reg [15:0]          index_q;
    reg [25:0]          record_q;
    reg [WORD_BITS-1:0] first_q;
    reg [9:0]           count_q;   // words, less one
    reg                 bank_q;    // the buffer that is being read; the other one is filled
    reg [BUFFER_BITS-1:0] place_q;
    (* no_rw_check *) reg [31:0] words [0:(2 << BUFFER_BITS)-1];

    wire        is_foci = FOCI != 0 && index_q > TOP_RECORD;
    wire [27:0] foci_first;
    generate
        if (FOCI != 0) begin : with_foci
            wire unused_refusal;
            focus_place #(.RECORDS(RECORDS), .PRIMARY_WORDS(RECORDS * RECORD_HALVES)) place (
                .clk(clk), .i_index(index_q), .i_base(i_foci_base), .i_count(i_foci_count), .i_last(i_foci_last),
                .o_first(foci_first), .o_refused(unused_refusal));
        end else begin : without_foci
            assign foci_first = 28'd0;
            wire unused_foci = &{1'b0, i_foci_base, i_foci_count, i_foci_last};
        end
    endgenerate
    wire [27:0] first = is_foci ? foci_first >> 1 : {2'd0, record_q};
    wire        wanted = i_entry && same_q;
    assign o_entry = i_entry && (silent_q || (state_q == FULL && same_q && !stale_q && !i_forget));
    assign o_ask   = state_q == ASK;
    assign o_first = first_q;
    wire [31:0] count = {22'd0, count_q};
    assign o_last  = count[RUN_BITS-1:0];

    always @(posedge clk) begin
        record_q <= ({10'd0, index_q} - 26'd1) * STRIDE;
        offered_q <= i_entry && !i_take;
        same_q    <= i_entry && !i_take && i_index == index_q;
        silent_q  <= i_entry && !i_take && i_index == 16'd0;
        if (i_forget) stale_q <= 1'b1;
        case (state_q)
            IDLE: if (i_entry && i_index != 16'd0) begin
                index_q <= i_index;
                steps_q <= 2'd2;
                stale_q <= i_forget;
                state_q <= PLACE;
            end
            PLACE: begin
                steps_q <= steps_q - 2'd1;
                first_q <= first[WORD_BITS-1:0];
                count_q <= is_foci ? {6'd0, i_foci_last, 1'b1} : LAST_OF_RECORD;
                if (steps_q == 2'd0) state_q <= ASK;
            end
            ASK: if (i_take_run) state_q <= READ;
                 else if (!wanted || stale_q) state_q <= IDLE;
            READ: if (i_done) state_q <= FULL;
            default:
                if (i_take && !silent_q) {state_q, bank_q} <= {IDLE, !bank_q};
                else if (stale_q || i_written || (offered_q && !same_q)) state_q <= IDLE;
        endcase
        if (rst) {state_q, bank_q, offered_q, same_q, silent_q} <= {IDLE, 4'd0};
    end

    // A run's words lie in the buffer by the lower bits of their addresses, which differ.
    wire [31:0] address = {{(32-ADDRESS_BITS){1'b0}}, i_address};
    reg  [31:0] word_q;
    reg         high_q;
    always @(posedge clk) begin
        if (state_q != READ) place_q <= first_q[BUFFER_BITS-1:0];
        else if (i_valid) place_q <= place_q + 1'b1;
        if (i_valid && state_q == READ) words[{!bank_q, place_q}] <= i_word;
        {word_q, high_q} <= {words[{bank_q, address[BUFFER_BITS:1]}], address[0]};
        o_word <= high_q ? word_q[31:16] : word_q[15:0];
    end

    wire unused = &{1'b0, first, count, address};
endmodule
`default_nettype wire
