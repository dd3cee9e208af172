// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "haptogram/format/interface.hpp"

namespace haptogram::link {
namespace {

using interface::chain::all;
using interface::chain::most_tiles;
constexpr std::size_t header_bytes = 2;
// A line that never sends a zero, or a tile that nobody listens to any more, must not fill the memory.
constexpr std::size_t longest_frame = 1 << 13, most_unread = 1 << 18;
// Whoever waits for one tile must not keep those who write to another waiting for longer than this.
constexpr std::chrono::microseconds longest_look{2000};

/// What stands before a frame. @param first  its first byte: for a tile 2n + 1, or `all`
constexpr std::array<std::uint8_t, header_bytes> header(unsigned first) {
    return {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>((~first & 0xFEU) | 1U)};
}

/// A frame of nothing for all: a tile that has not heard it yet keeps it, so each further one needs one more.
std::vector<std::uint8_t> greeting(unsigned number) {
    std::vector<std::uint8_t> bytes{0};
    for (unsigned i = 0; i < number; ++i) {
        const auto empty = header(all);
        bytes.insert(bytes.end(), empty.begin(), empty.end());
        bytes.push_back(0);
    }
    return bytes;
}

}  // namespace

template <class Work>
auto Chain::with_port(Work&& work) {
    const std::lock_guard lock(mutex_);
    try {
        return work(port());
    } catch (const LinkLost&) {
        port_.reset();  // so that it can be opened anew
        throw;
    }
}

class Chain::Tile final : public Transport {
public:
    Tile(std::shared_ptr<Chain> chain, unsigned number, std::chrono::microseconds patience)
        : chain_(std::move(chain)), header_(header(2 * number + 1)), number_(number), patience_(patience) {}
    Tile(const Tile&) = delete;
    Tile& operator=(const Tile&) = delete;
    ~Tile() override { chain_->leave(number_); }

    void write(std::span<const std::uint8_t> bytes) override {
        std::vector<std::uint8_t> out;
        for (const std::uint8_t byte : bytes) {
            if (byte != 0 && !in_frame_) out.insert(out.end(), header_.begin(), header_.end());
            in_frame_ = byte != 0;
            out.push_back(byte);
        }
        chain_->write(out);
    }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        return chain_->read(number_, patience);
    }
    /// Takes back what is for other tiles, too; it is sent again, as all that is not answered.
    void discard_output() override {
        in_frame_ = false;
        chain_->with_port([](Transport& port) { port.discard_output(); });
    }
    /// Turns the outputs of all tiles off and ends the chain, which is begun anew for what comes next.
    void send_break() override {
        in_frame_ = false;
        chain_->with_port([&](Transport& port) {
            port.send_break();
            port.write(greeting(number_));
        });
    }
    void set_interrupt(const Interrupt& interrupt) override {
        chain_->with_port([&](Transport& port) { port.set_interrupt(interrupt); });
    }
    [[nodiscard]] Clock& clock() override {
        return *chain_->with_port([](Transport& port) { return &port.clock(); });
    }
    [[nodiscard]] std::chrono::microseconds patience() const override { return patience_; }

private:
    std::shared_ptr<Chain> chain_;
    std::array<std::uint8_t, header_bytes> header_;
    unsigned number_;
    std::chrono::microseconds patience_;
    bool in_frame_ = false;
};

Transport& Chain::port() {
    if (!port_) throw LinkLost("chain", "the port is gone");
    return *port_;
}

bool Chain::lost() const {
    const std::lock_guard lock(mutex_);
    return port_ == nullptr;
}

std::unique_ptr<Transport> Chain::tile(unsigned number) {
    const auto patience = with_port([&](Transport& port) {
        if (arrived_.contains(number))
            throw Error(ErrorCode::device, fmt::format("tile {} of the chain", number), "it is in use already");
        port.write(greeting(number));
        arrived_[number];
        return port.patience();
    });
    return std::make_unique<Tile>(shared_from_this(), number, patience);
}

void Chain::leave(unsigned number) {
    const std::lock_guard lock(mutex_);
    arrived_.erase(number);
}

void Chain::write(std::span<const std::uint8_t> bytes) {
    with_port([&](Transport& port) { port.write(bytes); });
}

std::vector<std::uint8_t> Chain::read(unsigned number, std::chrono::microseconds patience) {
    for (;;) {
        std::chrono::microseconds passed = std::min(patience, longest_look);
        auto mine = with_port([&](Transport& port) {
            if (arrived_[number].empty()) {
                const auto bytes = port.read(passed);
                // Less time has passed when something came. A byte takes some microseconds; noise must come to an end.
                if (!bytes.empty()) passed = std::chrono::microseconds(bytes.size());
                sort(bytes);
            }
            return std::exchange(arrived_[number], {});
        });
        patience -= passed;
        if (!mine.empty() || patience <= std::chrono::microseconds(0)) return mine;
    }
}

/// Keeps each tile's answers for its transport. Drops frames without a header, or with a damaged one.
void Chain::sort(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
        if (frame_.size() < longest_frame || byte == 0) frame_.push_back(byte);
        if (byte != 0) continue;
        const std::vector<std::uint8_t> frame = std::exchange(frame_, {});
        if (frame.size() <= header_bytes + 1 || frame[0] % 2 == 0 || frame[1] != header(frame[0])[1]) continue;
        const auto tile = arrived_.find(frame[0] / 2);
        if (tile != arrived_.end() && tile->second.size() < most_unread)
            tile->second.insert(tile->second.end(), frame.begin() + header_bytes, frame.end());
    }
}

std::optional<ChainedPort> chained_port(const std::string& name) {
    const std::size_t at = name.rfind('#');
    if (at == std::string::npos || at == 0 || at + 1 == name.size() ||
        name.find_first_not_of("0123456789", at + 1) != std::string::npos)
        return {};
    ChainedPort port{name.substr(0, at), 0};
    const char* const end = name.data() + name.size();
    const auto [last, error] = std::from_chars(name.data() + at + 1, end, port.tile);
    if (error != std::errc() || last != end || port.tile < 1 || port.tile > most_tiles || chained_port(port.port))
        throw Error(
            ErrorCode::bad_argument, name,
            fmt::format("behind the port, one # and the number of a tile are expected, from 1 to {}", most_tiles));
    return port;
}

std::string name_of(const ChainedPort& port) { return fmt::format("{}#{}", port.port, port.tile); }

}  // namespace haptogram::link
