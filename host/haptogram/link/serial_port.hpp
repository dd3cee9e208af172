// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// A serial port, or the pseudo-terminal of a virtual board: 8N1, without flow control. While it is open no other
/// program of ours can open it.
class SerialPort final : public Transport {
public:
    /// @param path  such as /dev/ttyUSB0
    /// @param baud  any rate that the port's driver can make, not only the customary ones
    /// @throws Error{device} when it cannot be opened, is in use, or cannot do that rate
    SerialPort(const std::string& path, std::uint32_t baud);
    ~SerialPort() override;

    void write(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;
    void discard_output() override;
    void send_break() override;
    void set_interrupt(const Interrupt& interrupt) override;

private:
    struct Port;
    std::unique_ptr<Port> port_;
};

}  // namespace haptogram::link
