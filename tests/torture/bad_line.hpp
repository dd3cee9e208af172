// SPDX-License-Identifier: Apache-2.0
// Lines that treat bytes badly, between a client and a simulated board.
#pragma once
#include <random>

#include "haptogram/link/transport.hpp"

namespace haptogram::test {

/// What happens to a byte, as chances: of an error in each of the ten bits that it takes on the line, of being lost, of
/// arriving twice, and of waiting, with all behind it, until the other side speaks next.
struct Badness {
    double bit_errors = 0.0, lost = 0.0, doubled = 0.0, delayed = 0.0;
};

class BadLine final : public link::Transport {
public:
    BadLine(link::Transport& line, std::mt19937& g, const Badness& badness) : line_(line), g_(g), badness_(badness) {}

    void write(std::span<const std::uint8_t> bytes) override { line_.write(spoil(bytes, to_board_)); }
    std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        return spoil(line_.read(patience), to_host_);
    }
    [[nodiscard]] haptogram::link::Clock& clock() override { return line_.clock(); }
    [[nodiscard]] std::chrono::microseconds patience() const override { return line_.patience(); }
    [[nodiscard]] std::uint64_t carried() const { return carried_; }
    [[nodiscard]] std::uint64_t spoilt() const { return spoilt_; }

private:
    bool happens(double chance) {
        if (std::uniform_real_distribution<double>(0.0, 1.0)(g_) >= chance) return false;
        ++spoilt_;
        return true;
    }

    std::vector<std::uint8_t> spoil(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& waiting) {
        std::vector<std::uint8_t> out = std::exchange(waiting, {});
        bool waits = false;
        for (std::uint8_t byte : bytes) {
            ++carried_;
            // A start or stop bit in error costs the byte, and what the receiver makes of the next is no better than
            // noise.
            for (int bit = 0; bit < 10; ++bit)
                if (happens(badness_.bit_errors)) byte = static_cast<std::uint8_t>(bit < 8 ? byte ^ 1U << bit : g_());
            if (happens(badness_.lost)) continue;
            waits = waits || happens(badness_.delayed);
            auto& to = waits ? waiting : out;
            to.push_back(byte);
            if (happens(badness_.doubled)) to.push_back(byte);
        }
        return out;
    }

    link::Transport& line_;
    std::mt19937& g_;
    Badness badness_;
    std::vector<std::uint8_t> to_board_, to_host_;
    std::uint64_t carried_ = 0, spoilt_ = 0;
};

/// A line that is cut in the middle of whatever after so many bytes either way, as by an unplug or a kill -9.
class CuttableLine final : public link::Transport {
public:
    CuttableLine(link::Transport& line, std::uint64_t after) : line_(line), left_(after) {}

    void write(std::span<const std::uint8_t> bytes) override {
        line_.write(bytes.first(std::min<std::size_t>(bytes.size(), left_)));
        take(bytes.size());
    }
    std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        auto bytes = line_.read(patience);
        take(bytes.size());
        return bytes;
    }
    [[nodiscard]] haptogram::link::Clock& clock() override { return line_.clock(); }
    [[nodiscard]] std::chrono::microseconds patience() const override { return line_.patience(); }

private:
    void take(std::uint64_t bytes) {
        if (bytes >= left_) throw link::LinkLost("line", "cut");
        left_ -= bytes;
    }

    link::Transport& line_;
    std::uint64_t left_;
};

}  // namespace haptogram::test
