// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace haptogram::sim {

/// The host's end of the line towards the board: 8N1 at exact baud timing, which need not be a whole number of clocks.
class SerialSender {
public:
    explicit SerialSender(double clocks_per_bit) : clocks_per_bit_(clocks_per_bit) {}

    void send(std::span<const std::uint8_t> bytes) { waiting_.insert(waiting_.end(), bytes.begin(), bytes.end()); }
    /// Level of the line at a clock; to be asked for every clock in turn, or at least when next_change() says.
    [[nodiscard]] bool level(std::uint64_t clock);
    /// The next clock, or one that has passed, from which on the level may be another one; the highest number: none.
    [[nodiscard]] std::uint64_t next_change() const { return idle() ? ~std::uint64_t{0} : next_change_; }
    [[nodiscard]] bool idle() const { return waiting_.empty() && bit_ == idle_bit; }
    /// Unplugs the cable: what was waiting, and the byte under way, are lost.
    void drop();

private:
    static constexpr int idle_bit = 10;
    double clocks_per_bit_;
    std::deque<std::uint8_t> waiting_;
    int bit_ = idle_bit;      // 0 start, 1…8 data, 9 stop
    unsigned frame_ = 0;      // the ten bits under way, first bit lowest
    double started_ = -1e18;  // clock of the present byte's start bit; long ago
    std::uint64_t next_change_ = 0;
    bool level_ = true;
};

/// The host's end of the line from the board: samples each bit in its middle.
class SerialReceiver {
public:
    explicit SerialReceiver(double clocks_per_bit) : clocks_per_bit_(clocks_per_bit) {}

    /// To be told every clock's level in turn; a byte when one is complete.
    std::optional<std::uint8_t> sample(std::uint64_t clock, bool level);

private:
    double clocks_per_bit_;
    bool last_level_ = true;
    int bit_ = -1;  // -1 idle
    unsigned shift_ = 0;
    double started_ = 0.0;
    std::uint64_t next_sample_ = 0;
};

}  // namespace haptogram::sim
