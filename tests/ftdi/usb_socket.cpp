// SPDX-License-Identifier: Apache-2.0
#include "usb_socket.hpp"

#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <stdexcept>

namespace haptogram::test {
namespace {

/// What a pointer at `offset` of the program's memory points to.
Reference<UMockdevIoctlData> follow(UMockdevIoctlData* data, std::size_t offset, std::size_t length) {
    return Reference<UMockdevIoctlData>(umockdev_ioctl_data_resolve(data, offset, length, nullptr));
}

template <class Value>
Value value_of(const Reference<UMockdevIoctlData>& data) {
    Value value;
    std::memcpy(&value, data->data, sizeof value);
    return value;
}

template <class Value>
void store(UMockdevIoctlData* data, std::size_t offset, Value value) {
    umockdev_ioctl_data_update(data, offset, reinterpret_cast<guint8*>(&value), sizeof value);
}

}  // namespace

UsbSocket::UsbSocket(UMockdevTestbed* bed, unsigned number, FtdiChip& chip)
    : bed_(bed),
      chip_(chip),
      device_(fmt::format("/sys/devices/usb1/1-{}", number)),
      node_(fmt::format("/dev/bus/usb/001/{:03}", number)),
      handler_(umockdev_ioctl_base_new()) {
    const std::string descriptors = fmt::format("{:02X}", fmt::join(chip.descriptors(), ""));
    const std::string description = fmt::format(
        "P: /devices/usb1/1-{0}\nN: bus/usb/001/{0:03}={1}\nE: DEVNAME=/dev/bus/usb/001/{0:03}\nE: DEVTYPE=usb_device\n"
        "E: BUSNUM=001\nE: DEVNUM={0:03}\nE: SUBSYSTEM=usb\nA: busnum=1\\n\nA: devnum={0}\\n\nA: speed={2}\\n\n"
        "A: bConfigurationValue=1\\n\nH: descriptors={1}\n",
        number, descriptors, chip.type().megabits);
    g_signal_connect(handler_.get(), "handle-ioctl", G_CALLBACK(on_ioctl), this);
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(bed, description.c_str(), &error) ||
        !umockdev_testbed_attach_ioctl(bed, node_.c_str(), handler_.get(), &error))
        throw std::runtime_error(error->message);
}

UsbSocket::~UsbSocket() {
    umockdev_testbed_detach_ioctl(bed_, node_.c_str(), nullptr);
    umockdev_testbed_remove_device(bed_, device_.c_str());
}

gboolean UsbSocket::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    const int error = static_cast<UsbSocket*>(self)->answer(umockdev_ioctl_client_get_request(client),
                                                            umockdev_ioctl_client_get_arg(client));
    umockdev_ioctl_client_complete(client, error == 0 ? 0 : -1, error);
    return TRUE;
}

int UsbSocket::answer(unsigned long request, UMockdevIoctlData* argument) {
    if (request == USBDEVFS_REAPURBNDELAY) return reap(argument);
    if (request == USBDEVFS_DISCARDURB) return discard(argument);
    if (!plugged_) return ENODEV;
    switch (request) {
        case USBDEVFS_GET_CAPABILITIES:
            store<std::uint32_t>(follow(argument, 0, sizeof(std::uint32_t)).get(), 0,
                                 USBDEVFS_CAP_REAP_AFTER_DISCONNECT);
            return 0;
        case USBDEVFS_DISCONNECT_CLAIM: {
            const auto what =
                value_of<usbdevfs_disconnect_claim>(follow(argument, 0, sizeof(usbdevfs_disconnect_claim)));
            return claim(what.interface, what.driver);
        }
        case USBDEVFS_RELEASEINTERFACE: owner.clear(); return 0;
        case USBDEVFS_IOCTL: {
            const auto what = value_of<usbdevfs_ioctl>(follow(argument, 0, sizeof(usbdevfs_ioctl)));
            if (what.ioctl_code != static_cast<int>(USBDEVFS_CONNECT) || !owner.empty()) return EBUSY;
            owner = "ftdi_sio";
            return 0;
        }
        case USBDEVFS_SUBMITURB: return submit(argument);
        default: return ENOTTY;
    }
}

int UsbSocket::claim(unsigned interface, const std::string& except) {
    if (interface + 1 != chip_.type().interfaces) return EINVAL;
    if (owner == except) return EBUSY;
    owner = "usbfs";
    return 0;
}

int UsbSocket::submit(UMockdevIoctlData* argument) {
    Urb urb{follow(argument, 0, sizeof(usbdevfs_urb)), nullptr};
    const auto head = value_of<usbdevfs_urb>(urb.head);
    urb.buffer = follow(urb.head.get(), offsetof(usbdevfs_urb, buffer), static_cast<std::size_t>(head.buffer_length));
    const std::span<const std::uint8_t> bytes(urb.buffer->data, static_cast<std::size_t>(head.buffer_length));
    if (head.type == USBDEVFS_URB_TYPE_CONTROL) {
        const auto setup = value_of<Setup>(urb.buffer);
        auto answer = chip_.control(setup);
        const std::size_t length =
            answer && (setup.type & 0x80U) != 0 ? std::min<std::size_t>(answer->size(), setup.length) : 0;
        Bytes whole(bytes.begin(), bytes.begin() + sizeof setup);
        if (length > 0)
            whole.insert(whole.end(), answer->begin(), answer->begin() + static_cast<std::ptrdiff_t>(length));
        finish(std::move(urb), answer ? 0 : -EPIPE, whole, length);
    } else if ((head.endpoint & 0x80U) == 0) {
        chip_.put(head.endpoint, bytes);
        finish(std::move(urb), 0, {}, bytes.size());
    } else {
        waiting_.push_back(std::move(urb));
    }
    return 0;
}

int UsbSocket::discard(UMockdevIoctlData* argument) {
    gulong address = 0;
    std::memcpy(&address, argument->data, sizeof address);
    const auto urb = std::ranges::find_if(waiting_, [&](const Urb& one) { return one.head->client_addr == address; });
    if (urb == waiting_.end()) return EINVAL;
    Urb discarded = std::move(*urb);
    waiting_.erase(urb);
    finish(std::move(discarded), -ENOENT, {}, 0);
    return 0;
}

int UsbSocket::reap(UMockdevIoctlData* argument) {
    if (done_.empty()) {
        if (asks_again_) serve();
        asks_again_ = true;
        return plugged_ || !done_.empty() ? EAGAIN : ENODEV;
    }
    asks_again_ = false;
    umockdev_ioctl_data_set_ptr(follow(argument, 0, sizeof(void*)).get(), 0, done_.front().head.get());
    done_.pop_front();
    return 0;
}

void UsbSocket::serve() {
    for (bool first = true; !waiting_.empty() && (first || !plugged_); first = false) {
        Urb urb = std::move(waiting_.front());
        waiting_.pop_front();
        const auto head = value_of<usbdevfs_urb>(urb.head);
        const Bytes packets =
            plugged_ ? chip_.get(head.endpoint, static_cast<std::size_t>(head.buffer_length)) : Bytes{};
        finish(std::move(urb), plugged_ ? 0 : -ESHUTDOWN, packets, packets.size());
    }
}

void UsbSocket::finish(Urb urb, int status, const Bytes& answer, std::size_t length) {
    if (!answer.empty())
        umockdev_ioctl_data_update(urb.buffer.get(), 0, const_cast<guint8*>(answer.data()),
                                   static_cast<gint>(answer.size()));
    store(urb.head.get(), offsetof(usbdevfs_urb, status), status);
    store(urb.head.get(), offsetof(usbdevfs_urb, actual_length), static_cast<int>(length));
    done_.push_back(std::move(urb));
}

}  // namespace haptogram::test
