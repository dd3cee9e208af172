// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>

#include "haptogram/link/device_steps.hpp"

namespace haptogram::link {

/// Owns a port in a thread of its own, so that a program can do other things while a device works: a server, a window,
/// a script's prompt.
///
/// Work reaches the device through channels, of which there may be many, each for one thread at a time: an upload may
/// run beside a stream. The thread takes requests from the channels in turn. It asks for the status often enough to
/// keep the watchdog quiet, tells the caller of each, and connects again after the link was lost.
///
/// shut_off() overtakes everything: what any channel has queued is dropped, bytes that have not left the port are taken
/// back, and disable goes out as the next frame. Channels that were opened before it, and those that wait for a
/// connection, fail from then on with Error{cancelled}, so no work of before can turn the outputs on again. After a
/// loss their error is LinkLost, and the thread turns the outputs off as soon as it has the device back.
class DeviceThread {
public:
    using Settings = DeviceSettings;

    /// Starts the thread and returns at once.
    explicit DeviceThread(Settings settings);
    DeviceThread(const DeviceThread&) = delete;
    DeviceThread& operator=(const DeviceThread&) = delete;
    /// end(), if it was not called.
    ~DeviceThread();
    /// Shuts the outputs off, waiting some two seconds at most for the device to confirm it, and closes the port.
    /// Whatever the port does meanwhile, silent or babbling, is not waited for. Channels fail from now on.
    void end();

    /// Opens a channel. Waits for the connection at most so long; work may then be done through it in any one thread,
    /// and it may outlive this object, after which it fails with Error{cancelled}.
    /// @throws Error{device} saying why there is no connection
    [[nodiscard]] std::unique_ptr<Commands> channel(std::chrono::milliseconds patience = std::chrono::seconds(3));

    /// Turns the outputs off ahead of everything. Returns at once; may be called from any thread, also from `told`.
    /// @return for wait_off()
    std::uint64_t shut_off();
    /// Whether the device has confirmed that its outputs are off, waiting for it at most so long. When it has not: the
    /// watchdog should have turned them off; who must be sure switches the power off.
    bool wait_off(std::uint64_t shut_off, std::chrono::milliseconds patience);

    [[nodiscard]] DeviceState state() const;

private:
    std::shared_ptr<DeviceSteps> steps_;
    std::mutex joining_;
    std::thread thread_;
};

}  // namespace haptogram::link
