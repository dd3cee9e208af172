// SPDX-License-Identifier: Apache-2.0
#include "player.hpp"

#include <fmt/format.h>

#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/port_rates.hpp"
#include "haptogram/link/stream.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "messages.hpp"

namespace haptogram::studio {

using nlohmann::ordered_json;

/// The record that a stream plays: the one that was asked for last.
class Player::Scrub final : public link::StreamSource {
public:
    Scrub(std::shared_ptr<const Scene> of, link::Clock& clock) : scene(std::move(of)), clock_(clock) {}

    void put(std::uint16_t index) {
        {
            const std::lock_guard lock(mutex_);
            asked_ = last_ = index;
        }
        changed_.notify_all();
    }
    /// The same record once more, which has changed in the board's memory.
    void again() {
        {
            const std::lock_guard lock(mutex_);
            if (!asked_) asked_ = last_;
        }
        changed_.notify_all();
    }
    std::optional<SequenceEntry> next(std::chrono::milliseconds patience) override {
        std::unique_lock lock(mutex_);
        clock_.wait_for(lock, changed_, patience, [this] { return asked_.has_value(); });
        if (!asked_) return {};
        return SequenceEntry{*std::exchange(asked_, {}), 0};  // until the next arrives
    }
    [[nodiscard]] bool ended() const override { return false; }

    const std::shared_ptr<const Scene> scene;
    std::uint64_t number = 0;  ///< of the work

private:
    link::Clock& clock_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<std::uint16_t> asked_;
    std::uint16_t last_ = 0;
};

/// The parts that are to start.
class Player::Fired final : public link::TriggerSource {
public:
    /// @param lines  that start them, too
    Fired(std::size_t parts, std::unique_ptr<TriggerReader> lines, link::Clock& clock)
        : parts_(parts), lines_(std::move(lines)), clock_(clock) {}

    void put(std::size_t part) {
        if (part >= parts_) throw bad_argument("trigger", fmt::format("found {}, of {} from 0 on", part, parts_));
        {
            const std::lock_guard lock(mutex_);
            asked_ = part;
        }
        changed_.notify_all();
    }
    std::optional<std::size_t> next(std::chrono::milliseconds patience) override {
        if (lines_)
            if (const auto fired = lines_->next(std::chrono::milliseconds(1))) return fired;
        std::unique_lock lock(mutex_);
        clock_.wait_for(lock, changed_, lines_ ? std::min(patience, lines_pause) : patience,
                        [this] { return asked_.has_value(); });
        return std::exchange(asked_, {});
    }
    [[nodiscard]] bool ended() const override { return false; }

private:
    static constexpr std::chrono::milliseconds lines_pause{5};

    const std::size_t parts_;
    const std::unique_ptr<TriggerReader> lines_;
    link::Clock& clock_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<std::size_t> asked_;
};

Player::Player(Settings settings) : settings_(std::move(settings)), thread_([this] { run(); }) {}

Player::~Player() {
    disconnect();
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    changed_.notify_all();
    let_go_.clear();
    thread_.join();
}

void Player::connect(const std::string& port, std::optional<std::uint32_t> baud) {
    disconnect();
    given_up_ = std::make_shared<std::atomic<bool>>(false);
    const auto open = [port, baud, over = given_up_]() mutable {
        auto line = link::open_port({.port = port, .baud = baud, .interrupt = [over] { return *over ? 1U : 0U; }});
        line->set_interrupt({});                        // what turns the outputs off is not to be cut short
        if (!baud) baud = link::remembered_rate(port);  // it is not looked for again: a board that is lost is known
        return line;
    };
    connect(open, {port, baud}, nullptr);
}

void Player::connect_virtual(const Core& core, const std::string& model) {
    auto board = std::make_shared<VirtualBoard>(core, model);
    connect([board] { return board->open(); }, {}, board);
}

void Player::connect(Open open, BoardPort port, std::shared_ptr<VirtualBoard> board) {
    disconnect();
    {
        const std::lock_guard lock(mutex_);
        open_ = std::move(open);
        port_ = std::move(port);
        board_ = std::move(board);
    }
    take_back();
}

void Player::take_back() {
    *given_up_ = false;
    const auto listened_to = std::make_shared<std::atomic<bool>>(true);
    const auto told = [this, listened_to](const link::DeviceState& state) {
        if (*listened_to) settings_.told(state);
    };
    auto device = std::make_shared<link::DeviceThread>(
        link::DeviceThread::Settings{.open = open_, .told = told, .clock = settings_.clock});
    const std::lock_guard lock(mutex_);
    device_ = std::move(device);
    listened_to_ = listened_to;
}

/// A board that is silent, or talks of other things, takes some seconds to be let go of. The mutex is held.
void Player::let_go(std::shared_ptr<link::DeviceThread> device, std::shared_ptr<VirtualBoard> board,
                    std::function<void()> free) {
    if (!device) return;
    *listened_to_ = false;
    *given_up_ = true;
    std::erase_if(let_go_,
                  [](const auto& one) { return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
    let_go_.push_back(std::async(
        std::launch::async, [device = std::move(device), board = std::move(board), free = std::move(free)]() mutable {
            device->end();  // who works with it is told so; only then its board goes
            device.reset();
            board.reset();
            if (free) free();
        }));
}

BoardPort Player::lend(std::function<void()> free) {
    stop();
    const std::lock_guard lock(mutex_);
    if (!device_) throw Error(ErrorCode::device, "board", "there is no connection; connect to a board first");
    const auto found = board_ ? board_->port() : port_;
    if (!found) throw Error(ErrorCode::device, "board", "the virtual board is still starting; wait for it");
    let_go(std::move(device_), nullptr, std::move(free));
    return *found;
}

void Player::disconnect() {
    stop();
    const std::lock_guard lock(mutex_);
    let_go(std::move(device_), std::move(board_), {});
}

bool Player::connected() const {
    const std::lock_guard lock(mutex_);
    return device_ != nullptr;
}

std::optional<std::uint64_t> Player::stop() {
    const std::lock_guard lock(mutex_);
    ++stops_;
    scrub_.reset();
    for (const Work& work : std::exchange(waiting_, {}))
        settings_.work({{"t", "stopped"}, {"work", work.name}, {"number", work.number}});
    if (!device_) return {};
    return device_->shut_off();
}

std::uint64_t Player::ask(Work work) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        if (!device_)
            throw Error(ErrorCode::device, "board", "there is no connection; start a virtual board or connect");
        work.number = number = ++asked_;
        work.stops = stops_;
        if (work.scrub) {
            work.scrub->number = number;
            scrub_ = work.scrub;
        }
        waiting_.push_back(std::move(work));
    }
    changed_.notify_all();
    return number;
}

void Player::tell_progress(const char* name, std::uint64_t number, double fraction, std::string_view stage) const {
    settings_.work({{"t", "progress"}, {"work", name}, {"number", number}, {"fraction", fraction}, {"stage", stage}});
}

void Player::bring(link::Commands& device, const char* name, std::uint64_t number, const Scene& scene,
                   ordered_json& report) const {
    const Image& image = scene.compiled.bundle.image;
    link::require_fits(image, device.identity(), "scene");
    const link::Uploaded uploaded =
        link::upload(device, image, Progress([this, name, number](double fraction, std::string_view) {
                         tell_progress(name, number, fraction, "upload");
                         return true;
                     }));
    report["frames"] = uploaded.pieces;
    report["frames_written"] = uploaded.written;
}

void Player::set_intensity(double factor) {
    if (!(factor >= 0.0 && factor <= 1.0))
        throw bad_argument("intensity", fmt::format("found {}, expected 0 to 1", factor));
    intensity_ = factor;
}

void Player::modulate(std::shared_ptr<const Scene> scene) {
    const std::lock_guard lock(mutex_);
    if (!playing_) throw Error(ErrorCode::device, "board", "it plays no scene; press Play");
    Image other = scene->compiled.bundle.image;
    const Image& image = playing_->compiled.bundle.image;
    other.modulation = image.modulation;
    if (other != image)
        throw bad_input("scene", "it differs from the one that plays in more than its modulation; press STOP and Play");
    if (!link::can_be_modulated(image))
        throw bad_input("scene", "the board that it is for has no modulation of its own; press STOP and Play");
    modulation_ = std::move(scene);
}

/// Tells which scene plays and for how long it has, and makes it as strong as is wanted, from before its first pulse
/// on.
/// @param changed  told when it has become stronger or weaker
link::Watch Player::watch(link::Commands& device, const char* name, std::uint64_t number,
                          std::shared_ptr<const Scene> scene, link::Intensity& intensity,
                          std::function<void()> changed) {
    const double first = intensity_;
    if (first != 1.0) intensity.set(device, first);
    return [this, name, number, &device, scene = std::move(scene), &intensity, changed = std::move(changed),
            shown = first](const link::Playing& now) mutable {
        const double wanted = intensity_;
        if (wanted != std::exchange(shown, wanted)) {
            intensity.set(device, wanted);
            changed();
        }
        std::shared_ptr<const Scene> other;
        {
            const std::lock_guard lock(mutex_);
            other = std::exchange(modulation_, nullptr);
        }
        if (other) {
            intensity.modulate(device, other->compiled.bundle.image.modulation);
            scene = other;
        }
        settings_.work({{"t", "progress"},
                        {"work", name},
                        {"number", number},
                        {"seconds", now.seconds},
                        {"stage", "play"},
                        {"scene", scene->name}});
        return true;
    };
}

std::uint64_t Player::upload(std::shared_ptr<const Scene> scene) {
    const auto act = [this, scene = std::move(scene)](link::Commands& device, std::uint64_t number) {
        ordered_json report;
        bring(device, "upload", number, *scene, report);
        return report;
    };
    return ask({.name = "upload", .act = act});
}

std::uint64_t Player::play(std::shared_ptr<const Scene> scene, std::vector<TriggeredPart> parts,
                           const std::string& lines) {
    if (!lines.empty() && (parts.empty() || parts.size() != scene->settings.triggers.size()))
        throw bad_argument("lines",
                           fmt::format("they start the {} parts of the scene's triggers, and {} are to be played",
                                       scene->settings.triggers.size(), parts.size()));
    // A wrong pipe is said before anything is brought. It stays open, because a writer would fail when it is closed.
    const auto text = lines.empty() ? nullptr : std::make_shared<LiveText>(LiveText::of_pipe(lines, "lines"));
    const auto act = [this, scene = std::move(scene), parts = std::move(parts), text](link::Commands& device,
                                                                                      std::uint64_t number) {
        ordered_json report;
        bring(device, "play", number, *scene, report);
        link::Intensity intensity(scene->compiled.bundle.image);
        const auto fired =
            parts.empty() ? nullptr
                          : std::make_shared<Fired>(parts.size(), reader(*scene, text.get(), number), settings_.clock);
        {
            const std::lock_guard lock(mutex_);
            playing_ = scene;
            fired_ = fired;
        }
        const link::Watch told = watch(device, "play", number, scene, intensity, [] {});
        const link::Played played = fired ? link::play(device, {}, parts, *fired, told) : link::play(device, {}, told);
        report.update(link::played_to_json(played));
        return report;
    };
    return ask({.name = "play", .act = act});
}

std::unique_ptr<TriggerReader> Player::reader(const Scene& scene, LiveText* lines, std::uint64_t number) const {
    if (lines == nullptr) return {};
    static constexpr std::chrono::milliseconds between{100};  // pages show the last one
    const auto tell = [this, number, told = std::optional<link::Clock::Time>()](const std::string& wrong) mutable {
        const link::Clock::Time now = settings_.clock.now();
        if (told && now - *told < between) return;
        told = now;
        settings_.work({{"t", "progress"}, {"work", "play"}, {"number", number}, {"stage", "play"}, {"line", wrong}});
    };
    return std::make_unique<TriggerReader>(scene.settings.triggers, std::move(*lines), tell, settings_.clock);
}

void Player::trigger(std::size_t part) {
    const std::lock_guard lock(mutex_);
    if (!fired_) throw Error(ErrorCode::device, "board", "nothing waits for this trigger; press Play");
    fired_->put(part);
}

std::uint64_t Player::stream(std::shared_ptr<const Scene> scene, std::uint32_t index) {
    if (!place_of(scene->compiled.bundle.image, index))
        throw bad_argument("index", fmt::format("{} is no record of the scene", index));
    {
        const std::lock_guard lock(mutex_);
        if (scrub_ && scrub_->scene != scene)
            throw Error(ErrorCode::device, "board", "it streams another scene; press STOP first");
        if (scrub_) {
            scrub_->put(static_cast<std::uint16_t>(index));
            return scrub_->number;
        }
    }
    const auto scrub = std::make_shared<Scrub>(std::move(scene), settings_.clock);
    scrub->put(static_cast<std::uint16_t>(index));
    const auto act = [this, scrub](link::Commands& device, std::uint64_t number) {
        ordered_json report;
        bring(device, "stream", number, *scrub->scene, report);
        link::Intensity intensity(scrub->scene->compiled.bundle.image);
        const link::Played played = link::stream(
            device, {}, *scrub, watch(device, "stream", number, scrub->scene, intensity, [scrub] { scrub->again(); }));
        report.update(link::played_to_json(played));
        return report;
    };
    return ask({.name = "stream", .act = act, .scrub = scrub});
}

void Player::run() {
    for (;;) {
        Work work;
        std::shared_ptr<link::DeviceThread> device;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return over_ || !waiting_.empty(); });
            if (over_) return;
            work = std::move(waiting_.front());
            waiting_.pop_front();
            device = device_;
        }
        ordered_json report{{"t", "done"}, {"work", work.name}, {"number", work.number}};
        try {
            if (!device) throw Error(ErrorCode::cancelled, {}, "the connection was closed");
            const auto channel = device->channel(std::chrono::seconds(20));  // a virtual board may still be starting
            device.reset();                                                  // a channel may outlive its device
            {
                // A channel that was opened after stop() would play on; one that was opened before it is cancelled.
                const std::lock_guard lock(mutex_);
                if (work.stops != stops_) throw Error(ErrorCode::cancelled, {}, "stopped");
            }
            report["report"] = work.act(*channel, work.number);
        } catch (const Error& error) {
            report["t"] = error.code() == ErrorCode::cancelled ? "stopped" : "failed";
            report["error"] = to_json(error);
        } catch (const std::exception& error) {
            report["t"] = "failed";
            report["error"] = {{"where", work.name}, {"message", error.what()}};
        }
        {
            const std::lock_guard lock(mutex_);
            if (work.scrub && scrub_ == work.scrub) scrub_.reset();
            playing_.reset();
            fired_.reset();
            modulation_.reset();
        }
        settings_.work(std::move(report));
    }
}

}  // namespace haptogram::studio
