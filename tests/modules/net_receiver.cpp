// SPDX-License-Identifier: Apache-2.0
// Sends what comes from standard input to the byte side of the port's receiver, and writes to standard output what
// became of each piece.
//
// A piece is its length, the byte at which the PHY reports an error, or 0xffff, and the clocks of silence behind it, in
// 16, 16 and 32 bits, and its bytes, from the preamble on. What became of it is nine bytes (the counts' strobes with
// bit 5 for an answer; its kind, length and sum, and what was asked; how long the datagram is that was committed) and
// the datagram.
#include <Vnet_receiver_bench.h>
#include <verilated.h>

#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

VerilatedContext context;
Vnet_receiver_bench bench{&context};
unsigned flags = 0;
std::uint8_t answer[6] = {};
std::vector<std::uint8_t> coming, committed;

void clock(bool dv, std::uint8_t data, bool error) {
    bench.i_dv = dv;
    bench.i_data = data;
    bench.i_er = error;
    bench.clk = 1;
    bench.eval();
    bench.clk = 0;
    bench.eval();
    if (bench.o_write) coming.push_back(bench.o_byte);
    if (bench.o_commit) committed = coming;
    if (bench.o_commit || bench.o_drop) coming.clear();
    flags |= bench.o_counts;
    bench.i_answered = bench.o_answer && !bench.i_answered;
    if (!bench.i_answered) return;
    flags |= 1U << 5;
    answer[0] = bench.o_answer_kind;
    answer[1] = static_cast<std::uint8_t>(bench.o_answer_length);
    answer[2] = static_cast<std::uint8_t>(bench.o_answer_length >> 8);
    answer[3] = static_cast<std::uint8_t>(bench.o_answer_sum);
    answer[4] = static_cast<std::uint8_t>(bench.o_answer_sum >> 8);
    answer[5] = bench.o_asked;
}

}  // namespace

int main() {
    bench.rst = 1;
    for (int k = 0; k < 20; ++k) clock(false, 0, false);
    bench.rst = 0;
    for (int k = 0; k < 20; ++k) clock(false, 0, false);
    std::uint8_t head[8];
    std::vector<std::uint8_t> piece, out;
    while (std::fread(head, 1, sizeof head, stdin) == sizeof head) {
        const unsigned length = head[0] | head[1] << 8U, error = head[2] | head[3] << 8U;
        const std::uint32_t silence = head[4] | head[5] << 8U | head[6] << 16U | std::uint32_t{head[7]} << 24U;
        piece.resize(length);
        if (std::fread(piece.data(), 1, length, stdin) != length) return 2;
        flags = 0;
        committed.clear();
        for (std::uint8_t& byte : answer) byte = 0;
        for (unsigned k = 0; k < length; ++k) clock(true, piece[k], k == error);
        for (std::uint32_t k = 0; k < silence; ++k) clock(false, 0, false);
        out.assign({static_cast<std::uint8_t>(flags)});
        out.insert(out.end(), answer, answer + sizeof answer);
        out.push_back(static_cast<std::uint8_t>(committed.size()));
        out.push_back(static_cast<std::uint8_t>(committed.size() >> 8));
        out.insert(out.end(), committed.begin(), committed.end());
        std::fwrite(out.data(), 1, out.size(), stdout);
    }
    bench.final();
}
