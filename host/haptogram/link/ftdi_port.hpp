// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// The UART of an FTDI chip, reached through libusb without a kernel driver: 8N1, without flow control. While it is
/// open no other program can open it. On a chip with several interfaces the second one is taken: FPGA boards have their
/// UART there, and program the FPGA by the first. The kernel's driver keeps the interfaces that are not taken.
class FtdiPort final : public Transport {
public:
    /// @param name  ftdi:VID:PID:SERIAL as ftdi_devices() lists it, or a beginning of it that only one device has
    /// @param baud  any rate that the chip's divider makes within 2 %
    /// @throws Error{device} when no device or several have that name, when it cannot be opened or is in use, and when
    /// it cannot make that rate
    FtdiPort(const std::string& name, std::uint32_t baud);
    ~FtdiPort() override;

    void write(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;
    void discard_output() override;
    void send_break() override;

private:
    struct Port;
    std::unique_ptr<Port> port_;
};

/// An FTDI chip that is plugged in.
struct FtdiDevice {
    std::string name;     ///< ftdi:VID:PID:SERIAL; the serial number is missing when the chip has none, or when this
                          ///< user may not open the device to read it
    std::string product;  ///< the chip's own description
};

/// The chips that have FTDI's own vendor and product numbers, sorted by name.
[[nodiscard]] std::vector<FtdiDevice> ftdi_devices();

}  // namespace haptogram::link
