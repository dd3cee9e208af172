// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/background_player.hpp"

#include <fmt/format.h>

#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/modulate.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

constexpr std::chrono::seconds confirmation{2};

}  // namespace

BackgroundPlayer::BackgroundPlayer(std::function<std::unique_ptr<Transport>()> open, std::chrono::milliseconds patience)
    : device_({.open = std::move(open)}) {
    static_cast<void>(device_.channel(patience));
}

BackgroundPlayer::~BackgroundPlayer() {
    device_.end();
    join();
}

std::tuple<bool, std::uint64_t, double> BackgroundPlayer::work() const {
    const std::lock_guard lock(mutex_);
    return {busy_, live_.sent, live_.lead_s};
}

void BackgroundPlayer::upload(const Bundle& bundle) {
    const auto device = device_.channel();
    require_fits(bundle.image, device->identity(), bundle.name);
    link::upload(*device, bundle.image);
    const std::lock_guard lock(mutex_);
    intensity_.emplace(bundle.image);
}

void BackgroundPlayer::begin(std::function<void(Commands&)> work) {
    const std::lock_guard one(beginning_);
    {
        const std::lock_guard lock(mutex_);
        if (busy_) throw bad_argument("play", "something plays already; stop it first");
    }
    if (thread_.joinable()) thread_.join();
    std::shared_ptr<Commands> device = device_.channel();
    end_ = false;
    const std::lock_guard lock(mutex_);
    busy_ = true;
    trouble_ = nullptr;
    live_ = {};
    thread_ = std::thread([this, device, work = std::move(work)] {
        std::exception_ptr trouble;
        try {
            work(*device);
        } catch (...) {
            trouble = std::current_exception();
        }
        const std::lock_guard done(mutex_);
        busy_ = false;
        trouble_ = trouble;
        ended_.notify_all();
    });
}

void BackgroundPlayer::play(const BackgroundPlay& how) {
    begin([this, how](Commands& device) {
        const PlaySettings settings{
            .loops = how.loops, .seconds = how.seconds, .watchdog_ms = how.watchdog_ms, .am = {.waveform = how.am}};
        link::play(device, settings, [this](const Playing&) { return !end_; });
    });
}

void BackgroundPlayer::play_live(const BackgroundPlay& how) {
    begin([this, how](Commands& device) {
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(how.seconds);
        std::optional<ModulationOn> modulated;
        if (!how.am.empty()) modulated.emplace(device, modulation_of({.waveform = how.am}, device));
        const auto watch = [&](const LiveFocusPlaying& now) {
            const std::lock_guard lock(mutex_);
            live_ = now;
            return !end_ && (how.seconds == 0.0 || std::chrono::steady_clock::now() < until);
        };
        play_live_focus(device, {.watchdog_ms = how.watchdog_ms, .step_s = how.step_s}, mailbox_, watch);
    });
}

bool BackgroundPlayer::wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!ended_.wait_for(lock, patience, [&] { return !busy_; })) return true;
    lock.unlock();
    settle();
    lock.lock();
    if (const auto trouble = std::exchange(trouble_, nullptr)) std::rethrow_exception(trouble);
    return false;
}

/// Until the board's own status says what it has confirmed: the next one is soon to come.
void BackgroundPlayer::settle() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    while (device_.state().status.enabled && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void BackgroundPlayer::join() {
    const std::lock_guard one(beginning_);
    if (thread_.joinable()) thread_.join();
}

void BackgroundPlayer::stop() {
    end_ = true;
    join();
    static_cast<void>(wait({}));
}

void BackgroundPlayer::shut_off() {
    end_ = true;
    const std::uint64_t asked = device_.shut_off();
    if (!device_.wait_off(asked, confirmation))
        throw Error(ErrorCode::device, "board", not_confirmed(device_.state().status.watchdog_ms));
    join();
    const std::lock_guard lock(mutex_);
    trouble_ = nullptr;  // that it was shut off is what was asked for
}

void BackgroundPlayer::set_intensity(double factor) {
    const auto device = device_.channel();
    const std::lock_guard lock(mutex_);
    if (!intensity_) throw bad_argument("intensity", "no image was uploaded here, so there is nothing to weaken");
    intensity_->set(*device, factor);
}

}  // namespace haptogram::link
