// SPDX-License-Identifier: Apache-2.0
// In place of ftdi_port.cpp in a build without libftdi1 (HAPTOGRAM_FTDI=OFF): there are no such devices, and whoever
// asks for one is told why.
#include "haptogram/base/error.hpp"
#include "haptogram/link/ftdi_port.hpp"

namespace haptogram::link {

struct FtdiPort::Port {};

FtdiPort::FtdiPort(const std::string& name, std::uint32_t /*baud*/) {
    throw bad_argument(name,
                       "this build cannot reach FTDI chips by libusb; name the serial port that the kernel made of it "
                       "(/dev/ttyUSB0), or build with HAPTOGRAM_FTDI=ON");
}

FtdiPort::~FtdiPort() = default;

void FtdiPort::write(std::span<const std::uint8_t> /*bytes*/) {}

std::vector<std::uint8_t> FtdiPort::read(std::chrono::microseconds /*patience*/) { return {}; }

std::vector<FtdiDevice> ftdi_devices() { return {}; }

}  // namespace haptogram::link
