// SPDX-License-Identifier: Apache-2.0
//
// Sends Ethernet frames: the replies that wait, as a datagram to the peer, and answers to what udp_receiver has kept. Replies go first.
//
// i_reply_length bytes wait in the reply memory from i_reply_place on; when they are sent, o_sent strobes and o_sent_length says how many they were.
// Each memory gives the byte of its place two clocks later. i_about_byte is byte o_about_place of what the open port answers.
// o_en and o_data are GMII; preamble, padding, FCS and the gap of 12 bytes are made here. A frame begins 14 clocks after it is decided on.
`default_nettype none
`include "interface.vh"
`include "answers.vh"
module eth_transmitter #(
    parameter [47:0] MAC  = 48'h024847000001,
    parameter [31:0] IP   = 32'ha9fe4847,
    parameter [15:0] PORT = 16'd4807,
    parameter REPLY_BITS  = 10
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_answer,
    input  wire [1:0]  i_answer_kind,
    input  wire [10:0] i_answer_length,
    input  wire [15:0] i_answer_sum,
    output reg         o_answered,    // strobe
    output reg  [10:0] o_kept_place,  // of the frame that is answered
    input  wire [7:0]  i_kept_byte,
    output reg  [5:0]  o_about_place,
    input  wire [7:0]  i_about_byte,
    input  wire        i_held,        // there is a peer
    output wire        o_keeps_peer,
    output wire        o_reads_asker,
    output wire [3:0]  o_peer_place,
    input  wire [7:0]  i_peer_byte,
    input  wire [REPLY_BITS:0]   i_reply_length,  // 0: nothing is to be sent now
    input  wire [REPLY_BITS-1:0] i_reply_place,
    output reg  [REPLY_BITS-1:0] o_reply_place,
    input  wire [7:0]  i_reply_byte,
    output reg         o_sent,
    output reg  [REPLY_BITS:0]   o_sent_length,
    output reg         o_en,
    output reg  [7:0]  o_data
);
    `include "crc32.vh"
    localparam [10:0] HEADERS = `HG_NET_HEADERS;
    localparam [2:0] IDLE = 3'd0, SUM = 3'd1, PREAMBLE = 3'd2, BODY = 3'd3, CHECK = 3'd4, GAP = 3'd5;
    localparam [1:0] NOTHING = 2'd0, PLAIN = 2'd1, COVERED = 2'd2, FCS = 2'd3;  // a byte before the FCS, one that it covers, one of it
    // Of the header's sum: 45 00, don't fragment, 64 hops and UDP, our address.
    localparam [31:0] FIXED = 32'h4500 + 32'h4000 + 32'h4011 + {16'd0, IP[31:16]} + {16'd0, IP[15:0]};
    localparam [16:0] FIXED_SUM = {1'b0, FIXED[15:0]} + {1'b0, FIXED[31:16]};

    // ---- What is sent, and which byte of it

    reg [2:0]  state_q;
    reg [1:0]  kind_q;
    reg [10:0] payload_q;
    reg [10:0] n_q, length_q, end_q;  // length_q without the padding; end_q is the last place before the FCS
    reg [5:0]  low_q;                 // n_q, up to 63
    reg [3:0]  step_q;
    reg [15:0] total_q, datagram_q, addend_q;
    reg [16:0] sum_q;
    initial {state_q, o_answered, o_sent} = {IDLE, 2'b00};
    wire        replies  = i_held && i_reply_length != {(REPLY_BITS+1){1'b0}};
    wire        begins   = state_q == IDLE;
    wire        restarts = begins || (state_q == SUM && step_q == 4'd8) || (state_q == PREAMBLE && n_q == 11'd7) || (state_q == BODY && n_q == end_q)
                           || (state_q == CHECK && n_q == 11'd3);
    assign o_keeps_peer  = begins ? replies : kind_q == `HG_NET_REPLIES && state_q != GAP;
    assign o_reads_asker = kind_q == `HG_NET_ABOUT;

    always @(posedge clk) begin
        {o_answered, o_sent} <= 2'b00;
        n_q   <= restarts ? 11'd0 : n_q + 11'd1;
        // While the sum is made, it names the receiver's IP address.
        low_q <= begins ? 6'd30 : restarts ? 6'd0 : low_q == 6'd63 ? 6'd63 : low_q + 6'd1;
        end_q <= length_q < 11'd60 ? 11'd59 : length_q - 11'd1;
        // Of the byte that was asked for a clock before; it is added in the next one.
        addend_q <= step_q == 4'd5 ? total_q : step_q[0] ? {i_peer_byte, 8'd0} : {8'd0, i_peer_byte};
        case (state_q)
            IDLE: begin
                if (replies || i_answer) state_q <= SUM;
                kind_q     <= replies ? `HG_NET_REPLIES : i_answer_kind;
                payload_q  <= replies ? {{(10-REPLY_BITS){1'b0}}, i_reply_length} : `HG_NET_ABOUT_LENGTH - HEADERS;
                sum_q      <= {1'b0, FIXED_SUM[15:0]} + {16'd0, FIXED_SUM[16]};
                step_q     <= 4'd0;
                o_sent_length <= i_reply_length;
            end
            SUM: begin  // four bytes of an address, the length, and what is carried twice
                length_q   <= kind_q == `HG_NET_REPLIES ? payload_q + HEADERS : i_answer_length;
                total_q    <= {5'd0, payload_q} + 16'd28;
                datagram_q <= {5'd0, payload_q} + 16'd8;
                step_q <= step_q + 4'd1;
                sum_q  <= {1'b0, sum_q[15:0]} + (step_q > 4'd1 && step_q < 4'd7 ? {1'b0, addend_q} : 17'd0) + {16'd0, sum_q[16]};
                if (step_q == 4'd8) state_q <= PREAMBLE;
            end
            PREAMBLE: if (n_q == 11'd7) state_q <= BODY;
            BODY:     if (n_q == end_q) state_q <= CHECK;
            CHECK:    if (n_q == 11'd3) begin
                state_q    <= GAP;
                o_answered <= kind_q != `HG_NET_REPLIES;
                o_sent     <= kind_q == `HG_NET_REPLIES;
            end
            default:  if (n_q == 11'd11) state_q <= IDLE;
        endcase
        if (rst) state_q <= IDLE;
    end

    // ---- The byte: of the header two clocks later, of a memory one after its place and two more

    wire       known;
    wire [7:0] header;
    answer_header #(.MAC(MAC), .IP(IP), .PORT(PORT)) headers (
        .clk(clk), .i_kind(kind_q), .i_n(low_q), .i_total(total_q), .i_datagram(datagram_q), .i_header_sum(~sum_q[15:0]),
        .i_icmp_sum(i_answer_sum), .o_peer_place(o_peer_place), .i_peer_byte(i_peer_byte), .o_known(known), .o_byte(header));

    // Where in the frame that is answered the next byte stands: our target is its sender.
    reg signed [4:0] shift;
    always @* case (low_q)
        6'd0, 6'd1, 6'd2, 6'd3, 6'd4: shift = 5'sd6;
        6'd29: shift = kind_q == `HG_NET_ICMP ? -5'sd4 : 5'sd0;
        6'd30: shift = kind_q == `HG_NET_ICMP ? -5'sd4 : 5'sd0;
        6'd31, 6'd32: shift = kind_q == `HG_NET_ICMP ? -5'sd4 : -5'sd10;
        6'd33, 6'd34, 6'd35, 6'd36, 6'd37, 6'd38, 6'd39, 6'd40: shift = kind_q == `HG_NET_ARP ? -5'sd10 : 5'sd0;
        default: shift = 5'sd0;
    endcase
    reg signed [4:0] shift_q;
    reg [REPLY_BITS-1:0] base_q;
    reg [1:0]  what_0_q, what_1_q, what_2_q, what_3_q;
    reg        pads_0_q, pads_1_q, pads_2_q, known_q, sfd_0_q, sfd_1_q, sfd_2_q;
    reg [7:0]  header_q, byte_q;
    reg [31:0] crc_q;
    initial {what_0_q, what_1_q, what_2_q, what_3_q, o_en} = 9'd0;
    always @(posedge clk) begin
        shift_q <= state_q == BODY ? shift : 5'sd6;
        base_q  <= i_reply_place - HEADERS[REPLY_BITS-1:0];
        o_kept_place  <= n_q + {{6{shift_q[4]}}, shift_q};
        o_about_place <= n_q[5:0] - HEADERS[5:0];
        o_reply_place <= n_q[REPLY_BITS-1:0] + base_q;

        what_0_q <= state_q == PREAMBLE ? PLAIN : state_q == BODY ? COVERED : state_q == CHECK ? FCS : NOTHING;
        sfd_0_q  <= n_q == 11'd7;
        pads_0_q <= n_q >= length_q;
        {what_1_q, sfd_1_q, pads_1_q} <= {what_0_q, sfd_0_q, pads_0_q};
        {what_2_q, sfd_2_q, pads_2_q, known_q, header_q} <= {what_1_q, sfd_1_q, pads_1_q, known, header};

        what_3_q <= what_2_q;
        if (what_2_q == PLAIN) byte_q <= sfd_2_q ? 8'hd5 : 8'h55;
        else if (pads_2_q) byte_q <= 8'h00;
        else if (known_q) byte_q <= header_q;
        else byte_q <= kind_q == `HG_NET_REPLIES ? i_reply_byte : kind_q == `HG_NET_ABOUT ? i_about_byte : i_kept_byte;

        o_en   <= what_3_q != NOTHING;
        o_data <= what_3_q == FCS ? ~crc_q[7:0] : byte_q;
        case (what_3_q)
            COVERED: crc_q <= crc32(crc_q, byte_q);
            FCS:     crc_q <= {8'hff, crc_q[31:8]};
            default: crc_q <= 32'hffffffff;
        endcase
    end
endmodule
`default_nettype wire
