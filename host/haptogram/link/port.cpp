// SPDX-License-Identifier: Apache-2.0
// The only file that knows whether this build has FTDI (HAPTOGRAM_FTDI): without it, ftdi_port.cpp is left out.
#include "haptogram/link/port.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <system_error>

#include "haptogram/base/error.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/serial_port.hpp"
#if HAPTOGRAM_FTDI
#include "haptogram/link/ftdi_port.hpp"
#endif

namespace haptogram::link {
namespace {

#if HAPTOGRAM_FTDI
std::unique_ptr<Transport> open_ftdi(const std::string& name, std::uint32_t baud) {
    return std::make_unique<FtdiPort>(name, baud);
}

void add_ftdi(std::vector<PortInfo>& ports) {
    for (const FtdiDevice& device : ftdi_devices()) ports.push_back({device.name, device.product});
}
#else
std::unique_ptr<Transport> open_ftdi(const std::string& name, std::uint32_t) {
    throw Error(ErrorCode::bad_argument, name,
                "this build of Haptogram leaves FTDI chips out; name the chip's serial port, such as /dev/ttyUSB0, or "
                "build with libftdi1 (HAPTOGRAM_FTDI=ON)");
}

void add_ftdi(std::vector<PortInfo>&) {}
#endif

/// The chain behind a port: all tiles of it that this process uses share the one port, which has one user at a time.
std::shared_ptr<Chain> open_chain(const std::string& name, std::uint32_t baud) {
    static std::mutex mutex;
    static std::map<std::pair<std::string, std::uint32_t>, std::weak_ptr<Chain>> chains;
    const std::lock_guard lock(mutex);
    std::weak_ptr<Chain>& known = chains[{name, baud}];
    std::shared_ptr<Chain> chain = known.lock();
    if (!chain || chain->lost()) known = chain = std::make_shared<Chain>(open_port(name, baud));
    return chain;
}

}  // namespace

std::unique_ptr<Transport> open_port(const std::string& name, std::uint32_t baud) {
    if (const auto chained = chained_port(name)) return open_chain(chained->port, baud)->tile(chained->tile);
    if (name.starts_with("ftdi:")) return open_ftdi(name, baud);
    return std::make_unique<SerialPort>(name, baud);
}

std::vector<PortInfo> available_ports() {
    std::vector<PortInfo> ports;
    std::error_code error;  // a folder that does not exist has no ports
    // /dev/serial/by-id has the chips' names; a chip that has none is only in /dev.
    for (const auto& entry : std::filesystem::directory_iterator("/dev/serial/by-id", error)) {
        const std::filesystem::path target = std::filesystem::canonical(entry.path(), error);
        ports.push_back({target.string(), entry.path().filename().string()});
    }
    for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
        const std::string name = entry.path().filename().string();
        if ((name.starts_with("ttyUSB") || name.starts_with("ttyACM")) &&
            std::ranges::find(ports, entry.path().string(), &PortInfo::port) == ports.end())
            ports.push_back({entry.path().string(), ""});
    }
    add_ftdi(ports);
    std::ranges::sort(ports);
    return ports;
}

}  // namespace haptogram::link
