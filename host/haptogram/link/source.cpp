// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/link/focus_ring.hpp"

namespace haptogram::link {

namespace {

/// The numbers of a line, with blanks, tabs or commas between; none when something else is in it.
std::optional<std::vector<double>> numbers_in(const std::string& line) {
    std::vector<double> numbers;
    const char* at = line.data();
    const char* const end = line.data() + line.size();
    for (;;) {
        while (at != end && (*at == ' ' || *at == '\t' || *at == ',' || *at == '\r')) ++at;
        if (at == end) return numbers;
        double number = 0.0;
        const auto parsed = std::from_chars(at, end, number);
        if (parsed.ec != std::errc()) return {};
        numbers.push_back(number);
        at = parsed.ptr;
    }
}

constexpr double longest_dwell = 65535.0;

bool is_whole(double number, double most) { return number >= 0.0 && number <= most && number == std::floor(number); }

}  // namespace

std::optional<SequenceEntry> StreamLines::next(std::chrono::milliseconds patience) {
    const std::optional<std::string> line = text_.next(patience);
    if (!line) return {};
    const auto numbers = numbers_in(*line);
    const bool good = numbers && (numbers->size() == 1 || numbers->size() == 2) &&
                      is_whole(numbers->front(), records_) && is_whole(numbers->back(), longest_dwell);
    if (!good)
        throw bad_input(text_.where(),
                        fmt::format("found '{}', expected 'index' or 'index dwell': an index from 0 to {}, a dwell "
                                    "from 0 to 65535 cycles",
                                    line->substr(0, 40), records_));
    return SequenceEntry{static_cast<std::uint16_t>(numbers->front()),
                         numbers->size() == 2 ? static_cast<std::uint16_t>(numbers->back()) : dwell_};
}

std::optional<FocusEntry> FocusLines::next(std::chrono::milliseconds patience) {
    const std::optional<std::string> line = text_.next(patience);
    if (!line) return {};
    const auto numbers = numbers_in(*line);
    const std::size_t count = numbers ? numbers->size() : 0;
    if (count < 3 || count > 5 || (count == 5 && !is_whole(numbers->back(), longest_dwell)))
        throw bad_input(text_.where(),
                        fmt::format("found '{}', expected 'x y z', 'x y z amplitude' or 'x y z amplitude dwell': "
                                    "millimetres, an amplitude from 0 to 1, a dwell from 0 to 65535 cycles",
                                    line->substr(0, 40)));
    const std::vector<double>& n = *numbers;
    try {
        const Vec3 position{n[0] * millimetre, n[1] * millimetre, n[2] * millimetre};
        return FocusEntry{pack_focus({position, count > 3 ? n[3] : 1.0}),
                          count == 5 ? static_cast<std::uint16_t>(n[4]) : dwell_};
    } catch (const Error& error) {
        throw bad_input(text_.where(), error.message());
    }
}

RepeatedEntries::RepeatedEntries(std::vector<SequenceEntry> pass, std::uint64_t passes, std::uint64_t most_periods)
    : pass_(std::move(pass)), entries_(passes * pass_.size()), most_periods_(most_periods) {}

std::optional<SequenceEntry> RepeatedEntries::next(std::chrono::milliseconds) {
    if (ended()) return {};
    SequenceEntry entry = pass_[taken_++ % pass_.size()];
    if (most_periods_ != 0)
        entry.dwell = static_cast<std::uint16_t>(std::min<std::uint64_t>(entry.dwell, most_periods_ - periods_));
    periods_ += entry.dwell;
    return entry;
}

bool RepeatedEntries::ended() const {
    return pass_.empty() || (entries_ != 0 && taken_ == entries_) || (most_periods_ != 0 && periods_ == most_periods_);
}

/// Whether the head has come, which says for how many channels the patterns are, so that none is played shifted.
bool PatternBytes::has_head(std::size_t words) {
    const std::string head = fmt::format("patterns {}\n", words);
    if (begun_ || (bytes_.size() < head.size() && head.starts_with(bytes_) && !input_.ended())) return begun_;
    if (!bytes_.starts_with(head))
        throw bad_input(
            input_.name(),
            fmt::format("begins with '{}', expected the line 'patterns {}' for a board of {} channels, and "
                        "then two bytes for each channel of each pattern",
                        printable(bytes_.substr(0, std::min(bytes_.find('\n'), head.size()))), words, words));
    bytes_.erase(0, head.size());
    return begun_ = true;
}

std::optional<std::size_t> PatternBytes::take(std::span<std::uint16_t> patterns, std::size_t words) {
    const std::size_t wanted = 2 * patterns.size(), each = 2 * words;
    while (bytes_.size() < wanted && !input_.ended() && input_.read(bytes_, std::chrono::milliseconds(0))) {
    }
    if (!has_head(words)) return 0;
    if (input_.ended() && bytes_.empty()) return {};
    if (input_.ended() && bytes_.size() < each)
        throw bad_input(input_.name(), fmt::format("pattern {} has {} bytes, expected {}, two for each of its words",
                                                   taken_ + 1, bytes_.size(), each));
    const std::size_t count = std::min(wanted, bytes_.size()) / each;
    for (std::size_t i = 0; i < count * words; ++i)
        patterns[i] = static_cast<std::uint16_t>(static_cast<unsigned char>(bytes_[2 * i]) |
                                                 static_cast<unsigned char>(bytes_[2 * i + 1]) << 8);
    bytes_.erase(0, count * each);
    taken_ += count;
    return count;
}

std::optional<std::size_t> FocusPatterns::take(std::span<std::uint16_t> patterns, std::size_t words) {
    const std::size_t most = patterns.size() / words;
    std::vector<std::uint16_t> records;
    std::size_t count = 0;
    for (; count < most; ++count) {
        // A focus of dwell 0 goes on until the next one is there.
        const bool done = entry_ && periods_ >= entry_->dwell;
        if (!entry_ || done) {
            if (auto next = source_.next(std::chrono::milliseconds(0))) {
                entry_ = *next;
                periods_ = 0;
            } else if (!entry_ || entry_->dwell != 0 || source_.ended()) {
                break;
            }
        }
        add_record(records, entry_->focus, words / 4);
        if (entry_->dwell != 0) ++periods_;
    }
    std::ranges::copy(records, patterns.begin());
    if (count == 0 && source_.ended()) return {};
    return count;
}

}  // namespace haptogram::link
