// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <umockdev.h>

#include <deque>
#include <memory>
#include <string>

#include "ftdi_chip.hpp"

namespace haptogram::test {

struct Unreference {
    void operator()(gpointer object) const { g_object_unref(object); }
};
template <class Object>
using Reference = std::unique_ptr<Object, Unreference>;

/// A socket on an emulated USB bus with a chip plugged in: what Linux shows of it in /sys and /dev, and what its usbfs
/// does there. Programs use it by the calls that they make on Linux, which umockdev leads here.
class UsbSocket {
public:
    UsbSocket(UMockdevTestbed* bed, unsigned number, FtdiChip& chip);
    ~UsbSocket();
    UsbSocket(const UsbSocket&) = delete;
    UsbSocket& operator=(const UsbSocket&) = delete;

    /// As when the cable is pulled.
    void unplug() { plugged_ = false; }
    /// Who has the UART's interface: a kernel's driver, a program ("usbfs"), or nobody.
    std::string owner = "ftdi_sio";
    [[nodiscard]] const std::string& node() const { return node_; }

private:
    /// A transfer that a program asked for.
    struct Urb {
        Reference<UMockdevIoctlData> head, buffer;
    };
    static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
    /// What the call returns: 0 or an error number.
    int answer(unsigned long request, UMockdevIoctlData* argument);
    int claim(unsigned interface, const std::string& except);
    int submit(UMockdevIoctlData* argument);
    int discard(UMockdevIoctlData* argument);
    int reap(UMockdevIoctlData* argument);
    /// Lets the chip serve what waits for it.
    void serve();
    void finish(Urb urb, int status, const Bytes& answer, std::size_t length);

    UMockdevTestbed* bed_;
    FtdiChip& chip_;
    std::string device_, node_;
    Reference<UMockdevIoctlBase> handler_;
    bool plugged_ = true;
    bool asks_again_ = false;  ///< the program waits: only then does time pass for the chip
    std::deque<Urb> waiting_, done_;
};

}  // namespace haptogram::test
