// SPDX-License-Identifier: Apache-2.0
//
// The bytes before the payload of a frame that is sent: what stands at place i_n of it, unless it is copied from the frame that it answers.
//
// Of i_n at the input, o_known and o_byte come two clocks later. i_peer_byte is the receiver's address, byte o_peer_place of it, which is
// there in the clock after i_n. i_n stays at 63 from there on; then nothing is known.
`default_nettype none
`include "interface.vh"
`include "answers.vh"
module answer_header #(
    parameter [47:0] MAC  = 48'h024847000001,
    parameter [31:0] IP   = 32'ha9fe4847,
    parameter [15:0] PORT = 16'd4807
) (
    input  wire        clk,
    input  wire [1:0]  i_kind,
    input  wire [5:0]  i_n,
    input  wire [15:0] i_total,     // of the IP datagram, in bytes
    input  wire [15:0] i_datagram,  // of the UDP datagram
    input  wire [15:0] i_header_sum,
    input  wire [15:0] i_icmp_sum,
    output reg  [3:0]  o_peer_place,
    input  wire [7:0]  i_peer_byte,
    output reg         o_known,
    output reg  [7:0]  o_byte
);
    localparam [15:0] OPEN = PORT + 16'd1;
    wire is_udp = i_kind == `HG_NET_REPLIES || i_kind == `HG_NET_ABOUT, is_arp = i_kind == `HG_NET_ARP, is_icmp = i_kind == `HG_NET_ICMP;
    wire [15:0] own_port = i_kind == `HG_NET_ABOUT ? OPEN : PORT;

    reg       fixed_known, counted_known, from_peer;
    reg [7:0] fixed, counted;
    reg [3:0] place;
    always @* begin  // what all frames of a kind have alike
        fixed_known = is_udp;
        case (i_n)
            6'd6:  {fixed_known, fixed} = {1'b1, MAC[47:40]};
            6'd7:  {fixed_known, fixed} = {1'b1, MAC[39:32]};
            6'd8:  {fixed_known, fixed} = {1'b1, MAC[31:24]};
            6'd9:  {fixed_known, fixed} = {1'b1, MAC[23:16]};
            6'd10: {fixed_known, fixed} = {1'b1, MAC[15:8]};
            6'd11: {fixed_known, fixed} = {1'b1, MAC[7:0]};
            6'd12: fixed = 8'h08;
            6'd14: fixed = 8'h45;
            6'd20: fixed = 8'h40;  // don't fragment
            6'd21: begin fixed_known = is_udp || is_arp; fixed = is_arp ? 8'h02 : 8'h00; end  // an ARP reply
            6'd22: begin fixed_known = is_udp || is_arp; fixed = is_arp ? MAC[47:40] : 8'h40; end  // 64 hops
            6'd23: begin fixed_known = is_udp || is_arp; fixed = is_arp ? MAC[39:32] : 8'h11; end  // UDP
            6'd24: {fixed_known, fixed} = {is_arp, MAC[31:24]};
            6'd25: {fixed_known, fixed} = {is_arp, MAC[23:16]};
            6'd26: {fixed_known, fixed} = {1'b1, is_arp ? MAC[15:8] : IP[31:24]};
            6'd27: {fixed_known, fixed} = {1'b1, is_arp ? MAC[7:0] : IP[23:16]};
            6'd28: {fixed_known, fixed} = {1'b1, is_arp ? IP[31:24] : IP[15:8]};
            6'd29: {fixed_known, fixed} = {1'b1, is_arp ? IP[23:16] : IP[7:0]};
            6'd30: {fixed_known, fixed} = {is_arp, IP[15:8]};
            6'd31: {fixed_known, fixed} = {is_arp, IP[7:0]};
            6'd34: {fixed_known, fixed} = {is_udp || is_icmp, is_icmp ? 8'd0 : own_port[15:8]};  // an echo reply
            6'd35: fixed = own_port[7:0];
            // identification and flags 0, no UDP checksum: the FCS and the frames' own CRC are enough
            6'd13, 6'd15, 6'd18, 6'd19, 6'd40, 6'd41: fixed = 8'h00;
            default: {fixed_known, fixed} = 9'd0;
        endcase
    end
    always @* begin  // what differs
        counted_known = is_udp;
        case (i_n)
            6'd16: counted = i_total[15:8];
            6'd17: counted = i_total[7:0];
            6'd24: counted = i_header_sum[15:8];
            6'd25: counted = i_header_sum[7:0];
            6'd38: counted = i_datagram[15:8];
            6'd39: counted = i_datagram[7:0];
            6'd36: {counted_known, counted} = {is_icmp, i_icmp_sum[15:8]};
            6'd37: {counted_known, counted} = {is_icmp, i_icmp_sum[7:0]};
            default: {counted_known, counted} = 9'd0;
        endcase
    end
    always @* begin  // the receiver's address
        from_peer = is_udp;
        case (i_n)
            6'd0, 6'd1, 6'd2, 6'd3, 6'd4, 6'd5: place = i_n[3:0];
            6'd30: place = 4'd6;
            6'd31: place = 4'd7;
            6'd32: place = 4'd8;
            6'd33: place = 4'd9;
            6'd36: place = 4'd10;
            6'd37: place = 4'd11;
            default: {from_peer, place} = 5'd0;
        endcase
    end

    reg       fixed_known_q, counted_known_q, from_peer_q;
    reg [7:0] fixed_q, counted_q;
    always @(posedge clk) begin
        {fixed_known_q, fixed_q, counted_known_q, counted_q} <= {fixed_known, fixed, counted_known, counted};
        {from_peer_q, o_peer_place} <= {from_peer, place};
        o_known <= fixed_known_q || counted_known_q || from_peer_q;
        o_byte  <= fixed_known_q ? fixed_q : counted_known_q ? counted_q : i_peer_byte;
    end
endmodule
`default_nettype wire
