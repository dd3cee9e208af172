// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/format/waveform.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/source.hpp"

namespace haptogram::link {

// A waveform on whatever a device plays. A device with a modulation memory multiplies the amplitudes of records that
// have some. On any other device, silence between entries makes a waveform that is only on or off; all others are of
// compiled records, each of one strength.

/// A waveform as modulation_of() reads it.
struct Am {
    std::string waveform;  ///< empty: none
    AmplitudeLaw law = AmplitudeLaw::pressure;
    double carrier_hz = 0.0;  ///< of what plays; 0: of the first focus record or record in the device
};

/// The samples of a waveform, at most as many as the device holds if it modulates.
/// @throws Error{bad_argument} or Error{bad_input} as haptogram::modulation_of() does
[[nodiscard]] Modulation modulation_of(const Am& am, Commands& device);

/// The carrier frequency of a record in the device's memory. @throws Error{device} when it is no record
[[nodiscard]] double record_carrier_hz(Commands& device, std::uint16_t index);
/// The carrier frequency of the first focus record, or, when there is none, of the first record.
[[nodiscard]] double device_carrier_hz(Commands& device);

/// @throws Error{bad_input} when a record in the device has timings and no amplitudes, which nothing can multiply
void require_amplitudes(Commands& device, std::uint16_t index);

/// A device modulates while this lives, and does not when it goes. An image's own modulation comes back with its next
/// upload.
class ModulationOn {
public:
    /// @param warn  told when it could not be ended
    /// @throws Error{bad_input} when the device cannot hold the samples
    ModulationOn(Commands& device, const Modulation& modulation, Warning warn = {});
    ModulationOn(const ModulationOn&) = delete;
    ModulationOn& operator=(const ModulationOn&) = delete;
    ~ModulationOn();

private:
    Commands& device_;
    Warning warn_;
};

/// Times in which what plays is let through, and silent, in turn; the first may be of no length.
struct Gate {
    std::vector<std::uint64_t> periods;  ///< of the carrier: on, off, on, …, over and over; an even number
};
/// A modulation that is only on or off. A change that falls within a sample goes to the nearer end of it.
/// @param name  of the waveform in messages
/// @throws Error{bad_argument} for any other modulation
[[nodiscard]] Gate gate_of(const Modulation& modulation, const std::string& name);

/// Entries with silence where a gate is closed.
class GatedEntries final : public StreamSource {
public:
    GatedEntries(StreamSource& source, Gate gate) : source_(source), gate_(std::move(gate)) {}
    /// @throws Error{bad_input} for an entry of dwell 0, which has no length to be cut
    std::optional<SequenceEntry> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override { return !entry_ && source_.ended(); }

private:
    StreamSource& source_;
    Gate gate_;
    std::optional<SequenceEntry> entry_;  ///< what is left of it
    std::size_t at_ = 0;                  ///< of the gate
    std::uint64_t past_ = 0;              ///< periods of that time that are over
};

/// Entries of records that have amplitudes.
class AmplitudesOnly final : public StreamSource {
public:
    AmplitudesOnly(Commands& device, StreamSource& source) : device_(device), source_(source) {}
    /// @throws Error{bad_input} as require_amplitudes() does
    std::optional<SequenceEntry> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override { return source_.ended(); }

private:
    Commands& device_;
    StreamSource& source_;
    std::vector<bool> known_;  ///< indices that were looked at
};

}  // namespace haptogram::link
