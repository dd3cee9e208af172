// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/background_player.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/modulate.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

constexpr std::chrono::seconds confirmation{2};

void require_unset(bool set, const char* setting, const char* with) {
    if (set) throw bad_argument(setting, fmt::format("has no meaning with {}; leave it out", with));
}

std::chrono::milliseconds most_age(const BackgroundPlay& how) {
    return std::chrono::milliseconds(how.stale_ms.value_or(how.watchdog_ms));
}

}  // namespace

BackgroundPlayer::BackgroundPlayer(std::function<std::unique_ptr<Transport>()> open, std::chrono::milliseconds patience,
                                   Clock& clock)
    : clock_(clock),
      device_({.open = std::move(open), .clock = clock}),
      patterns_(device_.channel(patience)->identity().channels, clock) {}

BackgroundPlayer::~BackgroundPlayer() { end(); }

void BackgroundPlayer::end() {
    device_.end();
    thread_.end();
}

BackgroundWork BackgroundPlayer::work() const {
    const bool busy = thread_.busy();
    const std::lock_guard lock(work_mutex_);
    BackgroundWork work = work_;
    work.busy = busy;
    work.trouble = thread_.trouble();
    return work;
}

void BackgroundPlayer::upload(const Bundle& bundle) {
    const auto device = device_.channel();
    require_fits(bundle.image, device->identity(), bundle.name);
    link::upload(*device, bundle.image);
    const std::lock_guard lock(mutex_);
    intensity_.emplace(bundle.image);
    uploaded_modulation_ = bundle.image.modulation;
    all_amplitudes_ = std::ranges::none_of(
        bundle.image.records, [](const Record& record) { return record.kind == interface::Kind::timings; });
    other_modulation_ = false;
}

/// Whether a waveform and the factor that was set are the same memory's of the device.
bool BackgroundPlayer::is_weighed(const Commands& device) const {
    const std::lock_guard lock(mutex_);
    // Of records that have timings link::play() says which.
    return intensity_ && intensity_->has_amplitudes() && all_amplitudes_ && device.identity().modulation_words > 0;
}

/// A waveform while the result lives, of the factor that was set; what set_intensity() does then is of the waveform.
std::shared_ptr<void> BackgroundPlayer::modulated(Commands& device, const Modulation& modulation) {
    const std::lock_guard lock(mutex_);
    // An image that somebody else uploaded has no factor here.
    if (!intensity_ || !intensity_->has_amplitudes()) return std::make_shared<ModulationOn>(device, modulation);
    const SampledModulation samples = sampled(modulation, std::size_t{2} * device.identity().modulation_words, "board");
    other_modulation_ = true;
    intensity_->modulate(device, samples);
    return {this, [this, &device](void*) {
                try {
                    modulate_as_uploaded(device);
                } catch (const Error&) {  // the outputs were shut off, or the board is gone: before it plays next
                }
            }};
}

void BackgroundPlayer::modulate_as_uploaded(Commands& device) {
    const std::lock_guard lock(mutex_);
    if (!other_modulation_) return;
    intensity_->modulate(device, uploaded_modulation_);
    other_modulation_ = false;
}

void BackgroundPlayer::begin(std::function<void(Commands&)> work) {
    thread_.begin([&] {
        const std::shared_ptr<Commands> device = device_.channel();
        const std::lock_guard lock(work_mutex_);
        work_ = {};
        return [this, device, work = std::move(work)] {
            modulate_as_uploaded(*device);
            work(*device);
        };
    });
}

void BackgroundPlayer::play(const BackgroundPlay& how) {
    require_unset(how.step_s.has_value(), "step_s", "an image, which has times of its own");
    require_unset(how.stale_ms.has_value(), "stale_ms", "an image, which plays without this program");
    begin([this, how](Commands& device) {
        PlaySettings settings{
            .loops = how.loops, .seconds = how.seconds, .watchdog_ms = how.watchdog_ms, .am = {.waveform = how.am}};
        std::shared_ptr<void> waveform;
        if (!how.am.empty() && is_weighed(device)) {
            settings.am = {};
            waveform = modulated(device, modulation_of({.waveform = how.am}, device));
        }
        link::play(device, settings, [this](const Playing&) { return !thread_.ending(); });
    });
}

void BackgroundPlayer::play_live(const BackgroundPlay& how) {
    require_unset(how.loops.has_value(), "loops", "live foci, which have no end");
    LiveFocusSettings settings{.watchdog_ms = how.watchdog_ms, .most_age = most_age(how)};
    if (how.step_s) settings.step_s = *how.step_s;
    begin_live(how, 0.0, [this, settings](Commands& device, const Told& told) {
        play_live_focus(device, settings, mailbox_,
                        [&](const LiveFocusPlaying& now) { return told({.sent = now.sent, .lead_s = now.lead_s}); });
    });
}

void BackgroundPlayer::play_patterns(const BackgroundPlay& how) {
    require_unset(how.loops.has_value(), "loops", "live patterns, which have no end");
    require_unset(how.step_s.has_value(), "step_s", "live patterns, of which each lasts one carrier period");
    begin_live(how, 1.0 / pattern_period_s, [this, how](Commands& device, const Told& told) {
        if (device.identity().channels != patterns_.words())
            throw Error(ErrorCode::device, "board",
                        fmt::format("another one answers behind this port: it has {} channels, expected the {} of the "
                                    "one that was opened; open the port again",
                                    device.identity().channels, patterns_.words()));
        const PatternSource source = [this, age = most_age(how)](std::uint64_t, std::span<std::uint16_t> patterns) {
            return std::optional(patterns_.take(patterns, age));
        };
        link::play_patterns(device, {.watchdog_ms = how.watchdog_ms}, source, [&](const PatternsPlaying& now) {
            return told({.sent = now.played.sent,
                         .lead_s = now.played.lead * pattern_period_s,
                         .late_patterns = now.played.late,
                         .lost_patterns = now.played.lost});
        });
    });
}

/// What has no end of its own, under a modulation if one is asked for.
/// @param carrier_hz  of what plays; 0: of what lies in the board
void BackgroundPlayer::begin_live(const BackgroundPlay& how, double carrier_hz,
                                  const std::function<void(Commands&, const Told&)>& work) {
    begin([this, how, carrier_hz, work](Commands& device) {
        const double until_s = clock_.now_s() + how.seconds;
        const std::shared_ptr<void> silent_then(this, [this](void*) { clear(); });
        std::shared_ptr<void> waveform;
        if (!how.am.empty())
            waveform = modulated(device, modulation_of({.waveform = how.am, .carrier_hz = carrier_hz}, device));
        work(device, [&](const BackgroundWork& now) {
            const std::lock_guard lock(work_mutex_);
            work_ = now;
            return !thread_.ending() && (how.seconds == 0.0 || clock_.now_s() < until_s);
        });
    });
}

bool BackgroundPlayer::wait(std::chrono::milliseconds patience) {
    std::exception_ptr trouble;
    try {
        if (thread_.wait(patience)) return true;
    } catch (...) {
        trouble = std::current_exception();
    }
    settle();
    if (trouble) std::rethrow_exception(trouble);
    return false;
}

/// Until the board's own status says what it has confirmed: the next one is soon to come.
void BackgroundPlayer::settle() {
    const Clock::Time end = clock_.now() + std::chrono::milliseconds(500);
    while (device_.state().status.enabled && clock_.now() < end) clock_.rest(std::chrono::milliseconds(1));
}

void BackgroundPlayer::stop() {
    thread_.end();
    static_cast<void>(wait({}));
}

void BackgroundPlayer::shut_off() {
    const std::uint64_t asked = device_.shut_off();
    thread_.end();             // before anything is waited for: what had not begun yet does not begin
    thread_.forget_trouble();  // that it was shut off is what was asked for
    if (!device_.wait_off(asked, confirmation))
        throw Error(ErrorCode::device, "board", not_confirmed(device_.state().status.watchdog_ms));
}

void BackgroundPlayer::clear() {
    mailbox_.clear();
    patterns_.clear();
}

void BackgroundPlayer::set_intensity(double factor) {
    const auto device = device_.channel();
    const std::lock_guard lock(mutex_);
    if (!intensity_) throw bad_argument("intensity", "no image was uploaded here, so there is nothing to weaken");
    intensity_->set(*device, factor);
}

}  // namespace haptogram::link
