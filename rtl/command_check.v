// SPDX-License-Identifier: Apache-2.0
//
// Judges the arguments of a command before anything is changed by it.
//
// A command that is refused must leave no trace, so all its arguments are checked first. o_status is a status code of
// interface.vh; it is valid one clock after i_settle and stays so while the arguments do.
// The parameters are the core's; they bound addresses, sequence entries and samples. i_top_index bounds indices. WORD_BITS is as wide
// as the address of a 16-bit word in the largest region.
`default_nettype none
`include "interface.vh"
module command_check #(
    parameter CHANNELS       = 100,
    parameter RECORDS        = 400,
    parameter SEQUENCE_DEPTH = 1024,
    parameter WIDTH_BITS     = 0,
    parameter MODULATION_DEPTH = 0,
    parameter FOCI           = 0,
    parameter SCHEDULE       = 0,
    parameter SYNC           = 0,
    parameter STREAM         = 0,
    parameter TRIGGER        = 0,
    parameter WORD_BITS      = 16
) (
    input  wire        clk,
    input  wire        i_settle,  // strobe: all arguments are in place
    input  wire [7:0]  i_command,
    input  wire [15:0] i_argument_0,
    input  wire [15:0] i_argument_1,
    input  wire [15:0] i_argument_2,
    input  wire [15:0] i_tail_words,
    input  wire [15:0] i_live_free,
    input  wire        i_stopped,       // the stop input is active
    input  wire        i_out_of_step,   // a slave that is not in step
    input  wire [15:0] i_top_index,     // the highest index that is a record's
    input  wire        i_header_valid,  // the sequence header's length is in range
    input  wire        i_gate_busy,     // from schedule
    input  wire        i_no_push,
    input  wire        i_ring_usable,   // from focus_ring
    input  wire        i_ring_fits,
    input  wire        i_stream_usable, // from pattern_stream
    output reg  [7:0]  o_status
);
    localparam RECORD_WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    localparam PRIMARY_WORDS = RECORDS * RECORD_WORDS;
    localparam SEQUENCE_HALVES = SEQUENCE_DEPTH * 2;
    localparam [WORD_BITS:0] NO_WORDS = 0;
    localparam GEOMETRY_WORDS = FOCI != 0 ? 4 * CHANNELS : 0;
    localparam SAMPLE_WORDS = MODULATION_DEPTH / 2;
    localparam [16:0] SAMPLES = MODULATION_DEPTH[16:0];
    localparam STATUS_WORDS = STREAM != 0 ? `HG_STATUS_WORDS : SCHEDULE != 0 ? `HG_STATUS_UNSTREAMED_WORDS : `HG_STATUS_UNTIMED_WORDS;
    localparam STREAM_WORDS = STREAM != 0 ? `HG_STREAM_WORDS : 0;
    localparam TRIGGER_WORDS = TRIGGER != 0 ? `HG_TRIGGER_WORDS : 0, TRIGGER_SETTINGS = TRIGGER != 0 ? `HG_TRIGGER_SETTINGS : 0;
    localparam RING_WORDS = FOCI != 0 ? `HG_RING_WORDS : 0;
    localparam [47:0] AT_TRIGGER = {48{1'b1}} - 48'd1;
    localparam ENTRY_BITS = $clog2(SEQUENCE_DEPTH + 1);
    localparam [ENTRY_BITS:0] ENTRIES = SEQUENCE_DEPTH[ENTRY_BITS:0];
    localparam [15:0] MOST_WORDS = RECORD_WORDS[15:0];

    wire        writes = i_command == `HG_COMMAND_WRITE;
    wire [3:0]  region = i_argument_1[15:12];
    wire [27:0] first  = {i_argument_1[11:0], i_argument_0};  // byte address within the region
    wire [15:0] words  = writes ? i_tail_words : {1'b0, i_argument_2[15:1]};
    wire [27:0] words_28 = {12'd0, words};
    wire        odd    = first[0] || (!writes && i_argument_2[0]);
    reg  [WORD_BITS:0] region_words, region_words_q;
    reg  [WORD_BITS:0] beyond_q;  // address of the word after the last one
    reg                far_q;     // the addresses are too large to be compared
    reg  [ENTRY_BITS:0] beyond_entry_q;  // number of the entry after the last one
    reg                far_entry_q;
    reg         misaligned_q, zero_words_q, too_many_q;
    reg  [15:0] live_free_q;  // as it was a clock ago; the number of free places has not become smaller since
    always @(posedge clk) live_free_q <= i_live_free;

    // Samples of MODULATE: from the first one on, i_argument_1 of them, or all that follow when that is 0.
    wire [16:0] samples = i_argument_1 == 16'd0 ? 17'd1 : {1'b0, i_argument_1};
    wire        samples_beyond = SCHEDULE == 0 ? {1'b0, i_argument_1} > SAMPLES || i_argument_2 > 16'd1
                                               : {2'd0, i_argument_2[15:1], 1'b0} + {1'b0, samples} > {1'b0, SAMPLES};

    always @(posedge clk) if (i_settle) begin
        region_words_q <= region_words;
        beyond_q     <= {1'b0, first[WORD_BITS:1]} + words_28[WORD_BITS:0];
        far_q        <= first[27:WORD_BITS+1] != {(27-WORD_BITS){1'b0}} || words_28[27:WORD_BITS] != {(28-WORD_BITS){1'b0}};
        beyond_entry_q <= {1'b0, i_argument_0[ENTRY_BITS-1:0]} + {1'b0, i_argument_1[ENTRY_BITS-1:0]};
        far_entry_q  <= (i_argument_0 | i_argument_1) >> ENTRY_BITS != 16'd0;
        misaligned_q <= odd || (region == `HG_REGION_SEQUENCE && (first[1] || words[0]));
        zero_words_q <= words == 16'd0;
        too_many_q   <= !writes && words > MOST_WORDS;
    end

    always @* begin
        case (region)
            `HG_REGION_PRIMARY:  region_words = PRIMARY_WORDS[WORD_BITS:0];
            `HG_REGION_SEQUENCE: region_words = SEQUENCE_HALVES[WORD_BITS:0];
            `HG_REGION_IDENTITY: region_words = writes ? NO_WORDS : `HG_IDENTITY_WORDS;
            `HG_REGION_STATUS:   region_words = writes ? NO_WORDS : STATUS_WORDS[WORD_BITS:0];
            `HG_REGION_PARAMETERS: region_words = WIDTH_BITS != 0 ? `HG_PARAMETERS_WORDS : NO_WORDS;
            `HG_REGION_GEOMETRY:   region_words = writes ? GEOMETRY_WORDS[WORD_BITS:0] : NO_WORDS;
            `HG_REGION_MODULATION: region_words = SAMPLE_WORDS[WORD_BITS:0];
            `HG_REGION_RING:       region_words = RING_WORDS[WORD_BITS:0];
            `HG_REGION_TRIGGER:  region_words = writes ? TRIGGER_SETTINGS[WORD_BITS:0] : TRIGGER_WORDS[WORD_BITS:0];
            `HG_REGION_STREAM:   region_words = STREAM_WORDS[WORD_BITS:0];
            default:             region_words = NO_WORDS;
        endcase
        o_status = `HG_REPLY_OK;
        case (i_command)
            `HG_COMMAND_WRITE, `HG_COMMAND_READ, `HG_COMMAND_DIGEST:
                if (zero_words_q || too_many_q) o_status = `HG_REPLY_BAD_LENGTH;
                else if (far_q || beyond_q > region_words_q) o_status = `HG_REPLY_BAD_ADDRESS;
                else if (misaligned_q) o_status = `HG_REPLY_BAD_ALIGNMENT;
            `HG_COMMAND_SELECT:
                if (i_argument_0 > i_top_index) o_status = `HG_REPLY_BAD_INDEX;
            `HG_COMMAND_PUSH:
                if (SCHEDULE != 0 && i_no_push) o_status = `HG_REPLY_BAD_RANGE;
                else if (i_tail_words > live_free_q) o_status = `HG_REPLY_FIFO_FULL;
            `HG_COMMAND_START:
                if (i_argument_1 == 16'd0 ? !i_header_valid : i_argument_0 == 16'd0 || far_entry_q || beyond_entry_q > ENTRIES)
                    o_status = `HG_REPLY_BAD_RANGE;
            `HG_COMMAND_ENABLE:
                if (i_stopped) o_status = `HG_REPLY_STOPPED;
                else if (i_out_of_step) o_status = `HG_REPLY_OUT_OF_STEP;
            `HG_COMMAND_SYNC:
                if (SYNC == 0) o_status = `HG_REPLY_UNKNOWN_COMMAND;
                else if (i_argument_0 > {14'd0, `HG_ROLE_SLAVE}) o_status = `HG_REPLY_BAD_RANGE;
            `HG_COMMAND_MODULATE:
                if (MODULATION_DEPTH == 0) o_status = `HG_REPLY_UNKNOWN_COMMAND;
                else if (i_argument_0 != 16'd0 && samples_beyond) o_status = `HG_REPLY_BAD_RANGE;
            `HG_COMMAND_GATE:
                if (SCHEDULE == 0) o_status = `HG_REPLY_UNKNOWN_COMMAND;
                else if (i_gate_busy) o_status = `HG_REPLY_GATE_BUSY;
                else if (TRIGGER != 0 && i_stopped && {i_argument_2, i_argument_1, i_argument_0} == AT_TRIGGER) o_status = `HG_REPLY_STOPPED;
            `HG_COMMAND_PUSH_FOCI:
                if (FOCI == 0) o_status = `HG_REPLY_UNKNOWN_COMMAND;
                else if (!i_ring_usable || (SCHEDULE != 0 && i_no_push)) o_status = `HG_REPLY_BAD_RANGE;
                else if (!i_ring_fits) o_status = `HG_REPLY_FIFO_FULL;
            `HG_COMMAND_STREAM:
                if (STREAM == 0) o_status = `HG_REPLY_UNKNOWN_COMMAND;
                else if (!i_stream_usable) o_status = `HG_REPLY_BAD_RANGE;
            default: ;
        endcase
    end
endmodule
`default_nettype wire
