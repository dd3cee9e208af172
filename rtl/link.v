// SPDX-License-Identifier: Apache-2.0
//
// The line to the host: bytes in and out at one end, words of good frames at the other.
//
// In: synchronizer, uart_rx, cobs_decoder, frame_receiver. Out: frame_transmitter, cobs_encoder, uart_tx. With CHAIN, chain_down and
// chain_up stand between these and the lines, and other tiles behind this one share them. With NET, bytes come and go at a network port
// (net/udp_link.v) instead: at most one a clock in, and a valid/ready stream out. Frames come out on
// the valid/take stream o_valid, o_word, i_take; replies go in on a valid/ready stream. o_good and o_damaged strobe once a
// frame.
// CHANNELS is the core's: a reply can carry one record. RING_BITS sets the room for what arrives, 2^RING_BITS words, at least
// twice the longest frame. CLOCK_HZ and BAUD set the bit clock. BAUD is at most CLOCK_HZ / 8, so that a bit has 8 clocks, and
// at least CLOCK_HZ / 20000, where the rounded step of the bit clock is off by 1 %.
`default_nettype none
`include "interface.vh"
module link #(
    parameter CHANNELS  = 100,
    parameter RING_BITS = 8,
    parameter CLOCK_HZ  = 50000000,
    parameter BAUD      = 1000000,
    parameter CHAIN     = 0,
    parameter NET       = 0,
    parameter SDRAM     = 0
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_rx,
    output wire        o_tx,
    input  wire        i_next,       // from the next tile's o_tx
    output wire        o_next,       // to its i_rx
    input  wire        i_net_valid,  // a byte
    input  wire [7:0]  i_net_byte,
    input  wire [2:0]  i_net_old,    // see urgent_commands
    input  wire        i_net_lost,   // strobes: see haptogram_core
    input  wire        i_net_end,
    input  wire        i_net_off,
    input  wire        i_net_stop,
    input  wire        i_alone,      // no host has taken over
    output wire        o_net_valid,
    input  wire        i_net_ready,
    output wire [7:0]  o_net_byte,
    input  wire        i_image,        // an image is read out of the flash: nobody hears answers
    input  wire        i_image_valid,  // a byte of it, in the place of one of the line
    input  wire [7:0]  i_image_byte,
    output wire        o_line_valid,   // strobe: a byte has come by the line, or the network
    output wire        o_valid,
    output wire [15:0] o_word,
    input  wire        i_take,
    output wire        o_good,
    output wire        o_damaged,
    input  wire        i_done,       // strobe: the frame has been carried out or refused
    input  wire        i_off,        // outputs are switched off
    output wire        o_disable,    // what waits came before a switch-off; this and the next three are urgent_commands'
    output wire        o_stop,
    output wire        o_stops,
    output wire        o_heard,
    output wire        o_ended,
    output wire        o_break,      // strobe: the line has been low for 20 bits, or likewise
    input  wire        i_reply_valid,
    output wire        o_reply_ready,
    input  wire [15:0] i_reply_word,
    input  wire        i_reply_last
);
    localparam RECORD_WORDS = CHANNELS + `HG_RECORD_HEADER_WORDS;
    // The longest reply carries a record or the identity block; its CRC and the COBS bytes come on top.
    localparam REPLY_WORDS = RECORD_WORDS > `HG_IDENTITY_WORDS ? RECORD_WORDS : `HG_IDENTITY_WORDS;
    localparam REPLY_BYTES = 1 << $clog2(6 + 2 * REPLY_WORDS + 2 + REPLY_WORDS / 127 + 3);
    // 2^20 · baud / clock, rounded. A parameter has the width that it was given with; an argument always has 32 bits.
    function [63:0] phase_step(input [31:0] clock_hz, input [31:0] baud);
        phase_step = (({32'd0, baud} << 20) + {33'd0, clock_hz[31:1]}) / {32'd0, clock_hz};
    endfunction
    localparam [63:0] STEP_64 = phase_step(CLOCK_HZ, BAUD);

    generate
        if (BAUD < CLOCK_HZ / 20000 || CLOCK_HZ / BAUD < 8) baud_out_of_range error();
        if (NET != 0 && CHAIN != 0) net_with_chain error();  // tiles of a network have ports of their own
        if (NET != 0 && REPLY_BYTES > 1024) net_with_too_many_channels error();  // a reply must fit into a datagram
    endgenerate

    wire       data_valid, data_end, data_intact, data_right, comes_valid, coming, frame_breaks;
    wire [7:0] line_byte, data_byte, comes_byte;
    wire       rx_valid = i_image_valid || comes_valid;
    wire [7:0] rx_byte  = i_image_valid ? i_image_byte : comes_byte;
    generate
        if (SDRAM != 0) begin : beside_image
            // The zero that ends an image must not take the place of a host's byte. So bytes come a clock later, from the image until there is a gap.
            reg       late_q, valid_q;
            reg [7:0] byte_q;
            always @(posedge clk) begin
                {valid_q, byte_q} <= {o_line_valid && !rst, line_byte};
                late_q <= rst || i_image || (late_q && o_line_valid);
            end
            assign {comes_valid, comes_byte} = late_q ? {valid_q, byte_q} : {o_line_valid, line_byte};
        end else begin : at_once
            assign {comes_valid, comes_byte} = {o_line_valid, line_byte};
        end
    endgenerate
    cobs_decoder decoder (
        .clk(clk), .rst(rst), .i_valid(rx_valid), .i_byte(rx_byte), .i_break(frame_breaks),
        .o_valid(data_valid), .o_byte(data_byte), .o_end(data_end), .o_intact(data_intact));
    frame_receiver #(.WORDS(1 << RING_BITS)) frames (
        .clk(clk), .rst(rst), .i_valid(data_valid), .i_byte(data_byte), .i_end(data_end), .i_intact(data_intact),
        .o_valid(o_valid), .o_word(o_word), .i_take(i_take), .o_right(data_right), .o_good(o_good), .o_damaged(o_damaged));
    // A frame takes two words of the ring or more.
    urgent_commands #(.FRAMES(1 << (RING_BITS - 1)), .NET(NET)) urgency (
        .clk(clk), .rst(rst), .i_coming(coming), .i_arrives(rx_valid), .i_valid(data_valid), .i_byte(data_byte), .i_end(data_end),
        .i_right(data_right), .i_good(o_good), .i_done(i_done), .i_off(i_off || o_break), .i_stops(NET != 0 && i_net_stop),
        .i_ends(NET != 0 && !i_image && (i_net_lost || i_net_end)), .i_old(NET != 0 && !i_image ? i_net_old : 3'b000),
        .o_disable(o_disable), .o_stop(o_stop), .o_stops(o_stops), .o_ended(o_ended), .o_heard(o_heard));

    wire       plain_valid, plain_ready, plain_last, made_valid, own_ready;
    wire       own_valid = made_valid && !i_image;
    wire [7:0] plain_byte, own_byte;
    frame_transmitter replies (
        .clk(clk), .rst(rst), .i_valid(i_reply_valid), .o_ready(o_reply_ready), .i_word(i_reply_word), .i_last(i_reply_last),
        .o_valid(plain_valid), .i_ready(plain_ready), .o_byte(plain_byte), .o_last(plain_last));
    cobs_encoder #(.BYTES(REPLY_BYTES)) encoder (
        .clk(clk), .rst(rst), .i_valid(plain_valid), .o_ready(plain_ready), .i_byte(plain_byte), .i_last(plain_last),
        .o_valid(made_valid), .i_ready(own_ready || i_image), .o_byte(own_byte));

    generate
        if (NET != 0) begin : over_network
            // A board that plays by itself needs no network.
            assign {o_line_valid, line_byte, o_break} = {i_net_valid, i_net_byte, i_net_off || (i_net_lost && !i_alone)};
            assign {coming, frame_breaks} = {SDRAM != 0 && o_line_valid, 1'b0};  // the port's datagrams end with a zero
            assign {o_net_valid, own_ready, o_net_byte} = {own_valid, i_net_ready, own_byte};
            assign {o_tx, o_next} = 2'b11;
            wire unused = &{1'b0, i_rx, i_next, STEP_64};
        end else begin : over_wires
            wire       line, own_line, unused_sample, tx_valid, tx_ready, head;
            wire [3:0] bits_left;
            wire [7:0] tx_byte;
            synchronizer #(.RESET_VALUE(1'b1)) rx_synchronizer (.clk(clk), .rst(rst), .i_foreign(i_rx), .o_synchronous(line));
            uart_rx #(.STEP(STEP_64[19:0])) receiver (
                .clk(clk), .rst(rst), .i_line(own_line), .o_byte(line_byte), .o_valid(o_line_valid), .o_sample(unused_sample), .o_bits_left(bits_left));
            line_break #(.BIT_CLOCKS(CLOCK_HZ / BAUD)) silence (.clk(clk), .rst(rst), .i_line(line), .o_break(o_break));
            uart_tx #(.STEP(STEP_64[19:0])) transmitter (
                .clk(clk), .rst(rst), .i_valid(tx_valid), .o_ready(tx_ready), .i_byte(tx_byte), .o_line(o_tx));
            assign {o_net_valid, o_net_byte} = 9'd0;
            assign coming = !own_line || bits_left != 4'd0 || head;
            assign frame_breaks = o_break;
            wire unused = &{1'b0, unused_sample, i_net_valid, i_net_byte, i_net_old, i_net_lost, i_net_end, i_net_off, i_net_stop, i_net_ready, i_alone};
            if (CHAIN != 0) begin : in_chain
                wire chained, next_line;
                chain_down #(.STEP(STEP_64[19:0])) down (
                    .clk(clk), .rst(rst), .i_line(line), .i_break(o_break), .o_line(own_line), .o_next(o_next), .o_chained(chained), .o_coming(head));
                synchronizer #(.RESET_VALUE(1'b1)) next_synchronizer (.clk(clk), .rst(rst), .i_foreign(i_next), .o_synchronous(next_line));
                chain_up #(.STEP(STEP_64[19:0]), .BIT_CLOCKS(CLOCK_HZ / BAUD), .BYTES(2 * REPLY_BYTES)) up (
                    .clk(clk), .rst(rst), .i_chained(chained), .i_next(next_line),
                    .i_valid(own_valid), .o_ready(own_ready), .i_byte(own_byte),
                    .o_valid(tx_valid), .i_ready(tx_ready), .o_byte(tx_byte));
            end else begin : alone
                assign own_line = line;
                assign {tx_valid, own_ready, tx_byte} = {own_valid, tx_ready, own_byte};
                assign {o_next, head} = 2'b10;
                wire unused_next = &{1'b0, i_next};
            end
        end
    endgenerate
endmodule
`default_nettype wire
