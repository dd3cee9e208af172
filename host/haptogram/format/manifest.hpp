// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/formation.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/method.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/timer.hpp"

namespace haptogram {

/// What one record means: the foci that it makes, and how strong its pulses are.
struct RecordMeaning {
    std::vector<Focus> foci;         ///< their amplitudes are relative to each other
    double amplitude = 1.0;          ///< of the record's pulses, as a fraction of that of the timer's pulses: 0…1
    std::uint32_t dwell_cycles = 0;  ///< carrier periods that it lasts in one pass
};

/// What records mean whose phases and amplitudes the board computes from their foci.
struct FocusMeaning {
    /// Length of a channel's sum of foci at which its amplitude is full, which is that of the timer's pulses. A lone
    /// focus of amplitude 1 has a sum of length 1.
    double full = 1.0;
};

/// What an image means in the world, kept beside it as JSON: the array and the core it was compiled for, the timer, and
/// what each record makes. Lengths are millimetres in the file.
struct Manifest {
    Array array;
    Core core;
    Timer timer;
    std::vector<RecordMeaning> records;  ///< in the order of the image's places (image.hpp)
    std::optional<FocusMeaning> foci;    ///< given when all of them are focus records, whose indices begin behind the
                                         ///< core's RECORDS
    std::optional<SampledModulation> modulation;  ///< by the board
    Method solver = Method::gauss_newton;         ///< of records of several foci
    std::string quantise;      ///< device on whose segments all pulses lie (solve/segments.hpp); empty: none
    double rate_hz = 0.0;      ///< passes a second, as it came out
    Formation formation;       ///< of the slowest focus
    std::string input_sha256;  ///< of every input and setting that shaped the image
    std::string image_sha256;  ///< of the HEX file's bytes

    /// The index of the record at a place, counted from 0; and the place of an index, empty when there is none.
    [[nodiscard]] std::uint32_t index_of(std::size_t place) const;
    [[nodiscard]] std::optional<std::size_t> place_of(std::uint32_t index) const;
    /// Carrier periods after which everything that plays is as before: whole passes, and whole rounds of the board's
    /// modulation. 0 when the manifest does not say how long a pass is.
    [[nodiscard]] std::uint64_t repeat_periods() const;
    /// Every focal point, record by record; places where pressure is held down, of amplitude 0, are none.
    [[nodiscard]] std::vector<Vec3> points() const;
    /// Whether any record makes several foci at the same time, so that there was something to solve.
    [[nodiscard]] bool has_several_foci() const;
};

[[nodiscard]] std::string version();

[[nodiscard]] nlohmann::ordered_json to_json(const Manifest& manifest);
/// The file's text.
[[nodiscard]] std::string to_text(const Manifest& manifest);

/// @param where  names the file in messages
/// @throws Error{bad_input} for invalid JSON, and for missing or mistyped members, which it names
[[nodiscard]] Manifest manifest_from_json(std::string_view text, const std::string& where);

}  // namespace haptogram
