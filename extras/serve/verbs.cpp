// SPDX-License-Identifier: Apache-2.0
#include "verbs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram::serve {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::chrono::seconds osc_owns{1};  // after its last datagram
constexpr std::size_t most_begun = 32;       // messages of datagrams that wait for the board
constexpr std::string_view ending_verbs[] = {"stop", "shut_off", "leave"};

const char* name_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::failed: return "failed";
        case ErrorCode::bad_argument: return "bad_argument";
        case ErrorCode::bad_input: return "bad_input";
        case ErrorCode::device: return "device";
        case ErrorCode::cancelled: return "cancelled";
    }
    return "failed";
}

double number_of(const Json& request, const char* key, std::optional<double> standard = {}) {
    if (!request.contains(key) && standard) return *standard;
    const Json& found = request.contains(key) ? request[key] : Json();
    if (!found.is_number()) throw bad_argument(key, "expected a number, found " + found.dump());
    return found.get<double>();
}

std::uint16_t whole_of(const Json& request, const char* key, std::uint16_t standard) {
    if (!request.contains(key)) return standard;
    if (!request[key].is_number_unsigned() || request[key].get<std::uint64_t>() > 65535)
        throw bad_argument(key, "expected a whole number from 0 to 65535, found " + request[key].dump());
    return request[key].get<std::uint16_t>();
}

std::string text_of(const Json& request, const char* key, const std::optional<std::string>& standard = {}) {
    if (!request.contains(key) && standard) return *standard;
    const Json& found = request.contains(key) ? request[key] : Json();
    if (!found.is_string()) throw bad_argument(key, "expected a text, found " + found.dump());
    return found.get<std::string>();
}

Vec3 place_of(const Json& request) {
    const Json& place = request.contains("at_m") ? request["at_m"] : Json();
    if (!place.is_array() || place.size() != 3 || !place[0].is_number() || !place[1].is_number() ||
        !place[2].is_number())
        throw bad_argument("at_m", "expected [x, y, z] in metres, found " + place.dump());
    return {place[0].get<double>(), place[1].get<double>(), place[2].get<double>()};
}

/// A client that may drive the array need not be one that may read this machine's files.
void require_no_files(const Project& project, const char* setting) {
    if (const std::vector<std::string> files = files_of(project); !files.empty())
        throw bad_argument(setting, fmt::format("names the file '{}'; of a client it takes built-in shapes and "
                                                "waveforms, and shipped arrays and boards; send an image for others",
                                                files.front()));
}

link::BackgroundPlay how_of(const Json& request) {
    link::BackgroundPlay how;
    if (request.contains("loops")) how.loops = whole_of(request, "loops", 0);
    how.watchdog_ms = whole_of(request, "watchdog_ms", how.watchdog_ms);
    if (request.contains("stale_ms")) how.stale_ms = whole_of(request, "stale_ms", 0);
    how.seconds = number_of(request, "seconds", 0.0);
    if (how.seconds < 0.0) throw bad_argument("seconds", fmt::format("found {}, expected 0 or more", how.seconds));
    how.am = text_of(request, "am", "");
    Project named;
    named.am = how.am;
    require_no_files(named, "am");
    return how;
}

Compiled compiled_of(const Json& request, const PathMakers& makers) {
    Project project = project_from_toml(text_of(request, "project"), "project");
    require_no_files(project, "project");
    if (project.hand) throw bad_argument("project", "takes shapes only; send an image for others");
    for (const auto& name : {project.array, project.board})
        if (name && name->find('/') != std::string::npos)
            throw bad_argument("project", "takes shipped arrays and boards only, by their names");
    project.makers = makers;
    return compile(project, "image");
}

}  // namespace

Json failure(const std::exception& error) {
    const auto* const known = dynamic_cast<const Error*>(&error);
    Json found = {{"code", known != nullptr ? name_of(known->code()) : "failed"}, {"message", error.what()}};
    if (known != nullptr && !known->remedies().empty()) found["remedies"] = known->remedies();
    return {{"error", std::move(found)}};
}

void Verbs::own(Client client) {
    const std::lock_guard lock(mutex_);
    if (!owner_) owner_ = client;
    if (owner_ != client)
        throw Error(ErrorCode::device, "board", "another client drives it; it is free when that one goes");
    if ((client & by_datagrams) != 0) last_osc_ = board_.clock().now();
}

Verbs::Verbs(link::BackgroundPlayer& board, PathMakers makers)
    : board_(board), makers_(std::move(makers)), worker_([this] { work(); }) {}

Verbs::~Verbs() {
    {
        const std::lock_guard lock(begun_mutex_);
        over_ = true;
    }
    news_.notify_all();
    worker_.join();
}

void Verbs::begin(std::function<void()> work) {
    if (board_.state().connection != link::Connection::connected)
        throw Error(ErrorCode::device, "board", "it is away; try again when the status says that it is connected");
    const std::lock_guard lock(begun_mutex_);
    if (begun_.size() == most_begun)
        throw Error(ErrorCode::device, "board", "it has not done yet what it was asked for before");
    begun_.push_back(std::move(work));
    news_.notify_all();
}

void Verbs::forget_begun() {
    const std::lock_guard lock(begun_mutex_);
    begun_.clear();
}

void Verbs::work() {
    for (;;) {
        std::unique_lock lock(begun_mutex_);
        news_.wait(lock, [this] { return over_ || !begun_.empty(); });
        if (over_) return;
        const std::function<void()> next = std::move(begun_.front());
        begun_.pop_front();
        lock.unlock();
        std::string trouble;
        try {
            next();
        } catch (const std::exception& error) {
            trouble = error.what();
        }
        lock.lock();
        if (!trouble.empty()) trouble_ = std::move(trouble);
    }
}

std::string Verbs::take_trouble() {
    const std::lock_guard lock(begun_mutex_);
    return std::exchange(trouble_, {});
}

void Verbs::leave(Client client) {
    {
        const std::lock_guard lock(mutex_);
        if (owner_ != client) return;
    }
    forget_begun();
    // Nobody else can begin anything before the outputs are off.
    try {
        board_.stop();
    } catch (const std::exception&) {  // whoever asks next is told by the status
    }
    board_.clear();
    const std::lock_guard lock(mutex_);
    owner_.reset();
}

void Verbs::expire() {
    Client silent = 0;
    {
        const std::lock_guard lock(mutex_);
        if (!owner_ || (*owner_ & by_datagrams) == 0 || board_.clock().now() - last_osc_ <= osc_owns) return;
        silent = *owner_;
    }
    leave(silent);
}

void Verbs::set_focus(Client client, const Focus& focus) {
    own(client);
    board_.set_focus(focus);
}

void Verbs::focus(std::span<const std::uint8_t> bytes, Client client) {
    std::array<double, 4> numbers{};
    if (bytes.size() != sizeof numbers)
        throw bad_input("focus",
                        fmt::format("found {} bytes, expected 32: x, y, z, amplitude as doubles", bytes.size()));
    std::memcpy(numbers.data(), bytes.data(), sizeof numbers);
    set_focus(client, {{numbers[0], numbers[1], numbers[2]}, numbers[3]});
}

void Verbs::act(const OscMessage& message, Client sender) {
    const std::vector<double>& numbers = message.numbers;
    const auto need = [&](std::size_t least, std::size_t most) {
        if (numbers.size() < least || numbers.size() > most)
            throw bad_argument(message.address, fmt::format("found {} numbers, expected {}{}", numbers.size(), least,
                                                            most > least ? fmt::format(" to {}", most) : ""));
    };
    if (message.address == "/haptogram/focus") {
        need(3, 4);
        set_focus(sender, {{numbers[0], numbers[1], numbers[2]}, numbers.size() == 4 ? numbers[3] : 1.0});
    } else if (message.address == "/haptogram/intensity") {
        need(1, 1);
        own(sender);
        begin([this, factor = numbers[0]] { board_.set_intensity(factor); });
    } else if (message.address == "/haptogram/play") {
        need(0, 0);
        own(sender);
        begin([this] { board_.play({}); });
    } else if (message.address == "/haptogram/live") {
        need(0, 0);
        own(sender);
        begin([this] { board_.play_live({}); });
    } else if (message.address == "/haptogram/alive") {
        need(0, 0);
        own(sender);
    } else if (message.address == "/haptogram/stop") {
        forget_begun();
        board_.shut_off();
    } else {
        throw bad_argument(message.address,
                           "is no address here; expected /haptogram/focus, intensity, play, live, alive or stop");
    }
}

Json Verbs::status() const {
    const link::DeviceState state = board_.state();
    const link::BackgroundWork work = board_.work();
    const std::lock_guard lock(mutex_);
    return {{"connected", state.connection == link::Connection::connected},
            {"enabled", state.status.enabled},
            {"stopped", state.status.stopped},
            {"busy", work.busy},
            {"owned", owner_.has_value()},
            {"index", state.status.present_index},
            {"underruns", state.status.underruns},
            {"watchdog_trips", state.status.watchdog_trips},
            {"guard_trips", state.status.guard_trips},
            {"foci_sent", work.sent},
            {"lead_ms", 1e3 * work.lead_s},
            {"trouble", state.trouble},
            {"failed", work.trouble}};
}

Json Verbs::compile(const Json& request) {
    Compiled compiled = compiled_of(request, makers_);
    board_.upload(compiled.bundle);
    return {{"records", compiled.bundle.image.records.size()}, {"warnings", compiled.warnings}};
}

Json Verbs::identify() const {
    const link::Identity identity = board_.state().identity;
    return {{"channels", identity.channels}, {"records", identity.records}, {"foci", identity.foci}};
}

Json Verbs::act(const Json& request, Client client) {
    struct Verb {
        std::string_view name;
        bool drives;                          ///< only the client whose turn it is may ask for it
        std::vector<std::string_view> takes;  ///< keys beside "do" and "id"
        std::function<Json()> act;
    };
    const auto quietly = [](auto act) {
        return [act = std::move(act)] {
            act();
            return Json::object();
        };
    };
    const Verb verbs[] = {
        {"compile", true, {"project"}, [&] { return compile(request); }},
        {"image", true, {"hex"}, quietly([&] {
             board_.upload({from_intel_hex(text_of(request, "hex"), "image"), {}, {}, "image"});
         })},
        {"play", true, {"loops", "seconds", "am", "watchdog_ms"}, quietly([&] { board_.play(how_of(request)); })},
        {"live", true, {"seconds", "am", "watchdog_ms", "stale_ms"}, quietly([&] {
             board_.play_live(how_of(request));
         })},
        {"focus", true, {"at_m", "amplitude"}, quietly([&] {
             board_.set_focus({place_of(request), number_of(request, "amplitude", 1.0)});
         })},
        {"intensity", true, {"factor"}, quietly([&] { board_.set_intensity(number_of(request, "factor")); })},
        {"stop", true, {}, quietly([&] { board_.stop(); })},
        {"shut_off", false, {}, quietly([&] {
             forget_begun();
             board_.shut_off();
         })},
        {"status", false, {}, [&] { return status(); }},
        {"identify", false, {}, [&] { return identify(); }},
        {"leave", false, {}, quietly([&] { leave(client); })},
    };
    const std::string wanted = text_of(request, "do");
    std::vector<std::string_view> names;
    for (const Verb& verb : verbs) {
        names.push_back(verb.name);
        if (verb.name != wanted) continue;
        for (const auto& [key, value] : request.items())
            if (key != "do" && key != "id" && std::ranges::find(verb.takes, key) == verb.takes.end())
                throw bad_argument(key,
                                   fmt::format("has no meaning with {}, which takes {}", wanted,
                                               verb.takes.empty() ? "no more than do and id"
                                                                  : fmt::format("{}", fmt::join(verb.takes, ", "))));
        if (verb.drives) own(client);
        return verb.act();
    }
    throw bad_argument("do", fmt::format("found '{}', expected one of {}", wanted, fmt::join(names, ", ")));
}

bool Verbs::ends(const std::string& request) {
    if (!is_shallow(request)) return false;
    const Json parsed = Json::parse(request, nullptr, false);
    return parsed.is_object() && parsed.contains("do") && parsed["do"].is_string() &&
           std::ranges::find(ending_verbs, parsed["do"].get<std::string>()) != std::end(ending_verbs);
}

Json Verbs::answer(const std::string& request, Client client) {
    Json id;
    Json said;
    try {
        require_shallow(request, "request");
        const Json parsed = Json::parse(request, nullptr, false);
        if (!parsed.is_object()) throw bad_input("request", "expected a JSON object such as {\"do\": \"status\"}");
        if (parsed.contains("id")) id = parsed["id"];
        said = act(parsed, client);
        said["ok"] = true;
    } catch (const std::exception& error) {
        said = failure(error);
    }
    if (!id.is_null()) said["id"] = id;
    return said;
}

}  // namespace haptogram::serve
