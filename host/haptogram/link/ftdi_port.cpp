// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/ftdi_port.hpp"

#include <fmt/format.h>
#include <ftdi.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <thread>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram::link {
namespace {

template <auto release>
struct Releaser {
    template <class Resource>
    void operator()(Resource* resource) const {
        release(resource);
    }
};
using Context = std::unique_ptr<ftdi_context, Releaser<ftdi_free>>;
using UsbDevice = std::unique_ptr<libusb_device, Releaser<libusb_unref_device>>;
using Handle = std::unique_ptr<libusb_device_handle, Releaser<libusb_close>>;
using Transfer = std::unique_ptr<libusb_transfer, Releaser<libusb_free_transfer>>;

constexpr std::uint16_t ftdi_vendor = 0x0403;
constexpr std::array<std::uint16_t, 5> known_products = {0x6001, 0x6010, 0x6011, 0x6014, 0x6015};  // FT232R to FT231X
constexpr std::size_t status_bytes = 2;          // every packet begins with the state of the modem lines
constexpr std::size_t packets_per_transfer = 8;  // 4 KiB with an FT2232H, which is all that its buffer holds
constexpr std::size_t name_length = std::char_traits<char>::length("ftdi:0403:6010");

/// A device that was found.
struct Found : FtdiDevice {
    UsbDevice device;
    int opened;  ///< libusb's result of opening it
};

std::string text(libusb_device_handle* handle, std::uint8_t index) {
    std::array<unsigned char, 256> ascii{};
    const int length = index == 0 ? 0 : libusb_get_string_descriptor_ascii(handle, index, ascii.data(), ascii.size());
    return printable({reinterpret_cast<const char*>(ascii.data()), static_cast<std::size_t>(std::max(length, 0))});
}

/// The plugged-in devices with FTDI's own numbers, and those with the vendor and product numbers that `wanted` begins
/// with: boards may carry numbers of their own maker.
std::vector<Found> find(libusb_context* usb, const std::string& wanted) {
    std::vector<Found> found;
    libusb_device** list = nullptr;
    const ssize_t count = libusb_get_device_list(usb, &list);
    for (ssize_t i = 0; i < count; ++i) {
        libusb_device_descriptor about{};
        libusb_get_device_descriptor(list[i], &about);
        std::string name = fmt::format("ftdi:{:04x}:{:04x}", about.idVendor, about.idProduct);
        const bool known = about.idVendor == ftdi_vendor && std::ranges::count(known_products, about.idProduct) != 0;
        if (!known && !wanted.starts_with(name)) continue;
        libusb_device_handle* opened = nullptr;
        const int result = libusb_open(list[i], &opened);
        const Handle handle(opened);
        const std::string serial = handle ? text(opened, about.iSerialNumber) : "";
        if (!serial.empty()) name += ":" + serial;
        found.push_back(
            {{name, handle ? text(opened, about.iProduct) : ""}, UsbDevice(libusb_ref_device(list[i])), result});
    }
    if (count >= 0) libusb_free_device_list(list, 1);
    std::ranges::sort(found, {}, &Found::name);
    return found;
}

bool is_meant(const Found& found, const std::string& wanted) {
    return wanted == "ftdi:" || found.name == wanted || found.name.starts_with(wanted + ":") ||
           (found.opened != 0 && wanted.starts_with(found.name));  // its serial number could not be read
}

std::string names_of(const std::vector<Found>& all) {
    std::string names;
    for (const Found& found : all) names += (names.empty() ? "" : ", ") + found.name;
    return names.empty() ? "none" : names;
}

/// The rate that the chip makes when it is asked for `baud`. It divides its clock by a multiple of 1/8; below 2 it can
/// only divide by 1 and by 1.5 (FTDI AN_120).
std::uint32_t rate_of(const ftdi_context& ftdi, std::uint32_t baud) {
    const bool high_speed = ftdi.type == TYPE_2232H || ftdi.type == TYPE_4232H || ftdi.type == TYPE_232H;
    const double eighths = high_speed ? 8 * 12e6 : 8 * 3e6;
    const double divisor = std::max(8.0, std::round(eighths / baud));
    return static_cast<std::uint32_t>(eighths / (divisor > 8 && divisor < 16 ? 12 : divisor));
}

}  // namespace

struct FtdiPort::Port {
    std::string name;
    std::uint32_t baud = 0;
    Context ftdi{ftdi_new()};
    // Several are always under way. The chip's buffer is small and nothing can stop the board from sending, so the chip
    // must never wait for a transfer to fill.
    std::array<Transfer, 4> reads;
    std::vector<unsigned char> buffer;
    std::vector<std::uint8_t> arrived;
    std::size_t under_way = 0;
    bool lost = false;

    explicit Port(std::string its_name) : name(std::move(its_name)) {
        if (!ftdi) throw error("USB cannot be used here; use a serial port of 'haptogram device list'");
    }

    ~Port() {
        lost = true;
        for (const Transfer& read : reads)
            if (read) libusb_cancel_transfer(read.get());
        while (under_way > 0 && libusb_handle_events(ftdi->usb_ctx) == 0) {
        }
        ftdi_usb_close(ftdi.get());
    }

    [[nodiscard]] Error error(const std::string& message) const { return {ErrorCode::device, name, message}; }
    [[nodiscard]] LinkLost gone(int reason) const {
        return {name, fmt::format("the port is gone ({}); was it unplugged?", libusb_strerror(reason))};
    }
    void require(int result) const {
        if (result < 0)
            throw error(fmt::format("it cannot be set up: {}; is it an FTDI chip with a UART, and still plugged in?",
                                    ftdi_get_error_string(ftdi.get())));
    }

    void open(const Found& found);
    void set_up(std::uint32_t its_baud);
    void listen();
    void submit(libusb_transfer& read) {
        if (libusb_submit_transfer(&read) == 0)
            ++under_way;
        else
            lost = true;
    }
    static void LIBUSB_CALL take(libusb_transfer* read) noexcept;
};

void FtdiPort::Port::open(const Found& found) {
    if (found.opened == LIBUSB_ERROR_ACCESS)
        throw error(
            "you may not open it; a udev rule lets you, such as that of openFPGALoader for the group plugdev: join "
            "it and plug the device in again");
    libusb_config_descriptor* about = nullptr;
    const bool several =
        libusb_get_active_config_descriptor(found.device.get(), &about) == 0 && about->bNumInterfaces > 1;
    libusb_free_config_descriptor(about);
    ftdi->module_detach_mode = AUTO_DETACH_REATACH_SIO_MODULE;
    ftdi_set_interface(ftdi.get(), several ? INTERFACE_B : INTERFACE_A);
    const int result = ftdi_usb_open_dev(ftdi.get(), found.device.get());
    constexpr int not_claimed = -5;
    if (result == not_claimed) throw error("another program is using it; end that one first");
    require(result);
}

void FtdiPort::Port::set_up(std::uint32_t its_baud) {
    baud = its_baud;
    require(ftdi_set_bitmode(ftdi.get(), 0, BITMODE_RESET));  // its last user may have left it in another mode
    require(ftdi_set_line_property(ftdi.get(), BITS_8, STOP_BIT_1, NONE));
    require(ftdi_setflowctrl(ftdi.get(), SIO_DISABLE_FLOW_CTRL));
    require(ftdi_set_latency_timer(ftdi.get(), 1));  // after so many ms it sends on a packet that is not full
    const std::uint32_t rate = rate_of(*ftdi, baud);
    // An 8N1 line works while the rates of both ends differ by less than some 4 %.
    if (rate < baud - baud / 50 || rate > baud + baud / 50)
        throw RateRefused(name, fmt::format("it makes {} baud of {}; ask for a rate that it can do", rate, baud));
    require(ftdi_set_baudrate(ftdi.get(), static_cast<int>(baud)));
    require(ftdi_tcioflush(ftdi.get()));  // answers to the questions of an earlier user
}

void FtdiPort::Port::listen() {
    const std::size_t length = packets_per_transfer * ftdi->max_packet_size;
    buffer.resize(reads.size() * length);
    for (std::size_t i = 0; i < reads.size(); ++i) {
        reads[i].reset(libusb_alloc_transfer(0));
        // libftdi names the end points from the chip's point of view: its output is our input.
        libusb_fill_bulk_transfer(reads[i].get(), ftdi->usb_dev, static_cast<unsigned char>(ftdi->out_ep),
                                  &buffer[i * length], static_cast<int>(length), take, this, 0);
        submit(*reads[i]);
    }
}

void FtdiPort::Port::take(libusb_transfer* read) noexcept {
    Port& port = *static_cast<Port*>(read->user_data);
    --port.under_way;
    const std::size_t packet = port.ftdi->max_packet_size;
    const auto length = static_cast<std::size_t>(read->actual_length);
    for (std::size_t at = 0; at + status_bytes < length; at += packet)
        port.arrived.insert(port.arrived.end(), read->buffer + at + status_bytes,
                            read->buffer + std::min(at + packet, length));
    if (read->status != LIBUSB_TRANSFER_COMPLETED) port.lost = true;
    if (!port.lost) port.submit(*read);
}

FtdiPort::FtdiPort(const std::string& name, std::uint32_t baud) : port_(std::make_unique<Port>(name)) {
    std::string wanted = name;
    std::transform(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(std::min(name_length, wanted.size())),
                   wanted.begin(), [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    const std::vector<Found> all = find(port_->ftdi->usb_ctx, wanted);
    std::vector<const Found*> meant;
    for (const Found& found : all)
        if (is_meant(found, wanted)) meant.push_back(&found);
    if (meant.empty())
        throw port_->error(fmt::format("no FTDI chip of this name is plugged in; there is {}", names_of(all)));
    if (meant.size() > 1)
        throw port_->error(fmt::format("several FTDI chips have this name; give one of {}", names_of(all)));
    port_->open(*meant.front());
    port_->set_up(baud);
    port_->listen();
}

FtdiPort::~FtdiPort() = default;

void FtdiPort::write(std::span<const std::uint8_t> bytes) {
    const int written = ftdi_write_data(port_->ftdi.get(), bytes.data(), static_cast<int>(bytes.size()));
    if (written < 0) throw port_->gone(written);
}

void FtdiPort::send_break() {
    ftdi_context* const ftdi = port_->ftdi.get();
    if (ftdi_set_line_property2(ftdi, BITS_8, STOP_BIT_1, NONE, BREAK_ON) < 0) return;
    std::this_thread::sleep_for(break_time(port_->baud));
    ftdi_set_line_property2(ftdi, BITS_8, STOP_BIT_1, NONE, BREAK_OFF);
}

void FtdiPort::discard_output() { ftdi_tcoflush(port_->ftdi.get()); }

std::vector<std::uint8_t> FtdiPort::read(std::chrono::microseconds patience) {
    using Steady = std::chrono::steady_clock;
    const auto deadline = Steady::now() + patience;
    for (bool late = false; port_->arrived.empty() && !port_->lost && !late; late = Steady::now() >= deadline) {
        const auto left = std::max(std::chrono::ceil<std::chrono::microseconds>(deadline - Steady::now()),
                                   std::chrono::microseconds(0));
        timeval wait{.tv_sec = left.count() / 1'000'000, .tv_usec = left.count() % 1'000'000};
        const int result = libusb_handle_events_timeout_completed(port_->ftdi->usb_ctx, &wait, nullptr);
        if (result < 0 && result != LIBUSB_ERROR_INTERRUPTED) throw port_->gone(result);
    }
    if (port_->arrived.empty() && port_->lost) throw port_->gone(LIBUSB_ERROR_NO_DEVICE);
    return std::exchange(port_->arrived, {});
}

std::vector<FtdiDevice> ftdi_devices() {
    const Context ftdi(ftdi_new());
    if (!ftdi) return {};  // a system without USB has none
    std::vector<FtdiDevice> devices;
    for (Found& found : find(ftdi->usb_ctx, "")) devices.push_back(std::move(found));
    return devices;
}

}  // namespace haptogram::link
