// SPDX-License-Identifier: Apache-2.0
//
// Carries out one frame at a time: reads its words, checks its order and its arguments, applies it, and has it answered.
//
// Frames may be lost, damaged or repeated on the line. So each carries a sequence number, and is applied once and in order: a frame with the
// expected number is applied; an earlier one was applied before and is only answered (a read reads again); a later one is refused, and the
// expected number stays. After reset, and when a session has ended, only IDENTIFY is taken, which says where the numbers begin. An IDENTIFY with
// the number that began the session is a late copy: it is only answered.
// Nothing changes before the whole frame has been found good. PUSH is the exception: its indices wait in the live FIFO until o_keep or
// o_take_back. So do the indices of PUSH_FOCI, whose words are written to the addresses that focus_ring names. Writes go out one word a clock and
// pause only for i_hold; memory_controller.v relies on that.
// Frames arrive on a valid/take stream from frame_receiver: the length in bytes, then the words. An answer starts with the o_answer strobe, and
// the fields beside it stay until i_answered. STREAM is a message, without an answer: in place of a sequence number it has the session's number,
// and its words are written to the addresses that pattern_stream names.
// i_top_index is the highest index that PUSH may name. WORD_BITS is as wide as the address of a 16-bit word in the largest region. STATUS_WORDS is
// the length of the status block. FOCI, STREAM and NET are the core's. LENGTH_BITS is as wide as the length of a frame in bytes.
`default_nettype none
`include "interface.vh"
module command_unit #(
    parameter WORD_BITS   = 16,
    parameter STATUS_WORDS = `HG_STATUS_UNTIMED_WORDS,
    parameter FOCI        = 0,
    parameter STREAM      = 0,
    parameter NET         = 0,
    parameter LENGTH_BITS = 10
) (
    input  wire        clk,
    input  wire        rst,
    // Words of good frames, from frame_receiver
    input  wire        i_valid,
    output wire        o_take,
    input  wire [15:0] i_word,
    // The present command, for command_check and for all that o_execute is for
    output wire [7:0]  o_command,
    output wire [15:0] o_argument_0,
    output wire [15:0] o_argument_1,
    output wire [15:0] o_argument_2,
    output wire [15:0] o_tail_words,        // words that follow the arguments
    output wire        o_settle,            // strobe: all arguments are in place
    input  wire [7:0]  i_status,            // command_check's verdict
    input  wire [15:0] i_top_index,
    // Strobes, one of them for each frame
    output reg         o_execute,           // o_command is applied
    output reg         o_repeated,          // it was applied before
    output reg         o_refused,
    // WRITE: each word for o_address in o_region
    output wire        o_puts,              // a frame is here that writes; early in the clock
    output wire        o_more,              // such a frame has a word to be written as soon as i_hold is low
    output wire        o_write,
    input  wire        i_hold,              // this word is being read, write it later
    output reg  [WORD_BITS-1:0] o_address,
    output reg  [3:0]  o_region,
    // From focus_ring
    input  wire [WORD_BITS-1:0] i_ring_address,
    input  wire [WORD_BITS-1:0] i_ring_start,
    input  wire        i_ring_wraps,
    input  wire        i_ring_complete,
    input  wire        i_ring_split,
    // From and to pattern_stream
    output wire        o_streams,           // strobe: a word of STREAM is taken
    output wire        o_close,             // strobe: the frame has ended
    input  wire        i_stream_wait,
    input  wire        i_stream_place,      // strobe: the next word goes to
    input  wire [WORD_BITS-1:0] i_stream_address,
    input  wire        i_stream_keeps,
    input  wire        i_stream_split,
    // PUSH and PUSH_FOCI: indices for the live FIFO, which are kept or taken back at the frame's end
    output wire        o_push,
    output wire        o_keep,
    output wire        o_take_back,
    // The answer
    output reg         o_answer,            // strobe
    output reg  [7:0]  o_status,
    output reg  [7:0]  o_sequence,
    output reg  [7:0]  o_expected,          // the next sequence number that would be applied
    output wire [15:0] o_read_words,        // words to answer with, from o_address
    input  wire        i_answered,
    input  wire        i_ended              // the session has ended, and the present frame was sent before that
);
    localparam [3:0] LENGTH = 4'd0, HEADER = 4'd1, ARGUMENTS = 4'd2, SETTLE = 4'd3, JUDGE = 4'd4, TAIL = 4'd5,
                     DRAIN = 4'd6, CLOSE = 4'd7, ANSWER = 4'd8;

    // ---- The frame

    reg [3:0]  state_q;
    reg [LENGTH_BITS-1:0] length_q;         // of the frame, in bytes
    reg [LENGTH_BITS-1:0] words_q;          // words of it that are still to be taken
    reg [LENGTH_BITS-1:0] payload_words_q;  // words after the header
    reg [LENGTH_BITS-1:0] tail_words_q;     // words after the arguments; valid from o_settle on
    reg [7:0]  command_q;
    reg [15:0] argument_q [0:2];
    reg [1:0]  count_q;                     // arguments taken
    reg        bad_index_q;                 // a PUSH has named an index above RECORDS
    reg        session_q;
    reg        ended_q;                     // no session has begun since the last one ended
    reg [7:0]  session_number_q;            // that of the IDENTIFY which began it

    // What command_table says of this command.
    wire [5:0] shape_d;
    reg        known_q, tail_q;
    reg  [1:0] args_q, reply_q;
    command_table shapes (.i_command(i_word[15:8]), .o_shape(shape_d));

    wire [LENGTH_BITS-1:0] payload_d = {1'b0, length_q[LENGTH_BITS-1:1]} - 1'b1;
    wire [LENGTH_BITS-1:0] arg_words = {{(LENGTH_BITS-2){1'b0}}, args_q};
    wire bad_length = length_q[0] || (tail_q ? payload_words_q <= arg_words : payload_words_q != arg_words);
    wire done = words_q == {LENGTH_BITS{1'b0}};

    // ---- The frame's place in the order of frames

    wire [7:0] ahead = o_sequence - o_expected;
    wire begins   = command_q == `HG_COMMAND_IDENTIFY;
    wire its_own  = o_sequence == session_number_q;
    wire in_order = begins ? !session_q || !its_own : ahead == 8'd0 && session_q;
    wire repeated = session_q && (begins ? its_own : ahead[7]);

    // ---- Outputs

    wire [26:0] argument_address = {argument_q[1][11:0], argument_q[0][15:1]};  // of a word; command_check checks the other bits
    wire unused = &{1'b0, argument_address};
    wire foci  = FOCI != 0 && command_q == `HG_COMMAND_PUSH_FOCI;
    wire message = STREAM != 0 && command_q == `HG_COMMAND_STREAM;
    wire puts  = command_q == `HG_COMMAND_WRITE || foci || message;
    wire pushes = command_q == `HG_COMMAND_PUSH || foci;
    wire hold = message ? i_stream_wait || (i_hold && i_stream_keeps) : i_hold && puts;
    wire reads = reply_q != 2'd0 && o_status <= `HG_REPLY_REPEATED;
    wire takes_argument = state_q == ARGUMENTS && !bad_length && count_q != args_q;
    wire takes_rest     = (state_q == TAIL && !hold) || state_q == DRAIN;

    assign {o_command, o_argument_2, o_argument_1, o_argument_0} = {command_q, argument_q[2], argument_q[1], argument_q[0]};
    assign o_settle      = state_q == SETTLE;
    assign o_tail_words  = {{(16-LENGTH_BITS){1'b0}}, tail_words_q};
    assign o_take        = i_valid && (state_q == LENGTH || state_q == HEADER || (!done && (takes_rest || takes_argument)));
    assign o_write       = state_q == TAIL && !done && !hold && puts && (!message || i_stream_keeps);
    assign o_puts        = state_q == TAIL && !done && puts;
    assign o_more        = state_q == TAIL && !done && puts && (!message || (i_stream_keeps && !i_stream_wait));
    assign o_streams     = state_q == TAIL && !done && !hold && message;
    assign o_close       = state_q == CLOSE;
    assign o_push        = state_q == TAIL && !done && (command_q == `HG_COMMAND_PUSH || (foci && !hold && i_ring_complete));
    assign o_keep        = state_q == CLOSE && pushes && o_status == `HG_REPLY_OK;
    assign o_take_back   = state_q == CLOSE && pushes && o_status != `HG_REPLY_OK;
    assign o_read_words  = !reads ? 16'd0
                         : reply_q == 2'd1 ? `HG_IDENTITY_WORDS
                         : reply_q == 2'd2 ? STATUS_WORDS[15:0]
                         : {1'b0, argument_q[2][15:1]};

    // ---- The steps of a frame

    initial {o_execute, session_q} = 2'b00;
    always @(posedge clk) begin
        {o_execute, o_repeated, o_refused, o_answer} <= 4'd0;
        tail_words_q <= payload_words_q - arg_words;
        if (o_take && state_q != LENGTH && state_q != HEADER) words_q <= words_q - 1'b1;
        if (o_write) o_address <= foci && i_ring_wraps ? i_ring_start : o_address + 1'b1;
        if (message && i_stream_place) o_address <= i_stream_address;

        case (state_q)
            LENGTH: if (i_valid) begin
                length_q <= i_word[LENGTH_BITS-1:0];
                state_q  <= HEADER;
            end

            HEADER: begin
                {command_q, o_sequence} <= i_word;
                {known_q, args_q, tail_q, reply_q} <= shape_d;
                payload_words_q <= payload_d;
                words_q <= payload_d + {{(LENGTH_BITS-1){1'b0}}, length_q[0]};
                count_q <= 2'd0;
                state_q <= ARGUMENTS;
            end

            ARGUMENTS:
                if (!known_q) finish(`HG_REPLY_UNKNOWN_COMMAND);
                else if (bad_length) finish(`HG_REPLY_BAD_LENGTH);
                else if (count_q != args_q) begin
                    argument_q[count_q] <= i_word;
                    count_q             <= count_q + 1'b1;
                end else state_q <= SETTLE;

            SETTLE: begin  // the blocks that IDENTIFY and STATUS answer with have no address among their arguments
                o_region  <= reply_q == 2'd1 ? `HG_REGION_IDENTITY : reply_q == 2'd2 ? `HG_REGION_STATUS
                           : foci || message ? `HG_REGION_PRIMARY : argument_q[1][15:12];
                o_address <= reply_q == 2'd1 || reply_q == 2'd2 ? {WORD_BITS{1'b0}}
                           : foci ? i_ring_address : argument_address[WORD_BITS-1:0];
                bad_index_q <= 1'b0;
                state_q     <= JUDGE;
            end

            JUDGE:
                if (NET != 0 && (i_ended || ended_q) && (i_ended || !begins || its_own)) finish(`HG_REPLY_SESSION_ENDED);
                else if (message ? !session_q || !its_own : !in_order && !repeated) finish(`HG_REPLY_OUT_OF_ORDER);
                else if (!message && repeated && reply_q == 2'd0) finish(`HG_REPLY_REPEATED);
                else if (i_status != `HG_REPLY_OK) finish(i_status);
                else if (tail_q) state_q <= TAIL;
                else finish(repeated ? `HG_REPLY_REPEATED : `HG_REPLY_OK);

            TAIL: begin
                if (o_push && !foci && i_word > i_top_index) bad_index_q <= 1'b1;
                if (done) finish(bad_index_q ? `HG_REPLY_BAD_INDEX : (foci && i_ring_split) || (message && i_stream_split) ? `HG_REPLY_BAD_LENGTH : `HG_REPLY_OK);
            end

            DRAIN: if (done) state_q <= CLOSE;  // what is left of a refused frame

            CLOSE: begin
                o_execute  <= o_status == `HG_REPLY_OK;
                o_repeated <= o_status == `HG_REPLY_REPEATED;
                o_refused  <= o_status > `HG_REPLY_REPEATED;
                if (o_status == `HG_REPLY_OK && !message) {session_q, o_expected} <= {1'b1, o_sequence + 8'd1};
                if (o_status == `HG_REPLY_OK && begins) session_number_q <= o_sequence;
                o_answer <= !message;
                state_q  <= message ? LENGTH : ANSWER;
            end

            default: if (i_answered) state_q <= LENGTH;  // ANSWER
        endcase

        if (NET != 0 && i_ended) session_q <= 1'b0;
        ended_q <= !rst && (i_ended ? ended_q || session_q : ended_q && !session_q);
        if (rst) begin
            state_q <= LENGTH;
            {session_q, o_execute, o_repeated, o_refused, o_answer} <= 5'd0;
        end
    end

    task finish(input [7:0] status);
        begin
            o_status <= status;
            state_q  <= DRAIN;
        end
    endtask
endmodule
`default_nettype wire
