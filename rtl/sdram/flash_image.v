// SPDX-License-Identifier: Apache-2.0
//
// Reads an image out of the FPGA's flash (SPI, mode 0, command 03h), once after each reset, because an SDRAM holds nothing at power-up.
//
// At FIRST there are a zero, frames as a host sends them, and two more zeros; a single zero could also come from a frame whose first byte is
// damaged. Without a zero and a byte of a frame there is no image. The image's frames are checked as a host's are; i_failed says that one was
// damaged or refused, which ends the reading.
// o_valid strobes with a byte of the image, in place of a host's byte. A host's byte at i_valid (strobe) ends the reading, as does i_ends. If
// that cuts a frame, a zero takes the place of the host's byte: hosts begin with a zero.
// o_active: the module reads, or waits for the last frames. o_read strobes at the end of a whole image, when all of its frames have been carried
// out. o_state is `flash` of the status block. A byte takes 32 clocks. The chip's lines change three clocks before they are looked at, so they need
// no synchronizer. 2^WAIT_BITS · 4 clocks pass from reset to the first command, in which an SDRAM gets ready, and behind the last byte, in which
// waiting frames are carried out. 2^WAIT_BITS bytes without a zero are no frame.
`default_nettype none
`include "interface.vh"
module flash_image #(
    parameter [23:0] FIRST = `HG_FLASH_FIRST,
    parameter WAIT_BITS    = 12
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_valid,   // from a host
    input  wire       i_ends,    // strobe: a break or a STOP
    input  wire       i_failed,  // strobe
    output reg        o_active,
    output wire       o_valid,
    output wire [7:0] o_byte,
    output reg        o_read,    // strobe
    output reg  [1:0] o_state,
    output reg        o_cs_n,
    output wire       o_clk,
    output reg        o_data,
    input  wire       i_data
);
    localparam [1:0] WAIT = 2'd0, ASK = 2'd1, READ = 2'd2, SETTLE = 2'd3;
    localparam [31:0] COMMAND = {8'h03, FIRST};
    localparam [WAIT_BITS-1:0] ONE = 1;

    reg [1:0] state_q;
    reg [1:0] phase_q;   // of a bit: its upper bit is the chip's clock
    reg [4:0] bit_q;
    reg [7:0] byte_q;
    reg       valid_q;   // it is whole
    reg       begun_q;   // its first zero is here
    reg       some_q;    // and a byte of a frame
    reg       cut_q;     // a frame has begun and not ended
    reg       end_q;     // no frame is between the last two zeros, so another must follow
    reg       ends_q, failed_q;
    reg [WAIT_BITS-1:0] count_q;

    wire bit_ends = phase_q == 2'd3;
    wire full     = &count_q;
    wire is_zero  = byte_q == 8'd0;
    wire comes    = valid_q && o_active;
    wire no_image = comes && (begun_q ? is_zero && !some_q : !is_zero);
    wire empty    = comes && is_zero && !cut_q && some_q;
    wire last     = empty && end_q;
    wire no_end   = comes && !is_zero && end_q;
    wire quits    = o_active && !begun_q && (i_valid || ends_q);
    wire endless  = comes && begun_q && !is_zero && full;
    wire failed   = o_active && begun_q && (i_valid || ends_q || failed_q || endless || no_end);
    wire whole    = o_active && state_q == SETTLE && bit_ends && full && !failed;
    // A frame that was cut is ended by a zero, because what follows is no part of it.
    assign o_valid = o_active && !no_image && (comes || (failed && cut_q));
    assign o_byte  = failed ? 8'd0 : byte_q;
    assign o_clk   = phase_q[1];

    initial {o_active, o_cs_n, o_state} = {2'b01, `HG_FLASH_NONE};
    always @(posedge clk) begin
        phase_q <= o_active ? phase_q + 2'd1 : 2'd0;
        o_data  <= COMMAND[~bit_q];
        valid_q <= bit_ends && state_q == READ && bit_q[2:0] == 3'd7;
        o_read  <= whole && !rst;
        {ends_q, failed_q} <= {i_ends, i_failed};
        if (bit_ends) begin
            byte_q <= {byte_q[6:0], i_data};
            bit_q  <= bit_q + 5'd1;
            case (state_q)
                WAIT: begin
                    count_q <= count_q + ONE;
                    bit_q   <= 5'd0;
                    if (full) {state_q, o_cs_n} <= {ASK, 1'b0};
                end
                ASK:     if (bit_q == 5'd31) state_q <= READ;
                SETTLE:  count_q <= count_q + ONE;
                default: ;
            endcase
        end
        if (comes) begin
            cut_q   <= !is_zero;
            end_q   <= empty;
            count_q <= is_zero ? {WAIT_BITS{1'b0}} : count_q + ONE;
            begun_q <= 1'b1;
            some_q  <= some_q || (begun_q && !is_zero);
            if (last) {state_q, o_cs_n} <= {SETTLE, 1'b1};
        end
        if (whole) o_state <= `HG_FLASH_WHOLE;
        if (failed) o_state <= `HG_FLASH_BROKEN;
        if (whole || failed || no_image || quits) {o_active, o_cs_n} <= 2'b01;
        if (rst) begin
            {o_active, o_cs_n, o_state, state_q} <= {2'b11, `HG_FLASH_NONE, WAIT};
            {phase_q, valid_q, begun_q, some_q, cut_q, end_q} <= 7'd0;
            {count_q, bit_q} <= 0;
        end
    end
endmodule
`default_nettype wire
