// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/serial_port.hpp"

#include <fmt/core.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/serial_port.hpp>
#include <cerrno>
#include <system_error>
#include <thread>

#include "haptogram/base/error.hpp"
#include "haptogram/link/serial_line.hpp"

namespace haptogram::link {
namespace asio = boost::asio;
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::seconds most_wait = 10s, most_wait_interrupted = 1s;  // for the port to take bytes

}  // namespace

struct SerialPort::Port {
    std::string path;
    std::uint32_t baud;
    Interrupt interrupt{};
    asio::io_context context;
    asio::serial_port serial{context};

    [[nodiscard]] Error error(const std::string& message) const { return {ErrorCode::device, path, message}; }
    /// Whatever the system's word for that is: it differs from moment to moment.
    [[nodiscard]] LinkLost gone() const {
        return {path, "the port is gone; was it unplugged, or its virtual board ended?"};
    }
};

SerialPort::SerialPort(const std::string& path, std::uint32_t baud) : port_(std::make_unique<Port>()) {
    port_->path = path;
    port_->baud = baud;
    asio::serial_port& serial = port_->serial;
    boost::system::error_code error;
    static_cast<void>(serial.open(path, error));
    if (error)
        throw port_->error(fmt::format(
            "cannot be opened: {}; 'haptogram device list' shows the ports",
            error == boost::system::errc::inappropriate_io_control_operation ? "no serial port" : error.message()));
    if (!keep_to_us(serial.native_handle())) throw port_->error("another program is using it; end that one first");
    using Base = asio::serial_port_base;
    try {
        serial.set_option(Base::character_size(8));
        serial.set_option(Base::parity(Base::parity::none));
        serial.set_option(Base::stop_bits(Base::stop_bits::one));
        serial.set_option(Base::flow_control(Base::flow_control::none));
    } catch (const boost::system::system_error& refused) {
        throw port_->error(fmt::format("it cannot be set to 8N1: {}; is it a serial port?", refused.code().message()));
    }
    ask_for_low_latency(serial.native_handle(), path);
    forget(serial.native_handle(), true);  // answers to the questions of an earlier user
    const std::uint32_t rate = set_baud_rate(serial.native_handle(), baud);
    // An 8N1 line works while the rates of both ends differ by less than some 4 %.
    if (rate == 0 || rate < baud - baud / 50 || rate > baud + baud / 50)
        throw RateRefused(
            path, rate == 0 ? fmt::format("it refuses {} baud: {}", baud, std::generic_category().message(errno))
                            : fmt::format("it makes {} baud of {}; ask for a rate that it can do", rate, baud));
}

SerialPort::~SerialPort() = default;

// write_some() waits without a limit for a port that is full, so it is asked only when there is room.
void SerialPort::write(std::span<const std::uint8_t> bytes) {
    auto since = std::chrono::steady_clock::now();  // it took some last, or a signal asked to end
    std::chrono::steady_clock::time_point took_some{};
    unsigned signals = 0;
    while (!bytes.empty()) {
        if (wait_to_write(port_->serial.native_handle(), 50ms)) {
            boost::system::error_code error;
            const std::size_t count = port_->serial.write_some(asio::buffer(bytes.data(), bytes.size()), error);
            if (error && error != asio::error::would_block && error != asio::error::interrupted) throw port_->gone();
            bytes = bytes.subspan(count);
            if (bytes.empty()) return;
            if (count > 0) took_some = std::chrono::steady_clock::now();
            if (count > 0 && signals == 0) since = took_some;
        }
        if (port_->interrupt && port_->interrupt() != signals) {
            signals = port_->interrupt();
            since = std::chrono::steady_clock::now();
        }
        const std::chrono::seconds patience = signals == 0 ? most_wait : signals == 1 ? most_wait_interrupted : 0s;
        if (std::chrono::steady_clock::now() - since >= patience)
            throw LinkLost(port_->path, std::chrono::steady_clock::now() - took_some < 500ms
                                            ? "a signal came while it was still taking bytes, too slowly to wait for"
                                            : "it takes no bytes; is a board behind it?");
    }
}

/// A pseudo-terminal has no line, so nothing comes of it there.
void SerialPort::send_break() {
    const SerialHandle port = port_->serial.native_handle();
    if (!hold_break(port, true)) return;
    std::this_thread::sleep_for(break_time(port_->baud));
    hold_break(port, false);
}

void SerialPort::set_interrupt(const Interrupt& interrupt) { port_->interrupt = interrupt; }

void SerialPort::discard_output() { forget(port_->serial.native_handle(), false); }

std::vector<std::uint8_t> SerialPort::read(std::chrono::microseconds patience) {
    std::array<std::uint8_t, 4096> buffer{};
    std::size_t count = 0;
    boost::system::error_code outcome;
    port_->context.restart();
    port_->serial.async_read_some(asio::buffer(buffer),
                                  [&](const boost::system::error_code& error, std::size_t arrived) {
                                      outcome = error;
                                      count = arrived;
                                  });
    port_->context.run_for(patience);
    if (!port_->context.stopped()) {
        port_->serial.cancel();
        port_->context.run();  // the read ends now, with what came in the last moment or with nothing
    }
    if (outcome && outcome != asio::error::operation_aborted) throw port_->gone();
    return {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(count)};
}

}  // namespace haptogram::link
