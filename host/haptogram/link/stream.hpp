// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "haptogram/image/image.hpp"
#include "haptogram/link/play.hpp"

namespace haptogram::link {

/// Where a stream's entries come from.
class StreamSource {
public:
    StreamSource() = default;
    StreamSource(const StreamSource&) = delete;
    StreamSource& operator=(const StreamSource&) = delete;
    virtual ~StreamSource() = default;
    /// The next entry, waiting for it at most so long; empty when there is none yet.
    virtual std::optional<SequenceEntry> next(std::chrono::milliseconds patience) = 0;
    /// Whether no entry will come any more.
    [[nodiscard]] virtual bool ended() const = 0;
};

/// Entries from the lines of a file, a pipe or a terminal, as they come: a line is 'index' or 'index dwell', with
/// blanks, tabs or commas between.
class StreamLines final : public StreamSource {
public:
    /// @param path     "-" is standard input
    /// @param dwell    of a line that says none, in carrier cycles
    /// @param records  the highest index
    /// @throws Error{bad_input} when it cannot be opened; next() when a line is wrong, with its number
    StreamLines(const std::string& path, std::uint16_t dwell, std::uint32_t records);
    ~StreamLines() override;

    std::optional<SequenceEntry> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override { return ended_ && text_.empty(); }

private:
    bool fill(std::chrono::milliseconds patience);
    [[nodiscard]] SequenceEntry parse(const std::string& line) const;

    std::string name_;
    int descriptor_;
    std::uint16_t dwell_;
    std::uint32_t records_;
    std::string text_;
    std::size_t number_ = 0;
    bool ended_ = false;
};

struct StreamSettings {
    std::uint16_t watchdog_ms = 500;  ///< outputs go off when this host is silent for so long; 0: never
    Warning warn{};
};

/// Turns the outputs on and plays entries through the live FIFO, no faster than the device takes them, until they end;
/// then off again.
Played stream(Commands& device, const StreamSettings& settings, StreamSource& source, const Watch& watch = {});

/// How many carrier cycles an entry must last for so many entries a second.
/// @throws Error{bad_argument} for a "rate" that no number of cycles from 1 to 65535 makes within 5 %
[[nodiscard]] std::uint16_t dwell_of(double rate, double carrier_hz);

}  // namespace haptogram::link
