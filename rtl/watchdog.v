// SPDX-License-Identifier: Apache-2.0
//
// Strobes o_expired when outputs are enabled and no frame has been accepted for i_milliseconds. So a host that has died, or a
// cable that was pulled, cannot leave the ultrasound on.
//
// i_kick starts the time anew. i_set takes a new time; 0 turns the watchdog off. The strobe comes one clock after the time is
// up.
// CLOCK_HZ (2 kHz to 1 GHz) says how long a millisecond is. DEFAULT_MS (0 to 65535) holds after reset.
`default_nettype none
module watchdog #(
    parameter CLOCK_HZ   = 50000000,
    parameter DEFAULT_MS = 500
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_running,  // the outputs are enabled
    input  wire        i_kick,
    input  wire        i_set,
    input  wire [15:0] i_milliseconds,
    output reg  [15:0] o_milliseconds,
    output reg         o_expired
);
    localparam CLOCKS_PER_MS = CLOCK_HZ / 1000;
    localparam CLOCK_BITS = $clog2(CLOCKS_PER_MS);
    localparam [CLOCK_BITS-1:0] LAST_CLOCK = CLOCKS_PER_MS[CLOCK_BITS-1:0] - 1'b1;
    localparam [15:0] DEFAULT = DEFAULT_MS[15:0];

    generate
        if (CLOCKS_PER_MS < 2 || CLOCKS_PER_MS > 1000000) clock_hz_out_of_range error();
    endgenerate

    reg [CLOCK_BITS-1:0] clock_q;
    reg [15:0] left_q;
    wire millisecond_ends = clock_q == LAST_CLOCK;

    always @(posedge clk) begin
        o_expired <= 1'b0;
        if (rst) begin
            o_milliseconds <= DEFAULT;
            left_q         <= DEFAULT;
            clock_q        <= {CLOCK_BITS{1'b0}};
        end else if (i_set || i_kick || !i_running || o_milliseconds == 16'd0) begin
            if (i_set) o_milliseconds <= i_milliseconds;
            left_q  <= i_set ? i_milliseconds : o_milliseconds;
            clock_q <= {CLOCK_BITS{1'b0}};
        end else if (millisecond_ends) begin
            clock_q   <= {CLOCK_BITS{1'b0}};
            left_q    <= left_q - 1'b1;
            o_expired <= left_q == 16'd1;
        end else clock_q <= clock_q + 1'b1;
    end

`ifdef FORMAL
    `include "formal/watchdog.vh"
`endif
endmodule
`default_nettype wire
