// SPDX-License-Identifier: Apache-2.0
#include "board.hpp"

#include <fmt/format.h>

#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/modulate.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/transfer.hpp"
#ifdef HAPTOGRAM_HAS_SIMULATION
#include "real_time_transport.hpp"
#include "reference_board.hpp"
#endif

namespace haptogram::c {
namespace {

constexpr std::string_view simulated = "reference:";
constexpr std::chrono::seconds confirmation{2};

#ifdef HAPTOGRAM_HAS_SIMULATION
/// A simulated board and its line.
class ReferencePort final : public link::Transport {
public:
    explicit ReferencePort(const std::string& configuration) : board_(configuration), line_(board_) {}
    void write(std::span<const std::uint8_t> bytes) override { line_.write(bytes); }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        return line_.read(patience);
    }
    [[nodiscard]] std::chrono::nanoseconds now() const override { return line_.now(); }

private:
    sim::ReferenceBoard board_;
    sim::RealTimeTransport line_;
};

std::unique_ptr<link::Transport> open_simulated(const std::string& configuration) {
    return std::make_unique<ReferencePort>(configuration);
}
#else
std::unique_ptr<link::Transport> open_simulated(const std::string& /*configuration*/) {
    throw bad_argument("port", "this build has no simulated board; name a serial port");
}
#endif

std::unique_ptr<link::Transport> open(const std::string& port, std::uint32_t baud) {
    if (port.starts_with(simulated)) return open_simulated(port.substr(simulated.size()));
    return link::open_port({.port = port, .baud = baud != 0 ? std::optional(baud) : std::nullopt});
}

link::DeviceThread::Settings settings_for(const std::string& port, std::uint32_t baud) {
    if (port.starts_with(simulated)) static_cast<void>(open(port, baud));  // a wrong name is said here
    return {.open = [=] { return open(port, baud); }};
}

}  // namespace

Board::Board(const std::string& port, std::uint32_t baud, std::chrono::milliseconds patience)
    : device_(settings_for(port, baud)) {
    static_cast<void>(device_.channel(patience));
}

Board::~Board() {
    device_.end();
    join();
}

std::tuple<bool, std::uint64_t, double> Board::work() const {
    const std::lock_guard lock(mutex_);
    return {busy_, live_.sent, live_.lead_s};
}

void Board::upload(const Bundle& bundle) {
    const auto device = device_.channel();
    link::require_fits(bundle.image, device->identity(), bundle.name);
    link::upload(*device, bundle.image);
    const std::lock_guard lock(mutex_);
    intensity_.emplace(bundle.image);
}

void Board::begin(std::function<void(link::Commands&)> work) {
    const std::lock_guard one(beginning_);
    {
        const std::lock_guard lock(mutex_);
        if (busy_) throw bad_argument("play", "something plays already; stop it first");
    }
    if (thread_.joinable()) thread_.join();
    std::shared_ptr<link::Commands> device = device_.channel();
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

void Board::play(const Playing& playing) {
    begin([this, playing](link::Commands& device) {
        const link::PlaySettings settings{.loops = playing.loops,
                                          .seconds = playing.seconds,
                                          .watchdog_ms = playing.watchdog_ms,
                                          .am = {.waveform = playing.am}};
        link::play(device, settings, [this](const link::Playing&) { return !end_; });
    });
}

void Board::play_live(const Playing& playing) {
    begin([this, playing](link::Commands& device) {
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(playing.seconds);
        std::optional<link::ModulationOn> modulated;
        if (!playing.am.empty()) modulated.emplace(device, link::modulation_of({.waveform = playing.am}, device));
        const auto watch = [&](const link::LiveFocusPlaying& now) {
            const std::lock_guard lock(mutex_);
            live_ = now;
            return !end_ && (playing.seconds == 0.0 || std::chrono::steady_clock::now() < until);
        };
        link::play_live_focus(device, {.watchdog_ms = playing.watchdog_ms, .step_s = playing.step_s}, mailbox_, watch);
    });
}

bool Board::wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!ended_.wait_for(lock, patience, [&] { return !busy_; })) return true;
    lock.unlock();
    settle();
    lock.lock();
    if (const auto trouble = std::exchange(trouble_, nullptr)) std::rethrow_exception(trouble);
    return false;
}

/// Until the board's own status says what it has confirmed: the next one is soon to come.
void Board::settle() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    while (device_.state().status.enabled && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void Board::join() {
    const std::lock_guard one(beginning_);
    if (thread_.joinable()) thread_.join();
}

void Board::stop() {
    end_ = true;
    join();
    static_cast<void>(wait({}));
}

void Board::shut_off() {
    end_ = true;
    const std::uint64_t asked = device_.shut_off();
    if (!device_.wait_off(asked, confirmation))
        throw Error(ErrorCode::device, "board", link::not_confirmed(device_.state().status.watchdog_ms));
    join();
    const std::lock_guard lock(mutex_);
    trouble_ = nullptr;  // that it was shut off is what was asked for
}

void Board::set_intensity(double factor) {
    const auto device = device_.channel();
    const std::lock_guard lock(mutex_);
    if (!intensity_) throw bad_argument("intensity", "no image was uploaded here, so there is nothing to weaken");
    intensity_->set(*device, factor);
}

}  // namespace haptogram::c
