// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "identity.hpp"
#include "reference_board.hpp"

namespace haptogram::sim {

using interface::Command;
using interface::Status;

namespace {

/// One step of the CRC-32 of IEEE 802.3, for a word that is read from memory.
std::uint32_t crc32(std::uint32_t crc, std::uint16_t word) {
    for (int bit = 0; bit < 16; ++bit) {
        const bool odd = ((crc ^ word >> bit) & 1U) != 0;
        crc = crc >> 1 ^ (odd ? 0xedb88320U : 0U);
    }
    return crc;
}

}  // namespace

Clock ReferenceBoard::collect(Clock offered, std::uint32_t word) {
    const Clock low = line_out_.collect(offered, static_cast<std::uint8_t>(word));
    return line_out_.collect(low + 1, static_cast<std::uint8_t>(word >> 8));
}

void ReferenceBoard::begin_reply(Clock clock) {
    const bool carries = status_ == Status::ok || status_ == Status::repeated;
    words_left_ = 0;
    told_period_ = schedule_.period(clock);
    if (p_.trigger != 0) trigger_.answer(clock);
    if (carries && shape_.carries == Carries::identity) words_left_ = interface::identity_words;
    if (carries && shape_.carries == Carries::status) words_left_ = status_words();
    if (carries && shape_.carries == Carries::memory) words_left_ = argument(2) / 2;
    digest_ = ~0U;
    const Clock head =
        collect(clock + 1, static_cast<std::uint32_t>((static_cast<unsigned>(command_) | 0x80U) << 8 | number_));
    reply_at_ = collect(head + 1, static_cast<std::uint32_t>(expected_ << 8 | static_cast<unsigned>(status_)));
    reply_ = Reply::level;
}

void ReferenceBoard::reply(Clock clock) {
    if (reply_ == Reply::words) return read_word(clock);
    const Clock head = collect(clock + 1, source_.live_level());
    if (words_left_ == 0) return end_reply(head);
    reply_ = Reply::words;
    reply_at_ = head + 1;
}

void ReferenceBoard::read_word(Clock clock) {
    waits_for_memory_ = region_ == primary_region && player_->reader().reads(clock);
    if (waits_for_memory_) {
        reply_at_ = player_->reader().reads_to() + 1;
        return;
    }
    if ((region_ == sequence_region && source_.fetching(clock)) ||
        (region_ == modulation_region && frames_->modulation.fetching(clock))) {
        reply_at_ = clock + 1;
        return;
    }
    constexpr Clock arrives = 3;  // until a word can be sent, or its first bit folded into the digest
    constexpr Clock folded = 16;  // clocks for its bits
    const std::uint16_t word = memory_word();
    ++address_;
    --words_left_;
    if (command_ != Command::digest) {
        const Clock sent = collect(clock + arrives, word);
        if (words_left_ == 0) return end_reply(sent);
        reply_at_ = sent + 1;
        return;
    }
    digest_ = crc32(digest_, word);
    reply_at_ = clock + arrives + folded;
    if (words_left_ > 0) return;
    const Clock low = collect(reply_at_ + 1, ~digest_ & 0xffffU);
    end_reply(collect(low + 2, ~digest_ >> 16));
}

/// @param clock  in which the last word was collected; its CRC follows
void ReferenceBoard::end_reply(Clock clock) {
    line_out_.close(clock + 1);
    reply_ = Reply::idle;
    reply_at_ = never;
    await_frame(clock + 1);
}

std::uint16_t ReferenceBoard::memory_word() const {
    if (region_ == primary_region) return primary_[address_];
    if (region_ == sequence_region) return static_cast<std::uint16_t>(sequence_[address_ / 2] >> address_ % 2 * 16);
    if (region_ == status_region) return status_word(address_);
    if (region_ == parameters_region) return frames_->settings.at(now_)[address_];
    if (region_ == modulation_region) return frames_->modulation.word(address_);
    if (region_ == ring_region) return ring_.words()[address_];
    if (region_ == stream_region) return stream_.words()[address_];
    if (region_ == trigger_region) return trigger_.word(address_);
    return identity_block(p_)[address_];
}

std::uint16_t ReferenceBoard::status_word(std::uint32_t word) const {
    std::array<std::uint16_t, interface::status_words> block{};
    namespace field = interface::status_field;
    field::enabled.set(block, guard_.enabled() ? 1 : 0);
    field::mode.set(block, static_cast<unsigned>(source_.streams(now_) ? interface::Mode::live : source_.mode()));
    field::streaming.set(block, source_.streams(now_) ? 1 : 0);
    field::stream_late.set(block, count_.stream_late);
    field::stream_lost.set(block, count_.stream_lost);
    field::stream_early.set(block, count_.stream_early);
    field::stream_repeated.set(block, count_.stream_repeated);
    field::stopped.set(block, stopped_ ? 1 : 0);
    field::modulated.set(block, frames_ != nullptr && frames_->modulation.running(now_) ? 1 : 0);
    field::bent_periods.set(block, count_.bent);
    field::far_foci.set(block, count_.far);
    field::present_index.set(block, index_);
    field::underruns.set(block, count_.underruns);
    field::refused_records.set(block, count_.refused_records);
    field::frames_good.set(block, count_.good);
    field::frames_damaged.set(block, count_.damaged);
    field::frames_repeated.set(block, count_.repeated);
    field::watchdog_trips.set(block, count_.watchdog);
    field::guard_trips.set(block, count_.guard);
    field::live_level.set(block, source_.live_level());
    field::watchdog_ms.set(block, guard_.watchdog_ms());
    field::frames_refused.set(block, count_.refused);
    field::waiting.set(block, schedule_.waiting() ? 1 : 0);
    field::role.set(block, static_cast<unsigned>(sync_.role()));
    field::in_step.set(block, sync_.in_step() ? 1 : 0);
    field::numbered.set(block, sync_.numbered(now_) ? 1 : 0);
    field::sync_misses.set(block, count_.missed);
    field::sync_losses.set(block, count_.lost);
    field::late_changes.set(block, count_.late);
    field::period.set(block, told_period_ & field::period.most());
    field::period_high.set(block, told_period_ >> field::period.width);
    return block[word];
}

}  // namespace haptogram::sim
