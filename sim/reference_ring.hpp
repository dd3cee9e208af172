// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>

#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// The ring in primary memory into which PUSH_FOCI writes focus records (rtl/amplitudes/focus_ring.v).
class FocusRing {
public:
    using Words = std::array<std::uint16_t, interface::ring_words>;

    explicit FocusRing(const interface::CoreParameters& p)
        : memory_words_(p.records * (p.channels + interface::record_header_words)),
          records_(p.records),
          least_(p.live_depth) {}

    /// The ring begins anew.
    void set(std::uint32_t address, std::uint16_t word) {
        words_[address] = word;
        address_ = start();
        index_ = first();
    }
    [[nodiscard]] const Words& words() const { return words_; }

    [[nodiscard]] bool usable(std::uint32_t foci, std::uint32_t top_index) const {
        const std::uint64_t beyond = 4ULL * base() + 4ULL * count() * foci;
        return count() > least_ && first() > records_ && first() + count() - 1 <= top_index && beyond <= memory_words_;
    }

    /// A frame begins to write.
    void begin() {
        to_ = address_;
        to_index_ = index_;
        word_ = 0;
    }
    [[nodiscard]] std::uint32_t address() const { return to_; }
    /// A word was written there. @return the index of the record that it completes; 0 when it does not
    [[nodiscard]] std::uint16_t wrote(std::uint32_t foci) {
        if (word_ + 1 < 4 * foci) {
            ++word_;
            to_ = to_ + 1;
            return 0;
        }
        word_ = 0;
        const std::uint16_t index = to_index_;
        const bool last = to_index_ == first() + count() - 1;
        to_ = last ? start() : to_ + 1;
        to_index_ = last ? first() : static_cast<std::uint16_t>(to_index_ + 1);
        return index;
    }
    [[nodiscard]] bool split() const { return word_ != 0; }
    void keep() {
        address_ = to_;
        index_ = to_index_;
    }

private:
    [[nodiscard]] std::uint16_t base() const {
        return static_cast<std::uint16_t>(interface::ring_field::base.get(words_));
    }
    [[nodiscard]] std::uint16_t first() const {
        return static_cast<std::uint16_t>(interface::ring_field::first.get(words_));
    }
    [[nodiscard]] std::uint32_t count() const { return interface::ring_field::count.get(words_); }
    [[nodiscard]] std::uint32_t start() const { return 4U * base(); }

    std::uint32_t memory_words_, records_, least_;
    Words words_{};
    std::uint32_t address_ = 0, to_ = 0, word_ = 0;
    std::uint16_t index_ = 0, to_index_ = 0;
};

}  // namespace haptogram::sim
