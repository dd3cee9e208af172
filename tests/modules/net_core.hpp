// SPDX-License-Identifier: Apache-2.0
// The instrument behind its Ethernet port (net_core_bench.v), its host, and the time between them.
#pragma once
#include <Vnet_core_bench.h>

#include <deque>
#include <functional>
#include <initializer_list>
#include <span>
#include <utility>

#include "bench.hpp"
#include "haptogram/format/interface.hpp"
#include "haptogram/link/frame.hpp"
#include "net_frames.hpp"
#include "sdram_chip.hpp"

namespace net {

using haptogram::interface::Command;
namespace link = haptogram::link;

constexpr long half_eth_ps = 4000, half_clk_ps = 10003;
constexpr unsigned channels = PARAMETER_CHANNELS, records = PARAMETER_RECORDS;
constexpr unsigned record_words = channels + haptogram::interface::record_header_words;
constexpr bool has_sdram = PARAMETER_SDRAM != 0;

/// The board, its host, and the time between them in nanoseconds.
class Network {
public:
    Bench<Vnet_core_bench> bench;
    std::vector<unsigned> played;  ///< the index of each carrier period that began, with outputs on
    std::vector<link::Reply> replies;
    double now_ns = 0;
    std::uint8_t phy_status = 0xdd;  ///< what the PHY tells between frames: a link of 1 Gbit/s
    bool clock_runs = true;          ///< the PHY's; what comes while it does not waits for it
    bool clock_stopped = false;      ///< it has
    std::deque<double> begun;        ///< when the first bit of each frame came that was sent since it was cleared
    std::deque<double> ended;        ///< and when its last byte had come
    bool rests = false;  ///< the PHY's clock is slow while nothing comes in: quicker, but answers are late then
    std::function<void()> before_clock = [] {};  ///< what is looked at before each rising edge of the core's clock

    Network() {
        bench->eth_clk = bench->i_dv = bench->i_data = bench->i_stop = 0;
        if (has_sdram) chip_.scramble(static_cast<std::uint32_t>(bench.random()));
        run(2000);
        bench->rst = 0;
        listens_ = true;  // what was sent before was what its registers held at power-up
        frame_.clear();
        run(5000);
    }

    void send(const Address& from, const Bytes& payload, unsigned port = board.port) {
        send_frame(whole(udp_frame(from, with_port(board, port), payload)));
    }
    void send_frame(const Bytes& frame) {
        const Bytes preamble = {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0xd5};
        line_.insert(line_.end(), preamble.begin(), preamble.end());
        line_.insert(line_.end(), frame.begin(), frame.end());
        ends_.push_back(preamble.size() + frame.size());
    }
    Bytes frame(Command command, const Bytes& payload = {}) {
        return link::encode_request(number_++, command, payload);
    }
    /// As a host sends again what was not answered.
    [[nodiscard]] static Bytes again(unsigned number, Command command, const Bytes& payload = {}) {
        return link::encode_request(static_cast<std::uint8_t>(number), command, payload);
    }

    /// Frames one behind the other, which a sum of two calls would not promise.
    Bytes frames(std::initializer_list<Command> commands) {
        Bytes all;
        for (const Command command : commands) all = all + frame(command);
        return all;
    }

    void run(double ns) {
        for (const double end = now_ns + ns; now_ns < end; now_ns = 1e-3 * static_cast<double>(time_ps_)) step();
    }
    /// Until so many answers have come; false after a millisecond.
    bool answered(std::size_t count) {
        for (const double end = now_ns + 1e6; replies.size() < count && now_ns < end;) run(1000);
        return replies.size() >= count;
    }

    [[nodiscard]] unsigned next_number() const { return number_; }
    [[nodiscard]] std::size_t frames_left() const { return ends_.size(); }

private:
    void step() {
        while (next_clk_ps_ <= time_ps_) core_edge();
        if (!clock_runs) {
            clock_stopped = true;
            time_ps_ += half_eth_ps;
            return;
        }
        const bool rises = !bench->eth_clk;
        if (rises) {
            if (bench->o_en)
                frame_.push_back(bench->o_data);
            else if (!frame_.empty())
                heard(std::exchange(frame_, {}));
        }
        bench->eth_clk = rises;
        bench->eval();
        if (rises) drive();
        const bool quiet = rests && line_.empty() && time_ps_ > active_ps_ + 2'000'000;
        time_ps_ += quiet ? 5 * half_eth_ps : half_eth_ps;
    }
    void drive() {
        const bool sends = gap_ == 0 && !line_.empty();
        bench->i_dv = sends;
        if (gap_ > 0) --gap_;
        if (!sends) bench->i_data = phy_status;
        if (sends) {
            active_ps_ = time_ps_;
            if (!coming_) begun.push_back(1e-3 * static_cast<double>(time_ps_));
            coming_ = true;
            bench->i_data = line_.front();
            line_.pop_front();
            if (--ends_.front() == 0) {
                ends_.pop_front();
                gap_ = 12;
                coming_ = false;
                ended.push_back(1e-3 * static_cast<double>(time_ps_));
            }
        }
        bench->eval();
    }
    void core_edge() {
        next_clk_ps_ += half_clk_ps;
        const bool rises = !bench->clk;
        if (rises) {
            if (bench->o_cycle_start && bench->o_enabled) played.push_back(bench->o_index);
            before_clock();
        } else {
            bench->i_sdram_data = chip_.word();
        }
        bench->clk = rises;
        bench->eval();
        if (has_sdram && rises)
            chip_.clock({bench->o_sdram_command, bench->o_sdram_bank, bench->o_sdram_address, bench->o_sdram_data,
                         bench->o_sdram_drive != 0});
    }
    void heard(const Bytes& sent) {
        if (listens_ && sent.size() > 12) take(sent);
    }
    void take(const Bytes& sent) {
        const Bytes body = cut(sent, 8, sent.size() - 4);
        const bool whole = fcs(body) == cut(sent, sent.size() - 4, sent.size());
        if (clock_stopped && !whole) return;  // cut by that
        REQUIRE(whole);
        if (at(body, 12) == 0x0800 && body[23] == 17 && at(body, 34) == board.port)
            decoder_.feed(cut(body, 42, 14 + at(body, 16)), replies);
    }

    haptogram::sim::SdramChip chip_{PARAMETER_SDRAM};
    long time_ps_ = 0, next_clk_ps_ = 5003, gap_ = 0, active_ps_ = 0;
    std::deque<std::uint8_t> line_;
    std::deque<std::size_t> ends_;
    bool listens_ = false, coming_ = false;
    Bytes frame_;
    link::ReplyDecoder decoder_;
    std::uint8_t number_ = 7;
};

inline Bytes words(std::span<const std::uint16_t> values) {
    Bytes bytes;
    for (const std::uint16_t value : values) bytes = bytes + little(value);
    return bytes;
}

}  // namespace net
