// SPDX-License-Identifier: Apache-2.0
//
// Holds the indices that arrived over the link and wait to be played: a FIFO of (dwell, index).
//
// A frame may carry many indices, and a refused frame must push none. So i_push only adds provisionally; i_keep makes all pushed entries
// readable, and i_take_back removes them again. o_valid/i_take is the reading side; its data stays until it is taken. An entry can be read
// two clocks after i_keep at the latest. i_clear empties everything. i_mark with i_keep marks the kept entries: while i_closed is high,
// nothing from the first of them on is read.
// DEPTH is how many indices can wait: a power of two from 4 to 32768, so that its pointers wrap by themselves.
`default_nettype none
module live_fifo #(
    parameter DEPTH = 256
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_clear,
    input  wire        i_push,      // provisional until i_keep; only while o_free is not 0
    input  wire [31:0] i_entry,
    input  wire        i_keep,
    input  wire        i_take_back,
    input  wire        i_mark,
    input  wire        i_closed,
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

    (* no_rw_check *) reg [31:0] entries [0:DEPTH-1];  // an entry is never read in the clock in which it is written
    // The pointers have one bit more than an address, which tells a full FIFO from an empty one.
    reg [BITS:0] kept_q;   // after the last entry that may be read
    reg [BITS:0] write_q;  // after the last entry that has been pushed
    reg [BITS:0] read_q;
    reg [BITS:0] mark_q;   // the first entry that must wait

    wire [BITS:0] read_d = read_q + {{BITS{1'b0}}, o_valid && i_take};
    wire [BITS:0] level  = kept_q - read_q;
    wire [BITS:0] used   = write_q - read_q;
    assign o_level = {{(15-BITS){1'b0}}, level};
    assign o_free  = {{(15-BITS){1'b0}}, PLACES[BITS:0] - used};

    always @(posedge clk) begin
        if (i_mark) mark_q <= kept_q;
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
            o_valid <= read_d != (i_closed ? mark_q : kept_q);  // so an entry is read one clock after it was written, or later
        end
    end

`ifdef FORMAL
    `include "formal/live_fifo.vh"
`endif
endmodule
`default_nettype wire
