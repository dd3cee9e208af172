// SPDX-License-Identifier: Apache-2.0
// The kinds of frames that eth_transmitter sends.
`define HG_NET_ARP     2'd0
`define HG_NET_ICMP    2'd1
`define HG_NET_REPLIES 2'd2  // to the peer
`define HG_NET_ABOUT   2'd3  // of the open port, to whom it was that asked
// The bytes before a payload, and those of the frame in which the open port answers: about_block's five words and the identity block's.
`define HG_NET_HEADERS 11'd42
`define HG_NET_ABOUT_LENGTH (`HG_NET_HEADERS + 11'd2 * (11'd5 + 11'd`HG_IDENTITY_WORDS))
