// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// An FTDI chip's UART by way of libusb, without a kernel driver: 8N1, no flow control, ours alone while it is open. A
/// chip with several interfaces has its UART on the second one, as FPGA boards do, whose first one programs the FPGA;
/// the kernel's driver still offers the others.
class FtdiPort final : public Transport {
public:
    /// @param name  ftdi:VID:PID:SERIAL as ftdi_devices() has it, or as much of its beginning as names one device alone
    /// @param baud  any rate of which the chip's divider comes within 2 %
    /// @throws Error{device} when no or several devices have that name, it cannot be opened, is in use, or cannot do
    /// that rate
    FtdiPort(const std::string& name, std::uint32_t baud);
    ~FtdiPort() override;

    void write(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;

private:
    struct Port;
    std::unique_ptr<Port> port_;
};

/// An FTDI chip that is plugged in.
struct FtdiDevice {
    std::string name;     ///< ftdi:VID:PID:SERIAL; without the serial number when it has none or may not be opened
    std::string product;  ///< what it says it is
};

/// Those with FTDI's own numbers, by name.
[[nodiscard]] std::vector<FtdiDevice> ftdi_devices();

}  // namespace haptogram::link
