// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"
#include "port_bytes.hpp"
#include "serial_line.hpp"

namespace haptogram::sim {

/// A byte on the board's serial line has 10 bits; the board counts them with a phase of 20 bits, so that its bits are a
/// whole number of clocks, and on average of the right length.
struct BitClock {
    explicit BitClock(const interface::CoreParameters& p);
    std::array<Clock, 11> middle{};  ///< of bit 0 (start) to 9 (stop), in clocks from the beginning of the start bit
    std::array<Clock, 11> begin{};   ///< of these bits when sent, and the end of the last one
    Clock break_clocks;              ///< for so long no line that carries bytes is low
    double host_clocks;              ///< of a bit at the host's end, which is exact
};

/// Receives bytes from a line whose changes it is told (rtl/uart_rx.v).
class ByteInput {
public:
    explicit ByteInput(const BitClock& bits) : bits_(bits) {}

    /// The line's level from this clock on.
    void level(Clock clock, bool level);
    [[nodiscard]] bool level() const { return level_; }
    void reset();
    /// The clock in which the next bit is read.
    [[nodiscard]] Clock next() const { return sample_at_; }
    [[nodiscard]] bool idle() const { return sample_at_ == never; }
    /// When the byte began that is coming, or came last.
    [[nodiscard]] Clock started() const { return started_; }
    struct Sample {
        std::size_t bit = 0;  ///< 0 start, 9 stop
        bool level = false;
    };
    /// Reads the bit of this clock.
    [[nodiscard]] Sample sample();
    /// After a stop bit.
    [[nodiscard]] std::uint8_t byte() const { return byte_; }

private:
    const BitClock& bits_;
    bool level_ = true;
    std::size_t bit_ = 0;  // the one that is read next
    Clock started_ = 0, sample_at_ = never;
    std::uint8_t byte_ = 0;
};

/// What a tile of a chain lets its own receiver see of the line (rtl/time/chain_down.v). Nothing is behind it here.
class ChainFilter {
public:
    void reset() { *this = {}; }
    /// A bit was read of the line that all tiles share. @return whether it ended a frame that begins the chain
    [[nodiscard]] bool read(const ByteInput::Sample& sample, std::uint8_t byte);
    /// The line is high between bytes.
    void rest() { own_ = true; }
    /// As the tile's own receiver sees it from the next clock on, in a chain.
    [[nodiscard]] bool own() const { return own_; }
    /// Whether a frame has begun.
    [[nodiscard]] bool begun() const { return place_ != 0; }

private:
    unsigned place_ = 0;  // the byte of the frame that comes, up to 3
    bool own_ = true, counts_ = false, near_ = false, mine_ = false;
};

/// The line towards the board: the host's sender, or what holds the line, and what the board makes of it.
class LineIn {
public:
    explicit LineIn(const interface::CoreParameters& p)
        : bits_(p),
          has_chain_(p.chain != 0),
          has_net_(p.net != 0),
          sender_(bits_.host_clocks),
          shared_(bits_),
          own_(bits_) {}
    LineIn(const LineIn&) = delete;
    LineIn& operator=(const LineIn&) = delete;

    void send(std::span<const std::uint8_t> bytes);
    [[nodiscard]] bool idle() const { return sender_.idle() && net_.empty(); }
    /// In this clock, of a board with a network port.
    void break_network(Clock now) { net_break_at_ = has_net_ ? now : never; }
    void stop_network(Clock now) { net_stop_at_ = has_net_ ? now : never; }
    void lose_network(Clock now) { net_lost_at_ = has_net_ ? now : never; }
    void end_network(Clock now) { net_end_at_ = has_net_ ? now : never; }
    /// What waits in a network port is old.
    void mark(PortBytes::Event event) { net_.mark(event); }
    /// When the byte began to arrive that is coming in this clock, or is on its way to the board.
    [[nodiscard]] std::optional<Clock> coming() const;
    /// From this clock on.
    void force(Clock now, std::optional<bool> level);
    void unplug(Clock now);
    /// The board's reset ends with this clock. Until then it sees an idle line.
    void reset(Clock last);

    /// The next clock in which something may happen, unless the host does something before.
    [[nodiscard]] Clock next() const;
    struct Event {
        std::optional<std::uint8_t> byte;  ///< its good stop bit was seen three clocks ago
        bool broken = false;               ///< the line has been low for too long
        bool stops = false;                ///< a STOP came beside it
        bool lost = false;                 ///< the link of a network port was lost
        bool ends = false;                 ///< the session ends
        std::uint8_t old = 0;              ///< of what comes from a network port: see PortBytes
        Clock began = never;               ///< when the byte did, on a serial line
        std::optional<bool> chained;       ///< from this clock on the board is one of a chain, or is not
    };
    /// What the board learns in this clock; to be asked at every clock that next() says, in turn.
    Event at(Clock clock);

private:
    Event at_network(Clock clock);
    void level_is(Clock clock, bool level);
    void read_shared(Clock clock);

    BitClock bits_;
    bool has_chain_, has_net_;
    SerialSender sender_;
    std::optional<bool> forced_;
    // Bytes of a network port wait there for the end of a reset, and then for each other.
    PortBytes net_;
    Clock net_from_ = 0, net_break_at_ = never, net_stop_at_ = never, net_lost_at_ = never, net_end_at_ = never;
    Clock ask_at_ = 0;  // the host has done something
    // The board's side. Clocks are those at the pin, which the board sees two later.
    Clock deaf_to_ = 0;  // last clock of reset
    bool level_ = true;
    bool connected_ = false;  // the line has been high since reset; otherwise no cable is there, and a low is no break
    Clock low_since_ = 0, break_at_ = never;
    ByteInput shared_, own_;  // of a chain; what the board takes its bytes from
    Clock byte_at_ = never, byte_began_ = never;
    std::uint8_t byte_ = 0;
    ChainFilter filter_;
    Clock head_at_ = never;  // a frame of a chain began, of which the own receiver may see nothing yet
    bool chained_ = false;
    Clock chains_at_ = never, unchains_at_ = never;             // as the filter sees it
    Clock tells_chain_at_ = never, tells_no_chain_at_ = never;  // as all others do
    Clock look_at_ = never;                                     // the own line may have changed
};

/// The line from the board: frames as bytes with their clocks at the host's end.
class LineOut {
public:
    explicit LineOut(const interface::CoreParameters& p) : bits_(p), has_net_(p.net != 0) {}

    /// The board collects a reply byte by byte, one a clock, and sends it when it is whole. A byte that is offered from
    /// this clock on is taken in the clock that is returned.
    Clock collect(Clock offered, std::uint8_t byte);
    /// The last two bytes, which are the reply's CRC, follow. From here on nothing can be collected until all is sent.
    void close(Clock offered);
    /// The board's reset begins: what has not been sent is lost, and the byte under way is cut off.
    void reset(Clock clock);
    /// From this clock on the board is one of a chain, or is not: two bytes that say whose it is go before each frame.
    /// A frame that has been begun while another one was on the line keeps the clocks it was given.
    void chain(Clock clock, bool chained);

    [[nodiscard]] Clock next() const { return sent_.empty() ? never : sent_.front().arrives; }
    /// The byte that arrives at the host in next().
    std::uint8_t arrive();
    /// Level of the line after this clock, the last one that was run.
    [[nodiscard]] bool level(Clock clock) const;

private:
    struct Sent {
        Clock begin, arrives;
        std::uint8_t byte;
        bool heads = false;  // before a frame, not of it
    };
    void send(Clock begin, std::uint8_t byte, bool heads);
    void plan(Clock ready, std::span<const std::uint8_t> line);

    BitClock bits_;
    bool has_net_, chained_ = false;
    Clock ready_ = 0;  // from which on the encoder has the present frame for the line
    std::vector<std::uint8_t> frame_;
    unsigned run_ = 1;          // bytes since the last zero, and one; COBS needs a clock more after 254 of them
    Clock collects_from_ = 0;   // the encoder has room
    Clock sends_from_ = 0;      // the line is free
    std::deque<Sent> sent_;     // those that have not arrived
    std::optional<Sent> last_;  // that has arrived
    Clock silent_from_ = never;
};

}  // namespace haptogram::sim
