// SPDX-License-Identifier: Apache-2.0
//
// Indices from the link, waiting to be played: a FIFO of (index, dwell) whose writer commits or takes back a whole frame
// at once, so that a refused frame pushes nothing. o_valid/i_take is the reading side, data held while it waits.
// i_clear empties it. DEPTH is a power of two, 4…32768.
`default_nettype none
module live_fifo #(
    parameter DEPTH = 256
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_clear,
    input  wire        i_push,      // provisional until i_keep; only while o_free > 0
    input  wire [31:0] i_entry,
    input  wire        i_keep,
    input  wire        i_take_back,
    output wire [15:0] o_free,
    output wire [15:0] o_level,
    output reg         o_valid,
    output reg  [31:0] o_entry,
    input  wire        i_take
);
    localparam BITS = $clog2(DEPTH);
    localparam [15:0] PLACES = DEPTH[15:0];

    generate
        if (DEPTH < 4 || DEPTH > 32768 || DEPTH != (1 << BITS)) depth_out_of_range error();
    endgenerate

    (* no_rw_check *) reg [31:0] entries [0:DEPTH-1];  // what is written can be read a clock later at the earliest
    // One bit more than the address tells full from empty.
    reg [BITS:0] kept_q;   // end of what may be read
    reg [BITS:0] write_q;  // end of what has been pushed
    reg [BITS:0] read_q;

    wire [BITS:0] read_d = read_q + {{BITS{1'b0}}, o_valid && i_take};
    wire [BITS:0] level  = kept_q - read_q;
    wire [BITS:0] used   = write_q - read_q;
    assign o_level = {{(15-BITS){1'b0}}, level};
    assign o_free  = {{(15-BITS){1'b0}}, PLACES[BITS:0] - used};

    always @(posedge clk) begin
        if (i_push) entries[write_q[BITS-1:0]] <= i_entry;
        o_entry <= entries[read_d[BITS-1:0]];
    end

    always @(posedge clk) begin
        if (rst || i_clear) begin
            kept_q  <= {(BITS+1){1'b0}};
            write_q <= {(BITS+1){1'b0}};
            read_q  <= {(BITS+1){1'b0}};
            o_valid <= 1'b0;
        end else begin
            if (i_take_back) write_q <= kept_q;
            else if (i_push) write_q <= write_q + 1'b1;
            if (i_keep) kept_q <= write_q;
            read_q  <= read_d;
            o_valid <= read_d != kept_q;  // the kept entry was written at least one clock ago
        end
    end

`ifdef FORMAL
    reg f_reset_seen_q;
    initial f_reset_seen_q = 1'b0;
    // Any one place: what was pushed there is what comes out, when its turn comes.
`ifdef FORMAL_LIVE_FIFO
    (* anyconst *) wire [BITS:0] f_place;
`else
    wire [BITS:0] f_place = {(BITS+1){1'b0}};
`endif
    reg [31:0]    f_entry_q;
    wire [BITS:0] f_ahead = f_place - read_q;  // entries before it
    always @(posedge clk) begin
        f_reset_seen_q <= f_reset_seen_q || rst;
        if (i_push && write_q == f_place) f_entry_q <= i_entry;
        if (f_reset_seen_q && !rst && !i_clear) begin
`ifdef FORMAL_LIVE_FIFO
            assume (!i_push || o_free != 16'd0);
            assume (!i_push || (!i_keep && !i_take_back));
            assume (!i_keep || !i_take_back);
`else
            assert (!i_push || o_free != 16'd0);
            assert (!i_push || (!i_keep && !i_take_back));
            assert (!i_keep || !i_take_back);
`endif
        end
        if (f_reset_seen_q) begin
            assert (used <= PLACES[BITS:0] && level <= used);
            assert (!o_valid || level != {(BITS+1){1'b0}});
            if (f_ahead < used) assert (entries[f_place[BITS-1:0]] == f_entry_q);
            if (o_valid) assert (o_entry == entries[read_q[BITS-1:0]]);
            if (o_valid && read_q == f_place) assert (o_entry == f_entry_q);
            // A provisional entry is never read; keeping shows it, taking back removes it, in the next clock.
            if ($past(rst || i_clear)) begin
                assert (used == 0 && !o_valid);
            end else begin
                if ($past(o_valid && !i_take)) begin assert (o_valid && o_entry == $past(o_entry)); end
                assert (read_q == $past(read_q) + {{BITS{1'b0}}, $past(o_valid && i_take)});
                assert (write_q == $past(i_take_back ? kept_q : write_q) + {{BITS{1'b0}}, $past(i_push)});
                assert (kept_q == $past(i_keep ? write_q : kept_q));
                if ($past(level != 0 && !i_take)) assert (o_valid);
            end
            cover (o_valid && i_take && read_q == f_place && level == PLACES[BITS:0]);
            cover (i_take_back && o_free == 16'd0 && level != 0 && !rst && !i_clear);
            cover (o_valid && o_entry != 0 && $past(i_take) && $past(o_valid));
        end
    end
`endif
endmodule
`default_nettype wire
