// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/asked_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

using interface::Command;

AskedDevice::AskedDevice(PortSettings settings) : settings_(std::move(settings)) {
    settings_.interrupt = [this] { return interrupts_.load(); };
    settings_.found = [this](const std::string&, std::uint32_t baud) { found_baud_ = baud; };
}

AskedDevice::~AskedDevice() {
    interrupt();
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    news_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void AskedDevice::run() {
    std::unique_lock lock(mutex_);
    while (true) {
        news_.wait(lock, [this] { return work_ || ending_; });
        if (!work_) return;
        const std::function<void()> work = std::exchange(work_, {});
        lock.unlock();
        std::exception_ptr trouble;
        try {
            work();
        } catch (...) {
            trouble = std::current_exception();
        }
        lock.lock();
        busy_ = false;
        trouble_ = trouble;
        news_.notify_all();
    }
}

bool AskedDevice::busy() const {
    const std::lock_guard lock(mutex_);
    return busy_;
}

bool AskedDevice::wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!machine_clock().wait_for(lock, news_, patience, [this] { return !busy_; })) return true;
    if (const auto trouble = std::exchange(trouble_, nullptr)) std::rethrow_exception(trouble);
    return false;
}

/// What went on before has ended, and is forgotten.
void AskedDevice::finish() {
    std::unique_lock lock(mutex_);
    if (busy_) interrupt();
    news_.wait(lock, [this] { return !busy_; });
    trouble_ = nullptr;
    replies_.clear();
}

void AskedDevice::begin(std::function<void()> work) {
    {
        const std::lock_guard lock(mutex_);
        work_ = std::move(work);
        busy_ = true;
        if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    }
    news_.notify_all();
}

/// An interrupt that comes from now on is for what begins now.
void AskedDevice::be_patient() {
    interrupts_ = 0;
    if (device_) device_->set_interrupt(settings_.interrupt);
}

void AskedDevice::identify() {
    finish();
    be_patient();
    begin([this] {
        if (device_)
            device_->identify();
        else
            device_ = std::make_unique<Device>(settings_);
        replies_ = {Reply{.command = Command::identify, .data = device_->identity_block()}};
    });
}

Client& AskedDevice::identified() const {
    if (busy()) throw bad_argument("link", "what was asked goes on; wait for it");
    if (!device_) throw bad_argument("link", "its board was not identified yet");
    return *device_;
}

void AskedDevice::ask(std::vector<Request> requests, When when) {
    for (const Request& request : requests)
        if (request.command == Command::identify || request.command == Command::stream)
            throw bad_argument("requests",
                               fmt::format("{} is no request; there is a function for it", to_string(request.command)));
    if (when != When::at_once() && requests.size() != 1)
        throw bad_argument("gate", fmt::format("found {} requests, expected the one that waits", requests.size()));
    finish();
    Client& device = identified();
    be_patient();
    begin([this, &device, requests = std::move(requests), when]() mutable {
        std::ranges::for_each(requests, [this](const Request& request) { note(request); });
        if (when == When::at_once())
            replies_ = device.pipeline(std::move(requests));
        else
            replies_ = {device.request(std::move(requests.front()), when)};
    });
}

/// What becomes of the watchdog.
void AskedDevice::note(const Request& request) {
    if (request.command == Command::reset || request.command == Command::sync) watchdog_ms_.reset();
    if (request.command == Command::watchdog && request.payload.size() == 2)
        watchdog_ms_ = static_cast<std::uint16_t>(request.payload[0] | request.payload[1] << 8U);
}

void AskedDevice::shut_off() {
    finish();
    begin([this] { turn_off(); });
}

/// Who has interrupted what went on before waits no longer than must be.
void AskedDevice::turn_off() {
    if (!device_) {
        device_ = std::make_unique<Client>(open_port_to_turn_off(settings_));
        device_->set_interrupt(settings_.interrupt);
    }
    device_->keep_alive_every({});
    if (!device_->turn_off()) throw Error(ErrorCode::device, "board", not_confirmed(watchdog_ms_));
}

const std::vector<Reply>& AskedDevice::replies() const {
    if (busy()) throw bad_argument("link", "what was asked goes on; wait for it");
    return replies_;
}

void AskedDevice::stream(std::uint64_t period, const std::uint16_t* words, std::size_t patterns) {
    constexpr std::size_t around = 8;  // number, command and period
    Client& device = identified();
    const Identity& identity = device.identity();
    if (identity.channels == 0) throw bad_argument("link", "its board was not identified yet");
    const std::size_t most = std::max<std::size_t>(1, (identity.frame_bytes - around) / (2 * identity.channels));
    for (std::size_t sent = 0; sent < patterns; sent += most) {
        const std::size_t count = std::min(most, patterns - sent);
        device.tell(stream_request(period + sent, {words + sent * identity.channels, count * identity.channels}));
    }
    device.flush();
}

void AskedDevice::keep_alive_every(std::chrono::milliseconds pause) { identified().keep_alive_every(pause); }

}  // namespace haptogram::link
