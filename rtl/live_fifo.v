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
    `include "formal/live_fifo.vh"
`endif
endmodule
`default_nettype wire
