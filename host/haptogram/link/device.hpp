// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/link/client.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::link {

/// A device behind a port of its own, with a session begun, in the caller's thread. DeviceThread is for programs that
/// have something else to do meanwhile.
class Device final : public Client {
public:
    /// @throws Error{device} when the port cannot be opened or no Haptogram answers
    explicit Device(const PortSettings& settings) : Client(open_port(settings.port, settings.baud)) { identify(); }
};

}  // namespace haptogram::link
