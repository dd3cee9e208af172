// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// A serial port, or the pseudo-terminal of a virtual board: 8N1, no flow control, ours alone while it is open.
class SerialPort final : public Transport {
public:
    /// @param path  such as /dev/ttyUSB0
    /// @param baud  any rate that the port's driver can do, also one that has no name
    /// @throws Error{device} when it cannot be opened, is in use, or cannot do that rate
    SerialPort(const std::string& path, std::uint32_t baud);
    ~SerialPort() override;

    void write(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;

private:
    struct Port;
    std::unique_ptr<Port> port_;
};

}  // namespace haptogram::link
