// SPDX-License-Identifier: Apache-2.0
//
// A core that was never reset is given a reset of one clock: from then on no output is unknown, whatever its registers held.
`timescale 1ns/1ps
`default_nettype none
module short_reset;
    parameter WIDE = 0, MANY = 0;
    localparam CHANNELS = 16;
    reg clk = 1'b0, rst = 1'b0;
    always #10 clk = !clk;
    wire trigger, test, sync, tx, next, enabled, alive, playing, fault, cycle_start;
    wire [CHANNELS-1:0] pins;
    wire [15:0] index;
    haptogram_core #(
        .CHANNELS(CHANNELS), .RECORDS(40), .SEQUENCE_DEPTH(64), .LIVE_DEPTH(16), .TIMING_BITS(11), .WIDTH_BITS(WIDE ? 10 : 0),
        .MODULATION_DEPTH(WIDE ? 64 : 0), .SLEW(WIDE), .FOCI(WIDE ? 8 : 0), .SCHEDULE(MANY), .SYNC(MANY), .CHAIN(MANY), .TRIGGER(MANY)
    ) core (
        .clk(clk), .rst(rst), .i_rx(1'b1), .i_stop(1'b0), .i_sync(1'b0), .i_trigger(1'b0), .o_trigger(trigger), .o_test(test), .o_sync(sync), .o_tx(tx), .i_next(1'b1), .o_next(next),
        .i_net_valid(1'b0), .i_net_byte(8'd0), .i_net_old(3'd0), .i_net_lost(1'b0), .i_net_end(1'b0), .i_net_off(1'b0), .i_net_stop(1'b0), .o_net_off(), .o_net_valid(), .i_net_ready(1'b0), .o_net_byte(), .i_identity_place(5'd0), .o_identity_word(),
        .o_sdram_command(), .o_sdram_bank(), .o_sdram_address(), .o_sdram_data(), .o_sdram_drive(), .i_sdram_data(32'd0), .o_flash_cs_n(), .o_flash_clk(), .o_flash_data(), .i_flash_data(1'b1),
        .o_pins(pins),
        .o_enabled(enabled), .o_alive(alive), .o_playing(playing), .o_fault(fault), .o_index(index), .o_cycle_start(cycle_start));
    integer n;
    initial begin
        repeat (5) @(posedge clk);
        #5 rst = 1'b1;
        @(posedge clk);
        #5 rst = 1'b0;
        for (n = 0; n < 5000; n = n + 1) begin
            if (^{trigger, test, sync, tx, next, enabled, alive, playing, fault, cycle_start, pins, index} === 1'bx) begin
                $display("unknown %0d clocks after the reset: trigger %b test %b sync %b tx %b next %b enabled %b alive %b playing %b fault %b start %b pins %b index %b",
                         n, trigger, test, sync, tx, next, enabled, alive, playing, fault, cycle_start, pins, index);
                $finish(1);
            end
            @(posedge clk) #5;
        end
        $display("known");
        $finish(0);
    end
endmodule
`default_nettype wire
