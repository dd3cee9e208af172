// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "haptogram/format/bundle.hpp"
#include "haptogram/link/background_thread.hpp"
#include "haptogram/link/device_thread.hpp"
#include "haptogram/link/intensity.hpp"
#include "haptogram/link/live_focus.hpp"
#include "haptogram/link/pattern_queue.hpp"
#include "haptogram/link/pattern_stream.hpp"

namespace haptogram::link {

/// How something is played in the background.
struct BackgroundPlay {
    std::optional<std::uint16_t> loops{};  ///< of an image; 0: for ever
    std::optional<double> step_s{};        ///< of live foci
    std::uint16_t watchdog_ms = 500;
    double seconds = 0.0;
    std::string am{};
    /// Of live foci and patterns: silent when no newer one came for so long. 0: it stays; by default the watchdog's
    /// time, because the thread here keeps the watchdog quiet while the program's own may hang.
    std::optional<std::uint32_t> stale_ms{};
};

/// What goes on while something plays in the background.
struct BackgroundWork {
    bool busy = false;
    std::uint64_t sent = 0;  ///< live foci or patterns
    double lead_s = 0.0;     ///< what the board has in hand of them
    std::uint64_t late_patterns = 0, lost_patterns = 0;
    std::string trouble{};  ///< what ended it, until wait() has thrown that
};

/// A board behind a port, for callers that do not wait: what plays does so in a thread of its own.
class BackgroundPlayer {
public:
    /// @param open  opens the port; called in the thread that drives the board, again after a loss
    /// @param clock  of the line
    /// @throws Error{device} when nobody answers within the patience
    BackgroundPlayer(std::function<std::unique_ptr<Transport>()> open, std::chrono::milliseconds patience,
                     Clock& clock = machine_clock());
    BackgroundPlayer(const BackgroundPlayer&) = delete;
    BackgroundPlayer& operator=(const BackgroundPlayer&) = delete;
    ~BackgroundPlayer();
    /// Turns the outputs off, waiting some two seconds at most. Every later call is refused.
    void end();

    [[nodiscard]] const Clock& clock() const { return clock_; }
    [[nodiscard]] DeviceState state() const { return device_.state(); }
    [[nodiscard]] BackgroundWork work() const;

    void upload(const Bundle& bundle);
    /// These three throw Error{bad_argument} naming a setting that has no meaning with what is to play.
    void play(const BackgroundPlay& how);
    void play_live(const BackgroundPlay& how);
    /// What is put is forgotten when what plays ends: the next one begins silent. @throws as FocusMailbox::put()
    void set_focus(const Focus& focus) { mailbox_.put(focus); }
    /// Plays the patterns of amplitudes that are put there, each for a carrier period, and then the last one on.
    void play_patterns(const BackgroundPlay& how);
    [[nodiscard]] PatternQueue& patterns() { return patterns_; }
    /// Forgets the focus and the patterns that were put.
    void clear();
    /// @return whether what was begun goes on  @throws what ended it, once
    bool wait(std::chrono::milliseconds patience);
    void stop();
    void shut_off();
    void set_intensity(double factor);
    /// Something that ends soon, beside what plays.
    void ask(const std::function<void(Commands&)>& work) { work(*device_.channel()); }

private:
    /// Told what goes on; false ends it.
    using Told = std::function<bool(const BackgroundWork&)>;

    void begin(std::function<void(Commands&)> work);
    void begin_live(const BackgroundPlay& how, double carrier_hz,
                    const std::function<void(Commands&, const Told&)>& work);
    [[nodiscard]] bool is_weighed(const Commands& device) const;
    [[nodiscard]] std::shared_ptr<void> modulated(Commands& device, const Modulation& modulation);
    void modulate_as_uploaded(Commands& device);
    void settle();

    Clock& clock_;
    FocusMailbox mailbox_{clock_};
    DeviceThread device_;
    PatternQueue patterns_;
    mutable std::mutex mutex_;
    std::optional<Intensity> intensity_;
    std::optional<SampledModulation> uploaded_modulation_;
    bool all_amplitudes_ = false;    // of its records, every one
    bool other_modulation_ = false;  // a waveform is in the board, in the place of what was uploaded
    mutable std::mutex work_mutex_;  // never held while the board is waited for, as the other one is
    BackgroundWork work_;
    BackgroundThread thread_{clock_};
};

}  // namespace haptogram::link
