// SPDX-License-Identifier: Apache-2.0
//
// An SDRAM chip of 32 bits as a memory of runs: so many words from an address on, read or written without anything else in between.
//
// i_ask/o_take is a valid/take stream of runs. A read's words come in order, o_valid, at most one a clock, and cannot be held up. A
// write's present word is i_word; o_next takes it, and the next one must be there in the next clock. o_done comes with a run's last word. A
// read of n words is done n + 6 clocks after it was taken, n + 11 when it crosses into another row; before, it waits for FRESH_CLOCKS + 1 when
// a refresh is due. Those come between runs, so a run must be shorter than REFRESH_CLOCKS.
// The chip sees the pins a clock later, because a board has a register at each of them, and its own clock rises a quarter of a period behind
// clk. So a word comes three clocks behind the pins' READ, with a CAS latency of 2. CKE and CS are tied on and DQM to 0: only whole words
// are written.
// BANK_BITS is 2 for 4 banks · 2048 rows · 256 words, 8 MiB, and 1 for 4 MiB. The times are in clocks, each at least a data sheet's time in ns;
// those of rows, at least 2.
`default_nettype none
module sdram_controller #(
    parameter BANK_BITS      = 2,
    parameter COUNT_BITS     = 9,      // of a run's length
    parameter START_CLOCKS   = 10000,  // from power-up to the first command
    parameter REFRESH_CLOCKS = 360,    // from one refresh to the next
    parameter ROW_CLOCKS     = 2,      // tRCD and tRP
    parameter ACTIVE_CLOCKS  = 3,      // tRAS; with ROW_CLOCKS it makes tRC, too
    parameter FRESH_CLOCKS   = 4,      // tRFC
    parameter WRITTEN_CLOCKS = 2,      // tWR
    parameter FIRST_REFRESHES = 8,     // before the mode is set; less only makes proofs shorter
    parameter WORD_BITS      = BANK_BITS + 19  // follows
) (
    input  wire                  clk,
    input  wire                  rst,
    input  wire                  i_ask,
    input  wire                  i_write,
    input  wire [WORD_BITS-1:0]  i_first,  // address of the run's first word
    input  wire [COUNT_BITS-1:0] i_last,   // how many, less one
    output wire                  o_take,
    output wire                  o_next,
    input  wire [31:0]           i_word,
    output wire                  o_valid,
    output wire [31:0]           o_word,
    output wire                  o_done,
    output reg  [2:0]            o_command,  // RAS, CAS and WE, active low
    output reg  [BANK_BITS-1:0]  o_bank,
    output reg  [10:0]           o_address,
    output reg  [31:0]           o_data,
    output reg                   o_drive,    // the data pins
    input  wire [31:0]           i_data
);
    localparam [2:0] NOP = 3'b111, ACTIVATE = 3'b011, READ = 3'b101, WRITE = 3'b100, PRECHARGE = 3'b010, REFRESH = 3'b001, MODE = 3'b000;
    localparam [10:0] ALL_BANKS = 11'h400, SINGLE_WORDS = 11'h020;  // the latter: CAS latency 2, bursts of one word
    localparam [2:0] START = 3'd0, SET_UP = 3'd1, IDLE = 3'd2, OPEN = 3'd3, RUN = 3'd4, CLOSE = 3'd5;
    localparam START_BITS = $clog2(START_CLOCKS + 1), DUE_BITS = $clog2(REFRESH_CLOCKS + 1);
    localparam [3:0] ROW_REST = ROW_CLOCKS - 1, ACTIVE_REST = ACTIVE_CLOCKS - 1, FRESH_REST = FRESH_CLOCKS - 1, WRITTEN_REST = WRITTEN_CLOCKS - 1;

    generate
        if (ROW_CLOCKS < 2 || FRESH_CLOCKS < 2 || FRESH_CLOCKS > 15 || WRITTEN_CLOCKS < 1) sdram_times_out_of_range error();
        if (BANK_BITS < 1 || BANK_BITS > 2) bank_bits_out_of_range error();
    endgenerate

    reg [2:0]            state_q;
    reg [START_BITS-1:0] start_q;
    reg [DUE_BITS-1:0]   until_due_q;
    reg                  due_q;      // a refresh is
    reg [3:0]            set_up_q;   // refreshes that are still to come before the mode
    reg [3:0]            rest_q;     // clocks in which no command may follow
    reg [3:0]            open_q;     // clocks for which the row must stay open
    reg                  writes_q, goes_on_q;
    reg [WORD_BITS-1:0]  address_q;
    reg [COUNT_BITS-1:0] left_q;
    reg [3:0]            coming_q, ending_q;  // a word is on its way, and it is the last one
    wire [7:0]           column = address_q[7:0];
    wire [BANK_BITS-1:0] bank   = address_q[BANK_BITS+7:8];
    wire [10:0]          row    = address_q[BANK_BITS+18:BANK_BITS+8];
    wire                 rests  = rest_q != 4'd0;
    wire                 is_last = left_q == {COUNT_BITS{1'b0}};
    assign o_take  = state_q == IDLE && !rests && !due_q && i_ask && coming_q == 4'd0;
    assign o_next  = state_q == RUN && !rests && writes_q;
    assign o_valid = coming_q[3];
    assign o_word  = i_data;
    assign o_done  = ending_q[3] || (o_next && is_last);

    initial {state_q, o_command, o_drive} = {START, NOP, 1'b0};
    always @(posedge clk) begin
        o_command <= NOP;
        o_drive   <= writes_q && (state_q == OPEN || state_q == RUN);  // early, because a pin takes longer to turn round
        o_data    <= i_word;
        o_bank    <= bank;
        o_address <= {3'b000, column};
        if (rests) rest_q <= rest_q - 4'd1;
        if (open_q != 4'd0) open_q <= open_q - 4'd1;
        coming_q <= {coming_q[2:0], 1'b0};
        ending_q <= {ending_q[2:0], 1'b0};
        until_due_q <= until_due_q - 1'b1;
        if (until_due_q == {DUE_BITS{1'b0}}) {until_due_q, due_q} <= {REFRESH_CLOCKS[DUE_BITS-1:0] - 1'b1, 1'b1};
        start_q <= start_q - 1'b1;
        if (!rests) case (state_q)
            START: if (start_q == {START_BITS{1'b0}}) begin
                {o_command, o_address} <= {PRECHARGE, ALL_BANKS};
                {rest_q, set_up_q}     <= {ROW_REST, FIRST_REFRESHES[3:0]};
                state_q <= SET_UP;
            end
            SET_UP: begin
                {o_command, rest_q} <= {set_up_q == 4'd0 ? MODE : REFRESH, FRESH_REST};
                {o_address, o_bank} <= {SINGLE_WORDS, {BANK_BITS{1'b0}}};
                set_up_q <= set_up_q - 4'd1;
                if (set_up_q == 4'd0) state_q <= IDLE;
            end
            IDLE: if (due_q) begin
                {o_command, rest_q} <= {REFRESH, FRESH_REST};
                due_q <= 1'b0;
            end else if (o_take) begin
                {writes_q, address_q, left_q} <= {i_write, i_first, i_last};
                state_q <= OPEN;
            end
            OPEN: begin
                {o_command, o_address} <= {ACTIVATE, row};
                {rest_q, open_q}       <= {ROW_REST, ACTIVE_REST};
                state_q <= RUN;
            end
            RUN: begin
                o_command   <= writes_q ? WRITE : READ;
                coming_q[0] <= !writes_q;
                ending_q[0] <= !writes_q && is_last;
                address_q   <= address_q + 1'b1;
                left_q      <= left_q - 1'b1;
                goes_on_q   <= !is_last;
                if (writes_q && (is_last || column == 8'hff)) rest_q <= WRITTEN_REST;
                if (is_last || column == 8'hff) state_q <= CLOSE;
            end
            default: if (open_q == 4'd0) begin  // CLOSE
                {o_command, o_address} <= {PRECHARGE, ALL_BANKS};
                rest_q  <= ROW_REST;
                state_q <= goes_on_q ? OPEN : IDLE;
            end
        endcase
        if (rst) begin
            state_q <= START;
            start_q <= START_CLOCKS[START_BITS-1:0];
            {until_due_q, due_q} <= {REFRESH_CLOCKS[DUE_BITS-1:0] - 1'b1, 1'b0};
            {rest_q, open_q, coming_q, ending_q} <= 16'd0;
            {o_command, o_drive} <= {NOP, 1'b0};
        end
    end

`ifdef FORMAL
    `include "formal/sdram_controller.vh"
`endif
endmodule
`default_nettype wire
