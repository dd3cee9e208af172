// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/background_thread.hpp"

#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::link {

void BackgroundThread::begin(const std::function<std::function<void()>()>& prepare) {
    const std::lock_guard one(beginning_);
    if (busy()) throw bad_argument("play", "something plays already; stop it first");
    if (thread_.joinable()) clock_.join(thread_);
    std::function<void()> work = prepare();
    if (ending()) throw Error(ErrorCode::cancelled, "play", "it was stopped before it had begun");
    const std::lock_guard lock(mutex_);
    busy_ = true;
    trouble_ = nullptr;
    thread_ = clock_.begin([this, work = std::move(work)]() mutable {
        std::exception_ptr trouble;
        try {
            work();
        } catch (...) {
            trouble = std::current_exception();
        }
        work = nullptr;  // what it holds of the board goes before anybody hears that it has ended
        const std::lock_guard done(mutex_);
        busy_ = false;
        trouble_ = trouble;
        ended_.notify_all();
    });
}

bool BackgroundThread::busy() const {
    const std::lock_guard lock(mutex_);
    return busy_;
}

bool BackgroundThread::wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!clock_.wait_for(lock, ended_, patience, [&] { return !busy_; })) return true;
    if (const auto trouble = std::exchange(trouble_, nullptr)) std::rethrow_exception(trouble);
    return false;
}

void BackgroundThread::end() {
    ++enders_;
    const std::lock_guard one(beginning_);
    if (thread_.joinable()) clock_.join(thread_);
    --enders_;
}

std::string BackgroundThread::trouble() const {
    const std::lock_guard lock(mutex_);
    if (!trouble_) return {};
    try {
        std::rethrow_exception(trouble_);
    } catch (const std::exception& error) {
        return error.what();
    } catch (...) {
        return "an unknown exception";
    }
}

void BackgroundThread::forget_trouble() {
    const std::lock_guard lock(mutex_);
    trouble_ = nullptr;
}

}  // namespace haptogram::link
