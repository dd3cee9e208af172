// SPDX-License-Identifier: Apache-2.0
//
// Answers a frame: three header words, then words from the address space, or their digest instead of them.
//
// i_answer starts it; the fields beside it must stay until o_answered strobes. The reply is a valid/ready stream whose last
// word has o_last. To read a word, o_read is held until i_granted; i_read_word follows two clocks later.
// The digest is the CRC-32 of IEEE 802.3. It lets a host find out which records differ without reading them all. It is computed
// bit by bit, 16 clocks a word, because the line is much slower than that.
// WORD_BITS is as wide as the address of a 16-bit word in the largest region.
`default_nettype none
module reply_unit #(
    parameter WORD_BITS = 16
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_answer,      // strobe; the fields below stay until o_answered
    input  wire [7:0]  i_sequence,
    input  wire [7:0]  i_command,
    input  wire [7:0]  i_status,
    input  wire [7:0]  i_expected,
    input  wire [15:0] i_live_level,
    input  wire [WORD_BITS-1:0] i_address,
    input  wire [15:0] i_words,
    input  wire        i_digest,      // answer with the digest of the words instead of them
    output wire        o_read,
    output reg  [WORD_BITS-1:0] o_address,
    input  wire        i_granted,
    input  wire [15:0] i_read_word,
    output wire        o_valid,
    input  wire        i_ready,
    output reg  [15:0] o_word,
    output wire        o_last,
    output wire        o_answered
);
    localparam [3:0] IDLE = 4'd0, HEAD_0 = 4'd1, HEAD_1 = 4'd2, HEAD_2 = 4'd3, ASK = 4'd4, WAIT = 4'd5, FETCH = 4'd6, FOLD = 4'd7,
                     DIGEST = 4'd8, SEND = 4'd9;

    reg [3:0]  state_q;
    reg [15:0] words_q;  // words still to be read
    reg [31:0] crc_q;
    reg [3:0]  bit_q;
    wire       none = words_q == 16'd0;

    assign o_read     = state_q == ASK;
    assign o_valid    = state_q == HEAD_0 || state_q == HEAD_1 || state_q == HEAD_2 || state_q == SEND;
    assign o_last     = (state_q == HEAD_2 || state_q == SEND) && none;
    assign o_answered = o_valid && i_ready && o_last;

    always @(posedge clk) begin
        case (state_q)
            IDLE: if (i_answer) begin
                o_word    <= {i_command | 8'h80, i_sequence};
                o_address <= i_address;
                words_q   <= i_words;
                {crc_q, bit_q} <= {32'hffff_ffff, 4'd0};
                state_q   <= HEAD_0;
            end
            HEAD_0: if (i_ready) begin
                o_word  <= {i_expected, i_status};
                state_q <= HEAD_1;
            end
            HEAD_1: if (i_ready) begin
                o_word  <= i_live_level;
                state_q <= HEAD_2;
            end
            HEAD_2: if (i_ready) state_q <= none ? IDLE : ASK;
            ASK: if (i_granted) state_q <= WAIT;
            WAIT: state_q <= FETCH;
            FETCH: begin
                o_word    <= i_read_word;
                o_address <= o_address + 1'b1;
                words_q   <= words_q - 1'b1;
                state_q   <= i_digest ? FOLD : SEND;
            end
            FOLD: begin
                crc_q  <= {1'b0, crc_q[31:1]} ^ (crc_q[0] ^ o_word[0] ? 32'hedb8_8320 : 32'd0);
                o_word <= {1'b0, o_word[15:1]};
                bit_q  <= bit_q + 4'd1;
                if (bit_q == 4'd15) state_q <= none ? DIGEST : ASK;
            end
            DIGEST: begin  // comes twice, for the two halves: bit_q is 0 and then 1
                o_word      <= ~crc_q[15:0];
                crc_q[15:0] <= crc_q[31:16];
                words_q     <= {15'd0, !bit_q[0]};
                bit_q       <= 4'd1;
                state_q     <= SEND;
            end
            default: if (i_ready) state_q <= none ? IDLE : i_digest ? DIGEST : ASK;  // SEND
        endcase
        if (rst) state_q <= IDLE;
    end
endmodule
`default_nettype wire
