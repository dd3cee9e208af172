// SPDX-License-Identifier: Apache-2.0
//
// The pins of a gigabit PHY (RGMII 2.0) for the ECP5: two bits a clock at each pin, and GMII inside.
//
// clk, for both ways, is what the PHY receives with: 125 MHz at 1 Gbit/s. It may stand, or run slower, without such a link.
// RX_DELAY delays data and control against the clock, TX_DELAY the clock that goes out, both in steps of 25 ps, 0 to 127. The PHY is never
// reset, because its clock may be the board's.
`default_nettype none
module ecp5_rgmii #(
    parameter RX_DELAY = 80,
    parameter TX_DELAY = 0
) (
    input  wire       i_rx_clk,
    input  wire       i_rx_ctl,
    input  wire [3:0] i_rx,
    output wire       o_tx_clk,
    output wire       o_tx_ctl,
    output wire [3:0] o_tx,
    output wire       clk,
    output wire       o_dv,
    output wire       o_er,
    output wire [7:0] o_data,
    input  wire       i_en,
    input  wire [7:0] i_data
);
    assign clk = i_rx_clk;
    // Bit 4 is the control: valid with the rising edge, valid exclusive or error with the falling one.
    wire [4:0] at_pins = {i_rx_ctl, i_rx}, late, rising, falling, out;
    wire [4:0] out_rising = {i_en, i_data[3:0]}, out_falling = {i_en, i_data[7:4]};
    wire       clk_out;
    genvar k;
    generate
        for (k = 0; k < 5; k = k + 1) begin : pin
            DELAYG #(.DEL_MODE("USER_DEFINED"), .DEL_VALUE(RX_DELAY)) delay (.A(at_pins[k]), .Z(late[k]));
            IDDRX1F receives (.D(late[k]), .SCLK(clk), .RST(1'b0), .Q0(rising[k]), .Q1(falling[k]));
            ODDRX1F sends (.D0(out_rising[k]), .D1(out_falling[k]), .SCLK(clk), .RST(1'b0), .Q(out[k]));
        end
    endgenerate
    assign {o_dv, o_er, o_data} = {rising[4], rising[4] ^ falling[4], falling[3:0], rising[3:0]};
    assign {o_tx_ctl, o_tx} = out;
    ODDRX1F sends_clk (.D0(1'b1), .D1(1'b0), .SCLK(clk), .RST(1'b0), .Q(clk_out));
    DELAYG #(.DEL_MODE("USER_DEFINED"), .DEL_VALUE(TX_DELAY)) delays_clk (.A(clk_out), .Z(o_tx_clk));
endmodule
`default_nettype wire
