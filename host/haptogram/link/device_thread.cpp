// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device_thread.hpp"

#include <utility>

namespace haptogram::link {

DeviceThread::DeviceThread(Settings settings) : steps_(std::make_shared<DeviceSteps>(std::move(settings))) {
    thread_ = steps_->clock().begin([steps = steps_] { steps->run(); });
}

DeviceThread::~DeviceThread() { end(); }

void DeviceThread::end() {
    steps_->end();
    const std::lock_guard joining(joining_);
    if (thread_.joinable()) steps_->clock().join(thread_);
}

std::unique_ptr<Commands> DeviceThread::channel(std::chrono::milliseconds patience) {
    return steps_->channel(patience);
}

std::uint64_t DeviceThread::shut_off() { return steps_->shut_off(); }

bool DeviceThread::wait_off(std::uint64_t shut_off, std::chrono::milliseconds patience) {
    return steps_->wait_off(shut_off, patience);
}

DeviceState DeviceThread::state() const { return steps_->state(); }

}  // namespace haptogram::link
