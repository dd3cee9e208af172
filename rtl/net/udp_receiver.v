// SPDX-License-Identifier: Apache-2.0
//
// Takes frames for this board out of Ethernet frames: the peer's datagrams to PORT, anybody's questions to PORT + 1 (the open port), and requests
// to be echoed, ARP for IP and ICMP echo. INTERFACE.md says which datagrams are good.
//
// Bytes of a payload go out as they come (o_write, o_byte), before it is known whether the datagram is good. A zero follows the last byte if that is
// none, because a frame ends with its datagram. Then o_commit or o_drop strobes, in a clock without o_write. i_full: a byte found no room, so the
// datagram is dropped. Each Ethernet frame is also written into a memory, from place 0 on. When it must be answered, o_answer is high until
// i_answered, with the kind of answer; a frame that comes meanwhile is not answered. peers.v compares the sender while the frame comes.
`default_nettype none
`include "interface.vh"
`include "answers.vh"
module udp_receiver #(
    parameter [47:0] MAC  = 48'h024847000001,
    parameter [31:0] IP   = 32'ha9fe4847,
    parameter [15:0] PORT = 16'd4807
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_valid,  // of eth_receiver
    input  wire [7:0]  i_byte,
    input  wire        i_end,
    input  wire        i_good,
    output reg         o_write,
    output reg  [7:0]  o_byte,
    input  wire        i_full,
    output reg         o_commit,
    output reg         o_drop,
    output wire        o_address,    // strobe: the byte that comes is one of the sender's address
    output wire [3:0]  o_address_place,  // which: 0 to 5 MAC, 6 to 9 IP, 10 and 11 port
    output wire        o_come,       // strobe: a byte of a frame
    output wire [7:0]  o_come_byte,
    output wire [10:0] o_come_place,
    output wire        o_gone,       // strobe: the frame is over
    output wire        o_taken,      // strobe, with o_gone: a good datagram to PORT
    input  wire        i_may,        // its sender is the peer, or becomes it
    output reg         o_answer,
    output reg  [1:0]  o_answer_kind,
    output reg  [10:0] o_answer_length,
    output reg  [15:0] o_answer_sum,   // the ICMP checksum
    output reg  [7:0]  o_asked,        // the command of a question to the open port
    input  wire        i_answered,
    output reg         o_disable,    // strobes: anybody sent DISABLE, or STOP, to the open port
    output reg         o_stop,
    output reg         o_accepted,   // strobes to be counted: a datagram of the peer was taken,
    output reg         o_refused,    // one of another sender was not,
    output reg         o_damaged     // a frame was not whole, or a datagram to PORT had a wrong sum or found no room
);
    localparam [15:0] OPEN = PORT + 16'd1, OPEN_DATAGRAM = 16'd12;  // its UDP length: 8 and 4 bytes

    // What byte n of a frame for this board is, where that is fixed; of ARP from 12 to 21: Ethernet, IPv4, addresses of 6 and 4 bytes, a request.
    function [7:0] own_byte(input [5:0] n);
        case (n)
            6'd0: own_byte = MAC[47:40];   6'd1: own_byte = MAC[39:32];   6'd2: own_byte = MAC[31:24];
            6'd3: own_byte = MAC[23:16];   6'd4: own_byte = MAC[15:8];    6'd5: own_byte = MAC[7:0];
            6'd12, 6'd16: own_byte = 8'h08;
            6'd13, 6'd18: own_byte = 8'h06;
            6'd15, 6'd21: own_byte = 8'h01;
            6'd19: own_byte = 8'h04;
            6'd30, 6'd38: own_byte = IP[31:24];  6'd31, 6'd39: own_byte = IP[23:16];
            6'd32, 6'd40: own_byte = IP[15:8];   6'd33, 6'd41: own_byte = IP[7:0];
            6'd36: own_byte = PORT[15:8];        6'd37: own_byte = PORT[7:0];
            6'd42: own_byte = 8'h48;             6'd43: own_byte = 8'h47;  // the letters HG of a question to the open port
            default: own_byte = 8'h00;
        endcase
    endfunction
    function [3:0] address_place(input [5:0] n);
        case (n)
            6'd6: address_place = 4'd0;   6'd7: address_place = 4'd1;   6'd8: address_place = 4'd2;   6'd9: address_place = 4'd3;
            6'd10: address_place = 4'd4;  6'd11: address_place = 4'd5;  6'd26: address_place = 4'd6;  6'd27: address_place = 4'd7;
            6'd28: address_place = 4'd8;  6'd29: address_place = 4'd9;  6'd34: address_place = 4'd10; default: address_place = 4'd11;
        endcase
    endfunction
    // Whether n is one of low to high: a sum of equalities takes two levels of logic, a comparison a carry chain.
    function among(input [5:0] n, input [5:0] low, input [5:0] high);
        integer k;
        begin
            among = 1'b0;
            for (k = 0; k < 64; k = k + 1) if (k[5:0] >= low && k[5:0] <= high && n == k[5:0]) among = 1'b1;
        end
    endfunction

    // ---- Where in the frame the byte stands: registers of the same clock as byte_q

    reg  [10:0] count_q;      // of the bytes so far
    reg  [5:0]  n_q;          // the same, up to 63
    reg  [10:0] place_q;
    reg  [3:0]  address_q;
    reg         valid_q, ends_q, good_q, gone_q, whole_q;  // gone_q and whole_q come a clock later, when all is settled
    reg  [7:0]  byte_q, own_q;
    reg         in_mac_q, in_address_q, in_type_q, in_arp_q, in_ip_q, in_port_q, in_arp_ip_q, in_header_q, in_sum_q, in_length_q, in_payload_q, in_headers_q;
    reg         in_letters_q, in_check_q;
    reg         at_14_q, at_16_q, at_17_q, at_20_q, at_21_q, at_23_q, at_34_q, at_35_q, at_36_q, at_37_q, at_38_q, at_39_q, at_44_q, at_45_q;
    initial {count_q, n_q, valid_q, ends_q, gone_q} = 20'd0;

    always @(posedge clk) begin
        if (rst || i_end) {count_q, n_q} <= 17'd0;
        else if (i_valid) begin
            if (count_q != 11'h7ff) count_q <= count_q + 11'd1;
            if (n_q != 6'd63) n_q <= n_q + 6'd1;
        end
        {valid_q, byte_q, place_q} <= {i_valid && !rst, i_byte, count_q};
        {ends_q, good_q}  <= {i_end && !rst, i_good};
        {gone_q, whole_q} <= {ends_q && !rst, good_q};
        own_q        <= own_byte(n_q);
        address_q    <= address_place(n_q);
        in_mac_q     <= among(n_q, 6'd0, 6'd5);
        in_address_q <= among(n_q, 6'd6, 6'd11) || among(n_q, 6'd26, 6'd29) || among(n_q, 6'd34, 6'd35);
        in_type_q    <= among(n_q, 6'd12, 6'd13);
        in_arp_q     <= among(n_q, 6'd12, 6'd21);
        in_ip_q      <= among(n_q, 6'd30, 6'd33);
        in_port_q    <= among(n_q, 6'd36, 6'd37);
        in_check_q   <= among(n_q, 6'd40, 6'd41);
        in_arp_ip_q  <= among(n_q, 6'd38, 6'd41);
        in_header_q  <= among(n_q, 6'd14, 6'd33);
        in_sum_q     <= among(n_q, 6'd16, 6'd17) || among(n_q, 6'd26, 6'd63);
        in_length_q  <= among(n_q, 6'd20, 6'd63);  // behind it
        in_headers_q <= among(n_q, 6'd0, 6'd40);   // all but their last byte
        in_letters_q <= among(n_q, 6'd42, 6'd43);
        in_payload_q <= among(n_q, 6'd42, 6'd63);
        {at_14_q, at_16_q, at_17_q, at_20_q} <= {n_q == 6'd14, n_q == 6'd16, n_q == 6'd17, n_q == 6'd20};
        {at_21_q, at_23_q, at_34_q, at_35_q} <= {n_q == 6'd21, n_q == 6'd23, n_q == 6'd34, n_q == 6'd35};
        {at_36_q, at_37_q, at_38_q, at_39_q} <= {n_q == 6'd36, n_q == 6'd37, n_q == 6'd38, n_q == 6'd39};
        {at_44_q, at_45_q} <= {n_q == 6'd44, n_q == 6'd45};
    end

    // ---- What the frame is: true until a byte says otherwise

    reg         mine_q, all_q, arp_q, arp_ip_q, ipv4_q, udp_q, icmp_q, ip_q, port_q, open_q, echo_q, lengths_q;
    reg         no_sum_q;      // the UDP checksum is 0: there is none
    reg         done_q;        // the last byte of the IP datagram has come
    reg         short_q;       // it ends among its headers
    reg  [2:0]  after_q;       // bytes behind it, up to 4, which the FCS has
    reg         lost_q;        // a byte found no room
    reg  [15:0] total_q, datagram_q, last_q;
    reg  [16:0] header_sum_q, sum_q;  // one's complement, the carry of the byte before on top
    reg         is_ip_q, sum_good_q, wrong_sum_q, asks_q;  // settled long before the frame's end, because the FCS follows
    reg  [7:0]  asked_q;
    wire        own    = byte_q == own_q;
    wire        zero   = byte_q == 8'd0;
    wire [15:0] addend = place_q[0] ? {8'd0, byte_q} : {byte_q, 8'd0};
    wire        stops  = in_length_q && place_q == last_q[10:0] && last_q[15:11] == 5'd0;
    wire [16:0] header_sum_d = {1'b0, header_sum_q[15:0]} + (valid_q && in_header_q ? {1'b0, addend} : 17'd0) + {16'd0, header_sum_q[16]};
    wire [16:0] sum_d        = {1'b0, sum_q[15:0]} + (valid_q && in_sum_q && !done_q ? {1'b0, addend} : 17'd0) + {16'd0, sum_q[16]};
    wire        sum_is_good    = no_sum_q || sum_q[15:0] == 16'hffff;
    wire        header_is_good = header_sum_q[15:0] == 16'hffff;
    wire        is_whole_ip    = ipv4_q && done_q && after_q == 3'd4 && !short_q;
    wire        knows  = asked_q == `HG_COMMAND_IDENTIFY || (mine_q && (asked_q == `HG_COMMAND_DISABLE || asked_q == `HG_COMMAND_STOP));

    always @(posedge clk) begin
        datagram_q <= total_q - 16'd20;
        last_q     <= total_q + 16'd13;
        sum_good_q <= sum_is_good;
        is_ip_q    <= is_whole_ip && header_is_good;
        wrong_sum_q <= is_whole_ip && !(header_is_good && sum_is_good) && udp_q && lengths_q && port_q && mine_q && ip_q;
        // IDENTIFY alone may be broadcast, to any IP address, because routers differ in it.
        asks_q     <= open_q && udp_q && lengths_q && datagram_q == OPEN_DATAGRAM && knows && ((mine_q && ip_q) || all_q);
        if (gone_q || rst) begin
            {mine_q, all_q, arp_q, arp_ip_q, ipv4_q, udp_q, icmp_q, ip_q, port_q, open_q, echo_q, lengths_q, no_sum_q} <= {13{1'b1}};
            {done_q, short_q, after_q, lost_q} <= 6'd0;
            header_sum_q <= 17'd0;
            sum_q        <= 17'h0fffc;  // the pseudo header has 17, which is UDP, and the length, which is 20 less than the one that comes
        end else begin
            header_sum_q <= header_sum_d;
            sum_q        <= sum_d;
            if (o_write && i_full) lost_q <= 1'b1;
            if (valid_q) begin
                if (in_mac_q && !own) mine_q <= 1'b0;
                if (in_mac_q && byte_q != 8'hff) all_q <= 1'b0;
                if (in_arp_q && !own) arp_q <= 1'b0;
                if (in_arp_ip_q && !own) arp_ip_q <= 1'b0;
                if (in_type_q && byte_q != (place_q[0] ? 8'h00 : 8'h08)) ipv4_q <= 1'b0;
                if (at_14_q && byte_q != 8'h45) ipv4_q <= 1'b0;  // also when there are options
                if (at_16_q) total_q[15:8] <= byte_q;
                if (at_17_q) total_q[7:0]  <= byte_q;
                if ((at_20_q && (byte_q & 8'hbf) != 8'd0) || (at_21_q && !zero)) ipv4_q <= 1'b0;  // a fragment: only DF may be set
                if (at_23_q && byte_q != 8'd17) udp_q <= 1'b0;
                if (at_23_q && byte_q != 8'd1) icmp_q <= 1'b0;
                if (in_ip_q && !own) ip_q <= 1'b0;
                if (in_port_q && !own) port_q <= 1'b0;
                if ((at_36_q && byte_q != OPEN[15:8]) || (at_37_q && byte_q != OPEN[7:0])) open_q <= 1'b0;
                if ((at_34_q && byte_q != 8'd8) || (at_35_q && !zero)) echo_q <= 1'b0;
                if ((at_38_q && byte_q != datagram_q[15:8]) || (at_39_q && byte_q != datagram_q[7:0])) lengths_q <= 1'b0;
                if (in_check_q && !zero) no_sum_q <= 1'b0;
                if ((in_letters_q && !own) || (at_45_q && !zero)) open_q <= 1'b0;
                if (at_44_q) asked_q <= byte_q;
                if (stops) done_q <= 1'b1;
                if (stops && in_headers_q) short_q <= 1'b1;
                if (done_q && after_q != 3'd4) after_q <= after_q + 3'd1;
            end
        end
    end

    // ---- What becomes of it

    wire good_udp = gone_q && whole_q && is_ip_q && udp_q && lengths_q && sum_good_q;
    wire asks     = good_udp && asks_q;
    wire keeps    = o_taken && i_may && !lost_q;
    assign o_taken = good_udp && port_q && mine_q && ip_q && !rst;
    assign o_gone  = gone_q;
    assign o_address       = valid_q && in_address_q;
    assign o_address_place = address_q;
    assign {o_come, o_come_byte, o_come_place} = {valid_q, byte_q, place_q};
    reg  unended_q;  // the payload's last byte so far is no zero
    wire to_write = valid_q && in_payload_q && ipv4_q && mine_q && ip_q && udp_q && port_q && !rst;
    initial {o_write, o_commit, o_drop, o_accepted, o_refused, o_damaged, o_disable, o_stop} = 8'd0;
    always @(posedge clk) begin
        o_write    <= to_write && (!done_q || unended_q);
        o_byte     <= done_q ? 8'd0 : byte_q;
        if (gone_q || rst) unended_q <= 1'b0;
        else if (to_write) unended_q <= !done_q && !zero;
        o_commit   <= keeps;
        o_drop     <= rst || (gone_q && !keeps);
        o_accepted <= keeps;
        o_refused  <= o_taken && !i_may;
        o_damaged  <= !rst && gone_q && (!whole_q || wrong_sum_q || (o_taken && i_may && lost_q));
        o_disable  <= !rst && asks && asked_q == `HG_COMMAND_DISABLE;
        o_stop     <= !rst && asks && asked_q == `HG_COMMAND_STOP;
    end

    // ---- What is answered

    reg  [15:0] icmp_sum_q;
    reg         kept_q;  // the memory has this frame from its first byte on
    wire [16:0] icmp_sum = {1'b0, icmp_sum_q} + 17'h00800;  // an answer's type is 0 instead of 8
    wire        is_arp   = arp_q && arp_ip_q && (mine_q || all_q);
    wire        is_ping  = is_ip_q && mine_q && ip_q && icmp_q && echo_q;
    initial {o_answer, kept_q} = 2'b01;
    always @(posedge clk) begin
        if (valid_q && at_36_q) icmp_sum_q[15:8] <= byte_q;
        if (valid_q && at_37_q) icmp_sum_q[7:0]  <= byte_q;
        if (gone_q || rst) kept_q <= 1'b1;
        else if (valid_q && o_answer) kept_q <= 1'b0;
        if (rst || i_answered) o_answer <= 1'b0;
        else if (!o_answer && gone_q && whole_q && kept_q) begin
            o_answer        <= is_arp || is_ping || asks;
            o_answer_kind   <= is_arp ? `HG_NET_ARP : is_ping ? `HG_NET_ICMP : `HG_NET_ABOUT;
            o_answer_length <= is_arp ? 11'd42 : is_ping ? total_q[10:0] + 11'd14 : `HG_NET_ABOUT_LENGTH;
            o_answer_sum    <= icmp_sum[15:0] + {15'd0, icmp_sum[16]};
            o_asked         <= asked_q;
        end
    end
endmodule
`default_nettype wire
