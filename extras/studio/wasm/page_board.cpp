// SPDX-License-Identifier: Apache-2.0
#include "page_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "board_json.hpp"
#include "failure.hpp"
#include "haptogram/link/known_rates.hpp"
#include "haptogram/link/to_json.hpp"

namespace haptogram::studio {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t most_images = 4;                // as ../web/src/page_board.ts knows
constexpr std::chrono::seconds most_wait_for_off{2};  // for the board's word

}  // namespace

/// Frames of one step go out together.
class PageBoard::Line final : public link::Transport {
public:
    explicit Line(PageBoard& board) : board_(board) {}

    void write(std::span<const std::uint8_t> bytes) override { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
    void flush() override {
        if (!out_.empty()) board_.door_.write(std::exchange(out_, {}));
    }
    std::vector<std::uint8_t> read(std::chrono::microseconds) override {
        flush();
        return std::exchange(board_.arrived_, {});
    }
    void discard_output() override {
        out_.clear();
        board_.door_.discard();
    }
    void send_break() override {
        flush();
        board_.door_.hold_break(link::break_time(board_.rates_.front()));
    }

private:
    PageBoard& board_;
    link::Bytes out_;
};

PageBoard::PageBoard(PortDoor door, std::function<void(const ordered_json&)> tell)
    : door_(std::move(door)), tell_(std::move(tell)) {}

void PageBoard::keep(const std::string& scene, std::string_view hex) {
    auto image = std::make_shared<const Image>(from_intel_hex(hex, "scene"));
    if (images_.size() == most_images) images_.pop_front();  // what plays has its own
    images_.emplace_back(scene, std::move(image));
}

std::shared_ptr<const Image> PageBoard::image_of(const std::string& scene) const {
    const auto found = std::ranges::find(images_, scene, &NamedImage::first);
    if (found == images_.end()) throw Error(ErrorCode::failed, "scene", "its image has not come; try again");
    return found->second;
}

link::StepPlayer& PageBoard::player() {
    if (!player_ || leaves_)
        throw Error(ErrorCode::device, "board", "there is no connection; connect to a board first");
    return *player_;
}

void PageBoard::act(const ConnectMessage& message) {
    if (message.baud != 0 && (message.baud < 300 || message.baud > 12'000'000))
        throw bad_argument("baud", fmt::format("found {}, expected 300 to 12000000, or 0 to find it", message.baud));
    player_.reset();
    leaves_ = false;
    port_ = message.port;
    rates_ = {message.baud};
    if (message.baud == 0) rates_.assign(link::known_rates.begin(), link::known_rates.end());
    trouble_.clear();
    tried_ = 0;
    stops_.clear();
    tell_device();
    door_.open(rates_.front());
}

/// What a rate that nobody answers at was tried with is over.
void PageBoard::open_next_rate() {
    tries_next_ = false;
    player_.reset();
    std::ranges::rotate(rates_, rates_.begin() + 1);
    door_.open(rates_.front());
}

void PageBoard::opened() {
    if (port_.empty()) return door_.close();  // it was let go of meanwhile
    arrived_.clear();
    scenes_.clear();
    stepped_ = Clock::now();
    const auto told = [this](const link::DeviceState& state) {
        if (leaves_) return;
        tries_next_ = state.connection == link::Connection::connecting && !state.trouble.empty();
        if (!tries_next_ || ++tried_ >= rates_.size()) trouble_ = state.trouble;
        tell_device();
    };
    player_ = std::make_unique<link::StepPlayer>(
        std::make_unique<Line>(*this),
        link::StepPlayer::Settings{.told = told, .work = [this](const link::StepWork& work) { tell_work(work); }});
    player_->set_intensity(intensity_);
}

void PageBoard::lost(const std::string& why) {
    trouble_ = why;
    if (leaves_) return let_go();
    if (player_) return player_->lose(why);
    if (port_.empty()) return;
    tell_({{"t", "device"}, {"connection", "lost"}, {"port", port_}, {"trouble", why}});
}

void PageBoard::received(const link::Bytes& bytes) {
    arrived_.insert(arrived_.end(), bytes.begin(), bytes.end());
    step();
}

void PageBoard::step() {
    const Clock::time_point now = Clock::now();
    const auto passed = std::chrono::duration_cast<std::chrono::microseconds>(now - std::exchange(stepped_, now));
    if (!player_) return;
    if (const auto why = sight_.too_long(); why && player_->drives()) {
        player_->stop();
        tell_({{"t", "notice"}, {"message", "Outputs off: " + *why + "."}});
    }
    player_->step(std::max(passed, std::chrono::microseconds(1)));
    tell_stops();
    if (tries_next_ && !leaves_) open_next_rate();
}

/// Outputs off, and then the port is free. A board that does not answer is not waited for longer than two seconds.
void PageBoard::act(const DisconnectMessage&) {
    if (player_) {
        stops_.push_back({0, player_->stop(), Clock::now()});
        leaves_ = true;
    } else {
        let_go();
    }
    port_.clear();
    tell_device();
}

void PageBoard::let_go() {
    player_.reset();
    leaves_ = false;
    port_.clear();
    for (const Stop& stop : std::exchange(stops_, {}))
        if (stop.n != 0) tell_({{"t", "off"}, {"n", stop.n}, {"confirmed", false}});
    door_.close();
}

void PageBoard::act(const UploadMessage& message) { player().upload(image_of(message.scene)); }

void PageBoard::act(const PlayMessage& message) {
    if (!message.lines.empty()) throw bad_argument("lines", "a page reads no pipes; open the design in the program");
    sight_.seen();
    scenes_[player().play(image_of(message.scene), message.triggers)] = message.scene;
}

void PageBoard::act(const TriggerMessage& message) { player().trigger(message.number); }

void PageBoard::act(const StreamMessage& message) {
    sight_.seen();
    scenes_[player().stream(image_of(message.scene), message.index)] = message.scene;
}

void PageBoard::act(const IntensityMessage& message) {
    if (!(message.value >= 0.0 && message.value <= 1.0))
        throw bad_argument("intensity", fmt::format("found {}, expected 0 to 1", message.value));
    if (player_) player_->set_intensity(message.value);
    intensity_ = message.value;
    tell_device();
}

void PageBoard::act(const ModulateMessage& message) {
    player().modulate(*image_of(message.scene));
    if (!scenes_.empty()) scenes_.begin()->second = message.scene;  // work is done in turn, so the first is what plays
}

void PageBoard::act(const StopMessage& message) {
    if (player_)
        stops_.push_back({message.n, player_->stop(), Clock::now()});
    else
        tell_({{"t", "off"}, {"n", message.n}, {"confirmed", true}});
}

void PageBoard::tell_stops() {
    std::erase_if(stops_, [&](const Stop& stop) {
        const bool confirmed = player_->state().confirmed >= stop.number;
        if (!confirmed && Clock::now() - stop.asked < most_wait_for_off) return false;
        if (stop.n != 0) tell_({{"t", "off"}, {"n", stop.n}, {"confirmed", confirmed}});
        return true;
    });
    if (leaves_ && stops_.empty()) let_go();
}

void PageBoard::tell_device() const {
    if (port_.empty()) return tell_({{"t", "device"}, {"connection", "none"}});
    link::DeviceState state;
    if (player_) state = player_->state();
    if (state.connection == link::Connection::connecting) state.trouble = trouble_;
    tell_(device_json(state, port_, rates_.front(), intensity_));
}

void PageBoard::tell_work(const link::StepWork& work) {
    using Stage = link::StepWork::Stage;
    ordered_json json{{"t", "progress"}, {"work", work.name}, {"number", work.number}};
    if (work.stage == Stage::uploads) json.update({{"fraction", work.fraction}, {"stage", "upload"}});
    if (work.stage == Stage::plays)
        json.update({{"seconds", work.seconds}, {"stage", "play"}, {"scene", scenes_[work.number]}});
    else if (work.stage != Stage::uploads)
        scenes_.erase(work.number);
    if (work.stage == Stage::done) json["t"] = "done";
    if (work.stage == Stage::stopped) json["t"] = "stopped";
    if (work.stage == Stage::failed) json["t"] = "failed";
    if (work.error) json["error"] = to_json(*work.error);
    if (work.stage == Stage::done) {
        ordered_json& report = json["report"] = ordered_json::object();
        if (work.played) report = link::played_to_json(*work.played);
        if (work.uploaded)
            report.update({{"frames", work.uploaded->pieces}, {"frames_written", work.uploaded->written}});
    }
    tell_(json);
}

}  // namespace haptogram::studio
