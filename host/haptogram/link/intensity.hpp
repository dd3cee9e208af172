// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "haptogram/format/image.hpp"
#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// Makes what a device's memories hold weaker, and stronger again, also while it plays.
///
/// Of a record of timings only the pulse's length is written, one word, so no record is ever torn; it becomes the one
/// that `compile --amplitude` makes, and is heard when it is loaded next: at its next entry of the sequence. Records
/// with amplitudes and foci are multiplied by the device's modulation. The next upload of the image brings full
/// strength back.
class Intensity {
public:
    /// @param image  that the device's memories hold, at full strength
    explicit Intensity(Image image);

    /// @param factor  of all amplitudes, 0…1
    /// @throws Error{bad_argument} for another "intensity"; Error{bad_input} when the image has amplitudes and the
    ///         device no modulation
    void set(Commands& device, double factor);
    /// What set() sends, for who cannot wait.
    /// @param modulates  whether the device modulates now, as its status says
    [[nodiscard]] std::vector<Request> requests(const Identity& identity, bool modulates, double factor);

    /// Another modulation for all amplitudes, from the next carrier period on, or none; of the same factor.
    /// @throws Error{bad_input} when the image has no amplitudes, or the device no modulation or too few samples
    void modulate(Commands& device, const std::optional<SampledModulation>& modulation);
    /// What modulate() sends.
    [[nodiscard]] std::vector<Request> requests(const Identity& identity,
                                                const std::optional<SampledModulation>& modulation);
    /// Whether set() needs the device's status.
    [[nodiscard]] bool has_amplitudes() const { return has_amplitudes_; }

private:
    void add_pulses(std::vector<Request>& requests, const Identity& identity, double factor);
    void add_samples(std::vector<Request>& requests, const Identity& identity, bool starts) const;

    Image image_;
    double factor_ = 1.0;
    bool has_amplitudes_;                // of its records, some
    std::vector<std::uint32_t> pulses_;  // that the device holds now, ticks, one a record of timings; of others 0
};

/// Whether an image has amplitudes, by records or foci, that a device's modulation multiplies.
[[nodiscard]] bool can_be_modulated(const Image& image);

}  // namespace haptogram::link
