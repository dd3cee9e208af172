// SPDX-License-Identifier: Apache-2.0
//
// An Ethernet port in place of the serial line: bytes of the peer's UDP datagrams come out in the instrument's clock domain, and bytes of replies
// go back to the peer. ../README.md shows the modules, ../INTERFACE.md says what a host sees.
//
// eth_clk is the PHY's 125 MHz; i_dv to o_data are GMII. Between frames i_data is the PHY's status, as in RGMII. In clk's domain o_byte is a valid/take
// stream of whole, checked datagrams, each with a zero at its end, and i_byte a valid/ready stream of replies that end with a zero each.
// o_lost strobes when the link is lost; o_off at the end of a datagram in which the peer sent DISABLE, and when anybody sends DISABLE to the open
// port; o_stop in the same way for STOP; o_end when a session ends, because anybody sent DISABLE to the open port or the peer is another one.
// i_off (level or strobe): the instrument switches its outputs off. Bytes that are anywhere in this module, or arrive, at such an event are
// old. o_old is high while old bytes are left: bit 0 for o_off and i_off, 1 for o_stop, 2 for o_lost, reset, and DISABLE to the open port.
// RX_BITS: there is room for 2^RX_BITS bytes of datagrams. PEER_CLOCKS of eth_clk without a datagram end a peer; GATHER_CLOCKS is how long a reply
// waits for others.
`default_nettype none
module udp_link #(
    parameter [47:0] MAC  = 48'h024847000001,
    parameter [31:0] IP   = 32'ha9fe4847,
    parameter [15:0] PORT = 16'd4807,
    parameter RX_BITS       = 12,
    parameter PEER_CLOCKS   = 125000000,
    parameter GATHER_CLOCKS = 6250
) (
    input  wire        eth_clk,
    input  wire        i_dv,
    input  wire        i_er,
    input  wire [7:0]  i_data,
    output wire        o_en,
    output wire [7:0]  o_data,
    input  wire        clk,
    input  wire        rst,
    output wire        o_valid,
    output wire [7:0]  o_byte,
    input  wire        i_take,
    input  wire        i_valid,
    output wire        o_ready,
    input  wire [7:0]  i_byte,
    output wire [2:0]  o_old,
    output wire        o_lost,
    output wire        o_end,
    output wire        o_off,
    output wire        o_stop,
    input  wire        i_off,
    input  wire        i_enabled,         // for the open port to tell
    output wire [4:0]  o_identity_place,  // of a word of the identity block, which is combinational
    input  wire [15:0] i_identity_word
);
    localparam REPLY_BITS = 10;

    wire link, runs, runs_there;
    reg  eth_rst;
    initial eth_rst = 1'b1;
    // The reset drops a datagram in which the PHY's clock has stopped for long.
    synchronizer #(.RESET_VALUE(1'b0)) runs_crossing (.clk(eth_clk), .rst(1'b0), .i_foreign(runs), .o_synchronous(runs_there));
    always @(posedge eth_clk) eth_rst <= !link || !runs_there;
    link_status status (.clk(eth_clk), .i_dv(i_dv), .i_er(i_er), .i_status(i_data[2:0]), .o_link(link));
    link_watch watch (.eth_clk(eth_clk), .i_link(link), .clk(clk), .rst(rst), .o_lost(o_lost), .o_runs(runs));

    // ---- In

    wire        rx_valid, rx_end, rx_good, write, full, commit, drop, address, come, gone, taken, may, changed, held, early_disable, early_stop;
    wire        answer, answered, disable_asked, stop_asked, accepted, refused, damaged;
    wire [1:0]  answer_kind;
    wire [3:0]  address_place;
    wire [7:0]  rx_byte, data, come_byte, asked;
    wire [10:0] come_place, answer_length;
    wire [15:0] answer_sum;
    eth_receiver frames (
        .clk(eth_clk), .rst(eth_rst), .i_dv(i_dv), .i_er(i_er), .i_data(i_data),
        .o_valid(rx_valid), .o_byte(rx_byte), .o_end(rx_end), .o_good(rx_good));
    udp_receiver #(.MAC(MAC), .IP(IP), .PORT(PORT)) datagrams (
        .clk(eth_clk), .rst(eth_rst), .i_valid(rx_valid), .i_byte(rx_byte), .i_end(rx_end), .i_good(rx_good),
        .o_write(write), .o_byte(data), .i_full(full), .o_commit(commit), .o_drop(drop),
        .o_address(address), .o_address_place(address_place), .o_come(come), .o_come_byte(come_byte), .o_come_place(come_place),
        .o_gone(gone), .o_taken(taken), .i_may(may),
        .o_answer(answer), .o_answer_kind(answer_kind), .o_answer_length(answer_length), .o_answer_sum(answer_sum), .o_asked(asked),
        .i_answered(answered), .o_disable(disable_asked), .o_stop(stop_asked),
        .o_accepted(accepted), .o_refused(refused), .o_damaged(damaged));
    early_commands early (
        .clk(eth_clk), .rst(eth_rst), .i_write(write), .i_byte(data), .i_gone(commit || drop), .o_disable(early_disable), .o_stop(early_stop));
    wire [RX_BITS:0] committed, fetched;
    datagram_fifo #(.BITS(RX_BITS)) arrived (
        .i_clk(eth_clk), .i_write(write), .i_byte(data), .i_commit(commit), .i_drop(drop), .o_full(full), .o_start(committed),
        .o_clk(clk), .o_valid(o_valid), .o_byte(o_byte), .i_take(i_take), .o_taken(fetched));

    // ---- Events, and the bytes that are old then. No byte of a new peer is old: the peer's address is known before its datagram is here.

    wire anybodys;
    wire said = taken && may;
    strobe_crossing off (.i_clk(eth_clk), .i_strobe(disable_asked || (said && early_disable)), .o_clk(clk), .o_strobe(o_off));
    strobe_crossing stop (.i_clk(eth_clk), .i_strobe(stop_asked || (said && early_stop)), .o_clk(clk), .o_strobe(o_stop));
    strobe_crossing anybody (.i_clk(eth_clk), .i_strobe(disable_asked), .o_clk(clk), .o_strobe(anybodys));
    wire changes;
    strobe_crossing peer_changes (.i_clk(eth_clk), .i_strobe(changed), .o_clk(clk), .o_strobe(changes));
    assign o_end = anybodys || changes;
    datagram_mark #(.BITS(RX_BITS)) at_off (
        .i_clk(eth_clk), .i_dv(i_dv), .i_start(committed), .o_clk(clk), .i_mark(i_off || o_off), .i_taken(fetched), .o_old(o_old[0]));
    datagram_mark #(.BITS(RX_BITS)) at_stop (
        .i_clk(eth_clk), .i_dv(i_dv), .i_start(committed), .o_clk(clk), .i_mark(o_stop), .i_taken(fetched), .o_old(o_old[1]));
    datagram_mark #(.BITS(RX_BITS)) at_end (
        .i_clk(eth_clk), .i_dv(i_dv), .i_start(committed), .o_clk(clk), .i_mark(o_lost || anybodys || rst), .i_taken(fetched), .o_old(o_old[2]));

    // ---- Who

    wire       keeps_peer, reads_asker;
    wire [3:0] peer_place;
    wire [7:0] peer_byte;
    peers #(.PEER_CLOCKS(PEER_CLOCKS)) who (
        .clk(eth_clk), .rst(eth_rst), .i_address(address), .i_place(address_place), .i_byte(come_byte), .i_come(come), .i_gone(gone),
        .i_taken(taken), .o_may(may), .o_changed(changed), .o_held(held), .i_keeps_asker(answer), .i_keeps_peer(keeps_peer),
        .i_reads_asker(reads_asker), .i_read_place(peer_place), .o_read_byte(peer_byte));

    // ---- Out; replies before the core's reset do not count

    (* no_rw_check *) reg [7:0] kept [0:2047];  // the frame that may have to be answered
    reg  [7:0]  kept_q, kept_2_q;
    wire [10:0] kept_place;
    always @(posedge eth_clk) begin
        if (come && !answer) kept[come_place] <= come_byte;
        kept_q   <= kept[kept_place];
        kept_2_q <= kept_q;
    end

    wire       enabled;
    reg        were_on_q;  // outputs were enabled when the frame came that is answered
    always @(posedge eth_clk) if (!answer) were_on_q <= enabled;
    wire [5:0] about_place;
    wire [7:0] about_byte;
    synchronizer #(.RESET_VALUE(1'b0)) enabled_crossing (.clk(eth_clk), .rst(1'b0), .i_foreign(i_enabled), .o_synchronous(enabled));
    about_block about (
        .clk(eth_clk), .i_place(about_place), .i_command(asked), .i_flags({6'd0, were_on_q, held}),
        .o_identity_place(o_identity_place), .i_identity_word(i_identity_word),
        .i_accepted(accepted), .i_refused(refused), .i_damaged(damaged), .o_byte(about_byte));

    wire                  sent;
    wire [REPLY_BITS:0]   reply_length, sent_length;
    wire [REPLY_BITS-1:0] reply_start, reply_place;
    wire [7:0]            reply_byte;
    reply_memory #(.BITS(REPLY_BITS), .GATHER_CLOCKS(GATHER_CLOCKS)) replies (
        .i_clk(clk), .i_valid(i_valid && !rst), .o_ready(o_ready), .i_byte(i_byte), .o_clk(eth_clk), .i_forget(!held && !keeps_peer),
        .o_length(reply_length), .o_place(reply_start), .i_place(reply_place), .o_byte(reply_byte),
        .i_sent(sent), .i_sent_length(sent_length));
    eth_transmitter #(.MAC(MAC), .IP(IP), .PORT(PORT), .REPLY_BITS(REPLY_BITS)) transmitter (
        .clk(eth_clk), .rst(eth_rst),
        .i_answer(answer), .i_answer_kind(answer_kind), .i_answer_length(answer_length), .i_answer_sum(answer_sum), .o_answered(answered),
        .o_kept_place(kept_place), .i_kept_byte(kept_2_q), .o_about_place(about_place), .i_about_byte(about_byte),
        .i_held(held), .o_keeps_peer(keeps_peer), .o_reads_asker(reads_asker), .o_peer_place(peer_place), .i_peer_byte(peer_byte),
        .i_reply_length(reply_length), .i_reply_place(reply_start), .o_reply_place(reply_place), .i_reply_byte(reply_byte),
        .o_sent(sent), .o_sent_length(sent_length), .o_en(o_en), .o_data(o_data));
endmodule
`default_nettype wire
