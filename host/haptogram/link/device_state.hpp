// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// How the connection to a device is.
enum class Connection { connecting, connected, lost };
[[nodiscard]] std::string_view to_string(Connection connection);

/// What a DeviceThread, or a StepPlayer, knows of its device.
struct DeviceState {
    Connection connection = Connection::connecting;
    Identity identity;            ///< of the present or last session
    Status status;                ///< as the device said last; old when the connection is lost
    std::string trouble;          ///< why there is no connection, or what went wrong last; empty when all is well
    std::uint64_t shut_offs = 0;  ///< how often they were asked to be shut off
    std::uint64_t confirmed = 0;  ///< how many of these the device has confirmed, by an answer to disable
};

}  // namespace haptogram::link
