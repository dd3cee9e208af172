// SPDX-License-Identifier: Apache-2.0
//
// Collects one frame, encodes it by COBS, and then sends it to the UART with a zero byte at its end.
//
// A COBS code byte says how far away the next zero is, which is only known when that zero comes. So the frame is written into
// memory with a place kept open for each code byte, which is filled in when its run of bytes ends. Both sides are valid/ready
// streams; i_last marks the frame's last byte. o_ready stays low from then until the whole frame has been sent.
// BYTES is the size of that memory: a power of two, more than the longest frame with its CRC, one byte in 254, and 2.
`default_nettype none
module cobs_encoder #(
    parameter BYTES = 256
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_valid,
    output wire       o_ready,
    input  wire [7:0] i_byte,
    input  wire       i_last,
    output reg        o_valid,
    input  wire       i_ready,
    output reg  [7:0] o_byte
);
    localparam BITS = $clog2(BYTES);
    localparam [BITS-1:0] ONE = {{(BITS-1){1'b0}}, 1'b1};
    localparam [1:0] COLLECT = 2'd0, CLOSE_RUN = 2'd1, DELIMIT = 2'd2, SEND = 2'd3;

    (* no_rw_check *) reg [7:0] frame [0:BYTES-1];  // a frame is written or sent, never both in one clock
    reg [1:0]      state_q;
    reg            last_q;   // the frame is complete
    reg [BITS-1:0] code_q;   // place kept for the present run's code byte
    reg [BITS-1:0] place_q;  // next free place
    reg [7:0]      run_q;    // the code byte so far: data bytes in this run + 1
    reg [BITS-1:0] read_q;

    assign o_ready = state_q == COLLECT;
    wire take      = i_valid && o_ready;
    wire is_zero   = i_byte == 8'd0;
    wire close     = state_q == CLOSE_RUN || (take && is_zero);

    wire            write   = take || state_q == CLOSE_RUN || state_q == DELIMIT;
    wire [BITS-1:0] address = close ? code_q : place_q;
    wire [7:0]      value   = close ? run_q : state_q == DELIMIT ? 8'd0 : i_byte;
    wire [BITS-1:0] read_d  = read_q + {{(BITS-1){1'b0}}, o_valid && i_ready};

    always @(posedge clk) begin
        if (write) frame[address] <= value;
        o_byte <= frame[read_d];
    end

    always @(posedge clk) begin
        if (rst) begin
            state_q <= COLLECT;
            o_valid <= 1'b0;
            code_q  <= {BITS{1'b0}};
            place_q <= ONE;
            run_q   <= 8'd1;
            read_q  <= {BITS{1'b0}};
        end else case (state_q)
            COLLECT: if (take) begin
                last_q  <= i_last;
                place_q <= place_q + ONE;
                run_q   <= is_zero ? 8'd1 : run_q + 1'b1;
                if (is_zero) code_q <= place_q;
                if (i_last || (!is_zero && run_q == 8'd254)) state_q <= CLOSE_RUN;
            end
            CLOSE_RUN: begin
                run_q   <= 8'd1;
                state_q <= last_q ? DELIMIT : COLLECT;
                if (!last_q) begin
                    code_q  <= place_q;
                    place_q <= place_q + ONE;
                end
            end
            DELIMIT: state_q <= SEND;
            default: begin
                read_q  <= read_d;
                o_valid <= !(o_valid && i_ready && read_q == place_q);
                if (o_valid && i_ready && read_q == place_q) begin
                    state_q <= COLLECT;
                    code_q  <= {BITS{1'b0}};
                    place_q <= ONE;
                    read_q  <= {BITS{1'b0}};
                end
            end
        endcase
    end

`ifdef FORMAL
    `include "formal/cobs_encoder.vh"
`endif
endmodule
`default_nettype wire
