// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::link {

/// A device behind a port of its own, with a session begun, in the caller's thread. DeviceThread is for programs that
/// have something else to do meanwhile.
class Device final : public Client {
public:
    /// @throws Error{device} when the port cannot be opened or no Haptogram answers
    explicit Device(const PortSettings& settings);
};

/// A device that has answered.
struct FoundDevice {
    std::string port;  ///< what PortSettings take
    Identity identity;
};

/// Who answers behind a port: the tiles of a chain in their order, or one board alone. Takes some seconds, because the
/// end of a chain shows only by its silence.
/// @throws Error{device} when the port cannot be opened or nobody answers
[[nodiscard]] std::vector<FoundDevice> devices_behind(const PortSettings& settings);

}  // namespace haptogram::link
