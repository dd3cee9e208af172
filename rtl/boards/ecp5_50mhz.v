// SPDX-License-Identifier: Apache-2.0
//
// Makes 50 MHz from a board's 25 MHz with the PLL of an ECP5: its oscillator runs at 600 MHz, divided by 12.
// With HG_SDRAM o_late has the same, a quarter of a period behind.
// o_locked is not synchronous to clk; power_on takes care of that.
`default_nettype none
module ecp5_50mhz (
    input  wire i_clk,
    output wire clk,
    output wire o_late,
    output wire o_locked
);
`ifndef HG_SDRAM
    assign o_late = 1'b0;
`endif
    (* FREQUENCY_PIN_CLKI = "25", FREQUENCY_PIN_CLKOP = "50", ICP_CURRENT = "12", LPF_RESISTOR = "8" *)
    EHXPLLL #(
        .CLKI_DIV(1), .CLKFB_DIV(2), .CLKOP_DIV(12), .CLKOP_CPHASE(11), .CLKOP_FPHASE(0), .CLKOP_ENABLE("ENABLED"),
        .FEEDBK_PATH("CLKOP"), .PLLRST_ENA("DISABLED"), .INTFB_WAKE("DISABLED"), .STDBY_ENABLE("DISABLED"),
`ifdef HG_SDRAM
        .CLKOS_ENABLE("ENABLED"), .CLKOS_DIV(12), .CLKOS_CPHASE(14), .CLKOS_FPHASE(0),
`endif
        .DPHASE_SOURCE("DISABLED"), .OUTDIVIDER_MUXA("DIVA"), .OUTDIVIDER_MUXB("DIVB"), .OUTDIVIDER_MUXC("DIVC"),
        .OUTDIVIDER_MUXD("DIVD")
    ) pll (
        .CLKI(i_clk), .CLKFB(clk), .CLKOP(clk),
`ifdef HG_SDRAM
        .CLKOS(o_late),
`endif
        .LOCK(o_locked), .RST(1'b0), .STDBY(1'b0), .PHASESEL0(1'b0), .PHASESEL1(1'b0),
        .PHASEDIR(1'b0), .PHASESTEP(1'b0), .PHASELOADREG(1'b0), .PLLWAKESYNC(1'b0), .ENCLKOP(1'b1));
endmodule
`default_nettype wire
