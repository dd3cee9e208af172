// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace haptogram::serve {

/// A message of Open Sound Control 1.0. Numbers of every kind are doubles; texts and blobs are passed over.
struct OscMessage {
    std::string address;
    std::vector<double> numbers;
    bool timed = false;  ///< in a bundle with another time than "at once"
};

/// The messages of a datagram, those of bundles in their order and whatever the bundle's time.
/// @throws Error{bad_input} when it is no OSC
[[nodiscard]] std::vector<OscMessage> parse_osc(std::span<const std::uint8_t> datagram);

}  // namespace haptogram::serve
