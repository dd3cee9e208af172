// SPDX-License-Identifier: Apache-2.0
//
// The pins of an SDRAM of 32 bits for the ECP5: a register in each I/O cell, as sdram_controller expects them, and the chip's clock.
//
// i_late is a quarter of a period behind clk, and so is the chip's clock, which leaves through a cell like the others. Who drives the data pins is
// said by a register in the fabric: sdram_controller says so early enough.
`default_nettype none
module ecp5_sdram #(
    parameter BANK_BITS = 1
) (
    input  wire                 clk,
    input  wire                 i_late,
    input  wire [2:0]           i_command,
    input  wire [BANK_BITS-1:0] i_bank,
    input  wire [10:0]          i_address,
    input  wire [31:0]          i_data,
    input  wire                 i_drive,
    output wire [31:0]          o_data,
    output wire                 o_clk,
    output wire                 o_ras_n,
    output wire                 o_cas_n,
    output wire                 o_we_n,
    output wire [BANK_BITS-1:0] o_bank,
    output wire [10:0]          o_address,
    inout  wire [31:0]          io_data
);
    localparam OUTPUTS = BANK_BITS + 46;
    wire [OUTPUTS-1:0] from = {i_command, i_bank, i_address, i_data}, at_pins;
    wire [31:0]        data, arrives;
    assign {o_ras_n, o_cas_n, o_we_n, o_bank, o_address, data} = at_pins;
    reg drive_q;
    initial drive_q = 1'b0;
    always @(posedge clk) drive_q <= i_drive;
    genvar k;
    generate
        for (k = 0; k < OUTPUTS; k = k + 1) begin : sends
            OFS1P3DX cell_of (.D(from[k]), .SP(1'b1), .SCLK(clk), .CD(1'b0), .Q(at_pins[k]));
        end
        for (k = 0; k < 32; k = k + 1) begin : data_pin
            BB pad (.I(data[k]), .T(!drive_q), .O(arrives[k]), .B(io_data[k]));
            IFS1P3DX receives (.D(arrives[k]), .SP(1'b1), .SCLK(clk), .CD(1'b0), .Q(o_data[k]));
        end
    endgenerate
    ODDRX1F sends_clk (.D0(1'b1), .D1(1'b0), .SCLK(i_late), .RST(1'b0), .Q(o_clk));
endmodule
`default_nettype wire
