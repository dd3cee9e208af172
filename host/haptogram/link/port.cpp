// SPDX-License-Identifier: Apache-2.0
// The only file that knows whether this build has FTDI (HAPTOGRAM_FTDI): without it, ftdi_port.cpp is left out.
#include "haptogram/link/port.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <random>
#include <system_error>

#include "haptogram/base/error.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/frame.hpp"
#include "haptogram/link/port_rates.hpp"
#include "haptogram/link/serial_port.hpp"
#include "haptogram/link/udp_port.hpp"
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

OpenReference& reference_boards() {
    static OpenReference open;
    return open;
}

std::unique_ptr<Transport> open_reference(const std::string& name) {
    if (!reference_boards())
        throw bad_argument(
            "port", "this build has no simulated board; name a serial port, or build with HAPTOGRAM_SIMULATION=ON");
    return reference_boards()(name.substr(reference_prefix.size()));
}

/// Whether a board answers there at any rate.
bool has_no_rate(const std::string& name) { return names_udp(name) || name.starts_with(reference_prefix); }

/// The chain behind a port: all tiles of it that this process uses share the one port, which has one user at a time.
struct OpenChain {
    std::weak_ptr<Chain> chain;
    std::uint32_t baud = 0;
};

std::mutex chains_mutex;
std::map<std::string, OpenChain>& chains() {
    static std::map<std::string, OpenChain> open;
    return open;
}

std::shared_ptr<Chain> open_chain(const std::string& name, std::uint32_t baud) {
    const std::lock_guard lock(chains_mutex);
    OpenChain& known = chains()[name];
    std::shared_ptr<Chain> chain = known.chain.lock();
    if (!chain || chain->lost() || known.baud != baud) {
        chain = std::make_shared<Chain>(open_port(name, baud));
        known = {chain, baud};
    }
    return chain;
}

/// The rate of the chain that other tiles of this process use already.
std::optional<std::uint32_t> rate_in_use(const std::string& name) {
    const auto chained = chained_port(name);
    if (!chained) return {};
    const std::lock_guard lock(chains_mutex);
    const OpenChain& known = chains()[chained->port];
    const std::shared_ptr<Chain> chain = known.chain.lock();
    return chain && !chain->lost() ? std::optional(known.baud) : std::nullopt;
}

std::vector<std::uint32_t> rates_to_try(const PortSettings& settings) {
    std::vector<std::uint32_t> rates;
    const auto add = [&rates](std::uint32_t rate) {
        if (std::ranges::find(rates, rate) == rates.end()) rates.push_back(rate);
    };
    if (const auto remembered = remembered_rate(settings.port)) add(*remembered);
    if (settings.likely) add(*settings.likely);
    for (const std::uint32_t rate : known_rates) add(rate);
    return rates;
}

/// Whether a board answers the question within so long.
bool answers(Transport& line, interface::Command question, std::chrono::microseconds patience,
             const Interrupt& interrupt) {
    constexpr std::chrono::microseconds longest_look = std::chrono::milliseconds(20);
    line.set_interrupt(interrupt);
    const auto number = static_cast<std::uint8_t>(std::random_device()());
    Bytes asked{0};  // ends whatever half frame the line left
    const Bytes request = encode_request(number, question, {});
    asked.insert(asked.end(), request.begin(), request.end());
    line.write(asked);
    ReplyDecoder decoder;
    std::vector<Reply> replies;
    const Clock& clock = line.clock();
    const auto until = clock.now() + patience;
    for (auto now = clock.now(); now < until; now = clock.now()) {
        if (interrupt && interrupt() > 0 && question == interface::Command::identify) throw Interrupted();
        const auto left =
            std::chrono::duration_cast<std::chrono::microseconds>(until - now) + std::chrono::microseconds(1);
        decoder.feed(line.read(std::min(left, longest_look)), replies);
        if (std::ranges::any_of(
                replies, [&](const Reply& reply) { return reply.sequence == number && reply.command == question; }))
            return true;
    }
    return false;
}

}  // namespace

void set_reference_boards(OpenReference open) { reference_boards() = std::move(open); }

std::unique_ptr<Transport> open_port(const std::string& name, std::uint32_t baud) {
    if (names_udp(name)) return std::make_unique<UdpPort>(name);
    if (const auto chained = chained_port(name)) return open_chain(chained->port, baud)->tile(chained->tile);
    if (name.starts_with(reference_prefix)) return open_reference(name);
    if (name.starts_with("ftdi:")) return open_ftdi(name, baud);
    return std::make_unique<SerialPort>(name, baud);
}

std::unique_ptr<Transport> open_port(const PortSettings& settings, interface::Command question, unsigned rounds) {
    if (has_no_rate(settings.port)) return open_port(settings.port, 0);
    if (const auto rate = settings.baud ? settings.baud : rate_in_use(settings.port))
        return open_port(settings.port, *rate);
    std::vector<std::uint32_t> rates = rates_to_try(settings);
    std::string refused;
    for (unsigned round = 0; round < rounds; ++round)
        for (auto rate = rates.begin(); rate != rates.end();) {
            std::unique_ptr<Transport> line;
            try {
                line = open_port(settings.port, *rate);
            } catch (const RateRefused& error) {
                refused = error.message();
                rate = rates.erase(rate);
                continue;
            }
            if (answers(*line, question, probe_patience * (1U << round), settings.interrupt)) {
                const bool looked_for = remembered_rate(settings.port) != *rate;
                remember_rate(settings.port, *rate);
                if (looked_for && settings.found) settings.found(settings.port, *rate);
                return line;
            }
            ++rate;
        }
    if (rates.empty()) throw RateRefused(settings.port, refused);
    throw LinkLost(settings.port,
                   fmt::format("no answer to {} at {} baud; check the cable and that the board runs Haptogram, and "
                               "give the baud rate if it is another; a tile of a chain is named by a # and its number "
                               "behind the port",
                               to_string(question), fmt::join(rates, ", ")));
}

std::unique_ptr<Transport> open_port_to_turn_off(const PortSettings& settings) {
    try {
        return open_port(settings, interface::Command::disable);
    } catch (const LinkLost&) {
        return open_port(settings.port, settings.baud.value_or(known_rates.back()));
    }
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
