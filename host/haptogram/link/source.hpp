// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/base/live_input.hpp"
#include "haptogram/format/image.hpp"

namespace haptogram::link {

/// Where a stream's entries come from.
template <class Entry>
class SourceOf {
public:
    SourceOf() = default;
    SourceOf(const SourceOf&) = delete;
    SourceOf& operator=(const SourceOf&) = delete;
    virtual ~SourceOf() = default;
    /// The next entry, waiting for it at most so long; empty when there is none yet.
    virtual std::optional<Entry> next(std::chrono::milliseconds patience) = 0;
    /// Whether no entry will come any more.
    [[nodiscard]] virtual bool ended() const = 0;
};
using StreamSource = SourceOf<SequenceEntry>;

/// A focus, and for how many carrier cycles it plays.
struct FocusEntry {
    FocusWords focus{};
    std::uint16_t dwell = 1;
};
using FocusSource = SourceOf<FocusEntry>;

/// Entries from lines: a line is 'index' or 'index dwell', with blanks, tabs or commas between.
class StreamLines final : public StreamSource {
public:
    /// @param dwell    of a line that says none, in carrier cycles
    /// @param records  the highest index
    /// @throws Error{bad_input} when the file cannot be opened; next() when a line is wrong, with its number
    StreamLines(const std::string& path, std::uint16_t dwell, std::uint32_t records)
        : text_(path), dwell_(dwell), records_(records) {}

    std::optional<SequenceEntry> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override { return text_.ended(); }

private:
    LiveText text_;
    std::uint16_t dwell_;
    std::uint32_t records_;
};

/// Foci from lines: a line is 'x y z', 'x y z amplitude' or 'x y z amplitude dwell', in millimetres in the array's
/// frame, the amplitude from 0 to 1 and 1 if it is not there, with blanks, tabs or commas between.
class FocusLines final : public FocusSource {
public:
    /// As StreamLines.
    FocusLines(const std::string& path, std::uint16_t dwell) : text_(path), dwell_(dwell) {}

    std::optional<FocusEntry> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override { return text_.ended(); }

private:
    LiveText text_;
    std::uint16_t dwell_;
};

/// Patterns of a stream from bytes: words of 16 bits, little-endian, one pattern behind the other.
class PatternBytes {
public:
    /// @throws Error{bad_input} when the file cannot be opened; take() when it has no head, is for another number of
    ///         channels, ends within a pattern, or cannot be read
    explicit PatternBytes(const std::string& path) : input_(path) {}

    /// The next ones, as far as they have come. @param words  of a pattern
    /// @return how many; nothing when no more will come
    std::optional<std::size_t> take(std::span<std::uint16_t> patterns, std::size_t words);

private:
    [[nodiscard]] bool has_head(std::size_t words);

    LiveInput input_;
    std::string bytes_;
    std::uint64_t taken_ = 0;
    bool begun_ = false;
};

/// Patterns of a stream from foci: each is a record of the focus whose turn it is.
class FocusPatterns {
public:
    explicit FocusPatterns(FocusSource& source) : source_(source) {}
    /// As PatternBytes.
    std::optional<std::size_t> take(std::span<std::uint16_t> patterns, std::size_t words);

private:
    FocusSource& source_;
    std::optional<FocusEntry> entry_;
    std::uint16_t periods_ = 0;  // that it has lasted
};

/// A sequence that is repeated.
class RepeatedEntries final : public StreamSource {
public:
    /// @param passes        0: for ever
    /// @param most_periods  the last entry is cut where these carrier periods end; 0: no limit
    RepeatedEntries(std::vector<SequenceEntry> pass, std::uint64_t passes, std::uint64_t most_periods = 0);

    std::optional<SequenceEntry> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override;

private:
    std::vector<SequenceEntry> pass_;
    std::uint64_t entries_, most_periods_;  // 0: no limit
    std::uint64_t taken_ = 0, periods_ = 0;
};

}  // namespace haptogram::link
