// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/port.hpp"

#include "haptogram/link/ftdi_port.hpp"
#include "haptogram/link/serial_port.hpp"

namespace haptogram::link {

std::unique_ptr<Transport> open_port(const std::string& name, std::uint32_t baud) {
    if (name.starts_with("ftdi:")) return std::make_unique<FtdiPort>(name, baud);
    return std::make_unique<SerialPort>(name, baud);
}

}  // namespace haptogram::link
