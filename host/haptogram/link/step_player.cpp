// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/step_player.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {
namespace {

using interface::Command;
using Stage = StepWork::Stage;

constexpr std::chrono::milliseconds reconnect_pause{200};
constexpr std::chrono::milliseconds longest_slice{20};  // a shut-off is looked at again after so long
constexpr unsigned sure = 2;                            // statuses that must say that all is over: sure_status()

bool is_shutting_off(const Client& client) { return !client.is_off().has_value(); }

/// The part that the pin starts, if there is one, waits for it.
void wait_for_pin(std::vector<Request>& requests, std::span<const TriggeredPart> parts) {
    const TriggeredPart* pin = part_of_pin(parts);
    if (pin == nullptr) return;
    requests.push_back(gate_request(When::at_trigger()));
    requests.push_back(start_request(pin->first, pin->length, pin->loops));
}

}  // namespace

StepPlayer::StepPlayer(std::unique_ptr<Transport> line, Settings settings)
    : settings_(std::move(settings)), line_(std::move(line)), client_(*line_) {
    begin_session();
}

void StepPlayer::begin_session() {
    asking_ = false;
    batch_.reset();
    client_.keep_alive_every({});
    client_.begin([this] {
        state_.connection = Connection::connected;
        state_.identity = client_.identity();
        state_.trouble.clear();
        client_.keep_alive_every(keep_alive_pause(settings_.watchdog_ms));
        ask_for_status();
        tell_state();
    });
}

void StepPlayer::step(std::chrono::microseconds passed) {
    if (gone_) return;
    try {
        if (pause_.count() > 0) {
            pause_ -= std::min(pause_, passed);
            if (pause_.count() > 0) return;
            // What ended the session before may have left the outputs on.
            if (state_.connection == Connection::lost) {
                client_.shut_off();
                turning_off_ = true;
            } else {
                begin_session();
            }
        }
        if (turning_off_) return turn_off(passed);
        client_.exchange(passed);
        since_status_ += passed;
        if (state_.connection == Connection::connected && !asking_ &&
            since_status_ >= keep_alive_pause(settings_.watchdog_ms))
            ask_for_status();
        advance();
        client_.flush();
    } catch (const Error& error) {
        if (state_.connection == Connection::connected) state_.connection = Connection::lost;
        state_.trouble = error.what();
        turning_off_ = false;
        pause_ = reconnect_pause;
        drop_work(Stage::failed, error);
        tell_state();
    }
}

/// @throws LinkLost when the device does not confirm it
void StepPlayer::turn_off(std::chrono::microseconds passed) {
    for (; is_shutting_off(client_) && passed.count() > 0;
         passed -= std::min<std::chrono::microseconds>(passed, longest_slice))
        client_.exchange(std::min<std::chrono::microseconds>(passed, longest_slice));
    if (is_shutting_off(client_)) return;
    turning_off_ = false;
    if (!client_.end_shut_off()) throw LinkLost("board", not_confirmed(settings_.watchdog_ms));
    state_.status.enabled = false;
    state_.confirmed = state_.shut_offs;
    tell_state();
    begin_session();
}

void StepPlayer::ask_for_status() {
    asking_ = true;
    since_status_ = {};
    client_.submit({Command::status, {}}, [this](const Reply& reply) { take_status(to_status(reply.data)); });
}

void StepPlayer::take_status(const Status& status) {
    asking_ = false;
    state_.status = status;
    if (!works_.empty() && works_.front().phase == Phase::plays) {
        Work& work = works_.front();
        work.heard = true;
        work.silent = is_over(status) ? work.silent + 1 : 0;
    }
    tell_state();
}

/// Hands requests to the client. The first that is refused takes those behind it with it.
void StepPlayer::ask(std::vector<Request> requests) {
    batch_ = Batch{.unanswered = requests.size(), .replies = {}};
    for (Request& request : requests)
        client_.submit(
            std::move(request),
            [this](const Reply& reply) {
                if (!batch_) return;
                --batch_->unanswered;
                batch_->replies.push_back(reply);
            },
            [this](const Error& error) {
                if (batch_) batch_->refused = error;
                client_.drop();
                asking_ = false;
            });
}

/// What has been answered lets the work go on.
void StepPlayer::advance() {
    while (!works_.empty() && state_.connection == Connection::connected && !turning_off_) {
        if (batch_ && batch_->refused) return end(Stage::failed, batch_->refused);
        if (batch_ && batch_->unanswered > 0) {
            Work& work = works_.front();
            if (work.phase != Phase::uploads) return;
            const auto tell = [&](double fraction, std::string_view) {
                if (fraction == work.told.fraction) return true;
                work.told.fraction = fraction;
                settings_.work(work.told);
                return true;
            };
            const auto done = static_cast<double>(batch_->replies.size());
            work.upload->part(Progress(tell))(done / (done + static_cast<double>(batch_->unanswered)));
            return;
        }
        try {
            switch (works_.front().phase) {
                case Phase::uploads: advance_upload(); break;
                case Phase::weakens: begin_to_play(); break;
                case Phase::begins:
                    works_.front().phase = Phase::plays;
                    works_.front().begun = line_->clock().now();
                    batch_.reset();
                    break;
                case Phase::plays: return go_on_playing();
                case Phase::ends: end(Stage::done); break;
            }
        } catch (const LinkLost&) {
            throw;
        } catch (const Error& error) {
            return end(Stage::failed, error);
        }
    }
}

void StepPlayer::advance_upload() {
    Work& work = works_.front();
    if (!work.upload) {
        require_fits(*work.image, client_.identity(), "scene");
        work.told.stage = Stage::uploads;
        work.upload.emplace(*work.image, client_.identity());
    }
    if (auto requests = work.upload->next(batch_ ? std::exchange(batch_, {})->replies : std::vector<Reply>{}))
        return ask(std::move(*requests));
    work.told.uploaded = work.upload->uploaded();
    if (work.told.name == "upload") return end(Stage::done);
    if (work.index == 0 && work.image->sequence.empty())
        throw Error(ErrorCode::device, "board", "there is no sequence in the image; give the shape focal points");
    work.intensity.emplace(*work.image);
    work.phase = Phase::weakens;
    work.factor = wanted_;
    // From before its first pulse on.
    if (wanted_ != 1.0) ask(work.intensity->requests(client_.identity(), work.image->modulation.has_value(), wanted_));
}

void StepPlayer::begin_to_play() {
    Work& work = works_.front();
    work.phase = Phase::begins;
    work.shown = work.index;
    work.before = state_.status;
    std::vector<Request> requests{watchdog_request(settings_.watchdog_ms), {Command::enable, {}}};
    if (!work.parts.empty())
        wait_for_pin(requests, work.parts);
    else
        requests.push_back(work.index == 0 ? start_request(1, 0, 0) : select_request(work.index, 0));
    ask(std::move(requests));
}

/// Looks at the newest status, and sends what is to be played otherwise.
void StepPlayer::go_on_playing() {
    Work& work = works_.front();
    batch_.reset();
    if (const auto part = std::exchange(work.triggered, {})) {
        const auto& [first, length, loops, by_pin] = work.parts[*part];
        return ask({start_request(first, length, loops)});
    }
    if (!std::exchange(work.heard, false)) return;
    const Status& now = state_.status;
    require_on(now, &work.before);
    work.told.stage = Stage::plays;
    work.told.seconds = line_->clock().seconds_since(work.begun);
    settings_.work(work.told);
    if (work.silent >= sure && work.index == 0 && work.parts.empty()) {
        work.phase = Phase::ends;
        return ask({{Command::disable, {}}, {Command::stop, {}}});
    }
    if (modulation_) return ask(*std::exchange(modulation_, {}));
    const bool weaker = work.factor != wanted_;
    std::vector<Request> requests;
    if (!now.waiting) wait_for_pin(requests, work.parts);
    if (weaker)
        for (Request& request : work.intensity->requests(client_.identity(), now.modulated, wanted_))
            requests.push_back(std::move(request));
    // A record that is held takes its new strength when it is chosen again.
    if (work.index != 0 && (weaker || work.shown != work.index)) requests.push_back(select_request(work.index, 0));
    work.factor = wanted_;
    work.shown = work.index;
    if (!requests.empty()) ask(std::move(requests));
}

/// Ends the first work. One that has outputs on, and did not end by itself, has them turned off.
void StepPlayer::end(Stage stage, std::optional<Error> error) {
    Work work = std::move(works_.front());
    works_.pop_front();
    batch_.reset();
    modulation_.reset();
    const bool on = work.phase > Phase::weakens && stage != Stage::done;
    work.told.stage = stage;
    work.told.error = std::move(error);
    if (work.phase > Phase::weakens) work.told.played = counted(work.before, state_.status);
    settings_.work(work.told);
    if (on) stop();
}

void StepPlayer::drop_work(Stage stage, const std::optional<Error>& error) {
    batch_.reset();
    modulation_.reset();
    asking_ = false;
    for (Work& work : std::exchange(works_, {})) {
        work.told.stage = stage;
        work.told.error = error;
        settings_.work(work.told);
    }
}

std::uint64_t StepPlayer::add(const char* name, std::shared_ptr<const Image> image, std::uint16_t index,
                              std::vector<TriggeredPart> parts) {
    if (state_.connection != Connection::connected)
        throw Error(ErrorCode::device, "board", state_.trouble.empty() ? "it has not answered yet" : state_.trouble);
    require_fits(*image, state_.identity, "scene");
    require_parts(parts, image->sequence.size(), state_.identity);
    works_.push_back({.told = {.name = name, .number = ++numbers_},
                      .image = std::move(image),
                      .index = index,
                      .parts = std::move(parts)});
    return numbers_;
}

std::uint64_t StepPlayer::upload(std::shared_ptr<const Image> image) { return add("upload", std::move(image), 0); }

std::uint64_t StepPlayer::play(std::shared_ptr<const Image> image, std::vector<TriggeredPart> parts) {
    return add("play", std::move(image), 0, std::move(parts));
}

void StepPlayer::trigger(std::size_t part) {
    if (works_.empty() || works_.front().phase != Phase::plays || part >= works_.front().parts.size())
        throw Error(ErrorCode::device, "board", "nothing waits for this trigger; press Play");
    works_.front().triggered = part;
}

std::uint64_t StepPlayer::stream(std::shared_ptr<const Image> image, std::uint32_t index) {
    if (!place_of(*image, index)) throw bad_argument("index", fmt::format("{} is no record of the scene", index));
    const auto streams = std::ranges::find_if(works_, [](const Work& work) { return work.index != 0; });
    if (streams == works_.end()) return add("stream", std::move(image), static_cast<std::uint16_t>(index));
    if (*streams->image != *image)
        throw Error(ErrorCode::device, "board", "it streams another scene; press STOP first");
    streams->index = static_cast<std::uint16_t>(index);
    return streams->told.number;
}

void StepPlayer::set_intensity(double factor) {
    if (!(factor >= 0.0 && factor <= 1.0))
        throw bad_argument("intensity", fmt::format("found {}, expected 0 to 1", factor));
    wanted_ = factor;
}

void StepPlayer::modulate(const Image& image) {
    if (works_.empty() || works_.front().phase != Phase::plays || works_.front().index != 0)
        throw Error(ErrorCode::device, "board", "it plays no scene; press Play");
    const Image& playing = *works_.front().image;
    Image other = image;
    other.modulation = playing.modulation;
    if (other != playing)
        throw bad_input("scene", "it differs from the one that plays in more than its modulation; press STOP and Play");
    if (!can_be_modulated(playing))
        throw bad_input("scene", "the board that it is for has no modulation of its own; press STOP and Play");
    modulation_ = works_.front().intensity->requests(client_.identity(), image.modulation);
}

std::uint64_t StepPlayer::stop() {
    ++state_.shut_offs;
    drop_work(Stage::stopped, {});
    try {
        if (!gone_) client_.shut_off();
        turning_off_ = !gone_;
        pause_ = {};
    } catch (const Error& error) {
        lose(error.what());
    }
    return state_.shut_offs;
}

void StepPlayer::lose(const std::string& why) {
    gone_ = true;
    turning_off_ = false;
    state_.connection = Connection::lost;
    state_.trouble = why;
    drop_work(Stage::failed, LinkLost("board", why));
    tell_state();
}

bool StepPlayer::drives() const {
    return std::ranges::any_of(works_, [](const Work& work) { return work.told.name != "upload"; });
}

void StepPlayer::tell_state() const { settings_.told(state_); }

}  // namespace haptogram::link
