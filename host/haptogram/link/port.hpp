// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// The port of that name: an FTDI chip when it begins with "ftdi:", else a serial port.
/// @throws Error{device} as FtdiPort and SerialPort do
[[nodiscard]] std::unique_ptr<Transport> open_port(const std::string& name, std::uint32_t baud);

}  // namespace haptogram::link
