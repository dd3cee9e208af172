// SPDX-License-Identifier: Apache-2.0
// The C interface: each function converts its arguments, calls what the program calls, and turns what is thrown into a
// code and words.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/link/asked_device.hpp"
#include "haptogram/link/background_player.hpp"
#include "haptogram/link/background_rig.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/trigger.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/pattern.hpp"
#include "haptogram/verbs/rig.hpp"
#include "haptogram/verbs/timeline.hpp"
#include "inside.hpp"
#include "reference_port.hpp"
#ifndef _WIN32
#include <unistd.h>
#endif

#ifdef HAPTOGRAM_HAS_FORMATS
#include "haptogram/formats/readers.hpp"
#endif
#ifdef HAPTOGRAM_HAS_PERCEPTION
#include "haptogram/perception/magnitude.hpp"
#endif
#ifdef HAPTOGRAM_HAS_HAND
#include "haptogram/hand/project.hpp"
#endif

using namespace haptogram::c;
using haptogram::bad_argument;

/// A name, and no more: its place in memory is never given away again, so that one that was closed is known as that.
struct haptogram_board {};

struct haptogram_link {
    haptogram::link::AskedDevice device;
};

namespace {

/// One of both: a board, or a rig's boards.
struct Opened {
    std::unique_ptr<haptogram::link::BackgroundPlayer> one;
    std::unique_ptr<haptogram::link::BackgroundRig> rig;

    void end() const {
        if (one) one->end();
        if (rig) rig->end();
    }
};

/// All boards of this process. It is never destroyed, because other threads may be in a call when the program ends.
class Boards {
public:
    static Boards& all() {
        static Boards& boards = *new Boards;
        return boards;
    }

    haptogram_board* add(std::shared_ptr<Opened> opened) {
        const std::lock_guard lock(mutex_);
        end_with_program();
        opened_.emplace(&names_.emplace_back(), std::move(opened));
        return &names_.back();
    }
    /// Whoever has it may use it, also while another thread closes it.
    /// @throws Error{bad_argument} when it is none that is open
    std::shared_ptr<Opened> find(const haptogram_board* board) {
        if (board == nullptr) throw bad_argument("board", "is NULL");
        const std::lock_guard lock(mutex_);
        const auto found = opened_.find(board);
        if (found == opened_.end()) throw bad_argument("board", "is closed, or was never opened");
        return found->second;
    }
    /// @return nothing for one that is not open
    std::shared_ptr<Opened> remove(const haptogram_board* board) {
        const std::lock_guard lock(mutex_);
        const auto found = opened_.extract(board);
        return found.empty() ? nullptr : std::move(found.mapped());
    }

private:
    Boards() = default;

    /// Windows has ended all threads before it tells, so there is nobody left to switch off.
    void end_with_program() {
#ifndef _WIN32
        if (std::exchange(process_, ::getpid()) == ::getpid()) return;
        std::atexit([] { all().end(); });
#ifndef __APPLE__
        std::at_quick_exit([] { all().end(); });
#endif
#endif
    }
    /// All at the same time. The child of a fork has none of the threads, and leaves the boards to its parent.
    void end() noexcept {
#ifndef _WIN32
        try {
            std::vector<std::shared_ptr<Opened>> left;
            {
                const std::lock_guard lock(mutex_);
                if (process_ != ::getpid()) return;
                for (auto& [name, opened] : opened_) left.push_back(opened);
            }
            std::vector<std::thread> enders;
            for (const auto& opened : left) enders.emplace_back([&opened] { opened->end(); });
            for (std::thread& ender : enders) ender.join();
        } catch (const std::exception&) {  // what is left is the watchdogs'
        }
#endif
    }

    std::mutex mutex_;
    std::deque<haptogram_board> names_;
    std::map<const haptogram_board*, std::shared_ptr<Opened>> opened_;
#ifndef _WIN32
    pid_t process_ = 0;  // that the program's end is heard of
#endif
};

/// For what a rig cannot do.
std::shared_ptr<haptogram::link::BackgroundPlayer> alone(const haptogram_board* board, const char* what) {
    const std::shared_ptr<Opened> opened = Boards::all().find(board);
    if (!opened->one) throw bad_argument(what, "a rig plays its own images alone; open one board for this");
    return {opened, opened->one.get()};
}

/// Does something with a board, or with a rig.
template <class Work>
void with(haptogram_board* board, const Work& work) {
    const std::shared_ptr<Opened> opened = Boards::all().find(board);
    if (opened->one)
        work(*opened->one);
    else
        work(*opened->rig);
}

/// Fills a caller's struct, no more of it than the caller has.
template <class Struct>
void give(Struct* to, Struct filled, const char* name) {
    const std::uint32_t size = required(to, name).size;
    if (size < sizeof size)
        throw bad_argument(name, fmt::format("its size is {}; set it to sizeof of the struct", size));
    filled.size = size;
    std::memcpy(to, &filled, std::min<std::size_t>(size, sizeof filled));
}

haptogram_image* image_of(haptogram::Bundle bundle, const std::vector<std::string>& warnings) {
    auto image = std::make_unique<haptogram_image>();
    image->manifest = to_text(bundle.manifest);
    image->bundle = std::move(bundle);
    image->warnings = fmt::format("{}", fmt::join(warnings, "\n"));
    return image.release();
}

haptogram::ProjectInstrument instrument_for(const haptogram_path& path) {
    haptogram::Project project;
    if (path.board != nullptr) project.board = path.board;
    if (path.array != nullptr) project.array = path.array;
    return instrument_of(project);
}

/// The shape whose bytes are given.
haptogram::ShapeSource& shape_in(haptogram::Project& project, const haptogram_project& given) {
    const std::string name = required_text(given.shape_name, "shape_name");
    for (haptogram::ShapeSource& source : project.shapes)
        if (source.file == name) return source;
    throw bad_argument("shape_name", fmt::format("no [[shape]] of the project has the file '{}'", name));
}

haptogram::Project project_for(const haptogram_project& given) {
    const char* const name = given.name != nullptr ? given.name : "project";
    haptogram::Project wanted = given.file != nullptr
                                    ? haptogram::load_project(given.file)
                                    : haptogram::project_from_toml(required_text(given.toml, "toml"), name);
    wanted.makers = makers();
    if (given.folder != nullptr) wanted.folder = given.folder;
    if (given.shape != nullptr)
        shape_in(wanted, given).content = std::string(static_cast<const char*>(given.shape), given.shape_bytes);
    return wanted;
}

haptogram::Path path_for(const haptogram_path& given) {
    const std::size_t each = std::max(1U, given.each);
    const haptogram_focus* const foci = &required(given.foci, "foci");
    haptogram::Path path;
    for (std::size_t i = 0; i < given.steps; ++i) {
        haptogram::PathStep& step = path.steps.emplace_back();
        step.periods = given.periods != nullptr ? given.periods[i] : 1;
        step.mark = given.marks != nullptr && given.marks[i] != 0;
        for (std::size_t k = i * each; k < (i + 1) * each; ++k) step.foci.push_back(focus_of(foci[k]));
    }
    return path;
}

void require_time(const char* name, double seconds) {
    if (!std::isfinite(seconds) || seconds < 0.0)
        throw bad_argument(name, fmt::format("found {}, expected seconds, 0 or more", seconds));
}

haptogram_playing known_playing(const haptogram_playing* given) {
    if (given == nullptr) return {};
    const haptogram_playing known = known_part(given, "playing");
    if (known.loops > 65535) throw bad_argument("loops", fmt::format("found {}, expected at most 65535", known.loops));
    if (known.stale_ms < -1)
        throw bad_argument("stale_ms", fmt::format("found {}, expected −1 or more", known.stale_ms));
    if (known.watchdog_ms > 65535)
        throw bad_argument("watchdog_ms", fmt::format("found {}, expected at most 65535", known.watchdog_ms));
    require_time("seconds", known.seconds);
    require_time("step_s", known.step_s);
    return known;
}

/// What a board's playing and a rig's have in common.
template <class Playing>
Playing playing_of(const haptogram_playing& known) {
    Playing playing;
    if (known.loops != 0) playing.loops = static_cast<std::uint16_t>(std::max(0, known.loops));
    if (known.watchdog_ms != 0) playing.watchdog_ms = static_cast<std::uint16_t>(known.watchdog_ms);
    playing.seconds = known.seconds;
    return playing;
}

haptogram::link::BackgroundPlay playing_alone(const haptogram_playing* given) {
    const haptogram_playing known = known_playing(given);
    auto playing = playing_of<haptogram::link::BackgroundPlay>(known);
    if (known.am != nullptr) playing.am = known.am;
    if (known.step_s != 0.0) playing.step_s = known.step_s;
    if (known.stale_ms != 0) playing.stale_ms = static_cast<std::uint32_t>(std::max(0, known.stale_ms));
    return playing;
}

haptogram::link::RigSettings playing_together(const haptogram_playing* given) {
    const haptogram_playing known = known_playing(given);
    if (known.am != nullptr) throw bad_argument("am", "a rig plays as it was compiled; compile it with that setting");
    if (known.step_s != 0.0) throw bad_argument("step_s", "has no meaning with an image, which has times of its own");
    if (known.stale_ms != 0) throw bad_argument("stale_ms", "has no meaning with an image, which plays without it");
    return playing_of<haptogram::link::RigSettings>(known);
}

/// The words between blanks.
std::vector<std::string> words_of(const char* given) {
    std::istringstream words(given == nullptr ? "" : given);
    return {std::istream_iterator<std::string>(words), {}};
}

haptogram_identity identity_of(const std::vector<haptogram::link::Identity>& boards) {
    const haptogram::link::Identity& first = boards.front();
    haptogram_identity all{0,
                           first.version_major,
                           first.version_minor,
                           0,
                           first.records,
                           first.sequence_depth,
                           first.clock_hz,
                           first.foci,
                           2 * first.modulation_words};
    for (const haptogram::link::Identity& board : boards) all.channels += board.channels;
    return all;
}

/// @throws Error{bad_argument} when they end within one
std::vector<haptogram::link::Request> requests_of(const void* given, std::size_t bytes) {
    constexpr std::size_t head = 3;
    std::vector<haptogram::link::Request> requests;
    std::span<const std::uint8_t> left(&required(static_cast<const std::uint8_t*>(given), "requests"), bytes);
    while (!left.empty()) {
        const std::size_t size = left.size() < head ? left.size() : left[1] | left[2] << 8U;
        if (left.size() < head + size)
            throw bad_argument("requests", fmt::format("number {} ends after {} bytes, expected {}",
                                                       requests.size() + 1, left.size(), head + size));
        const auto payload = left.subspan(head, size);
        requests.push_back({static_cast<haptogram::interface::Command>(left[0]), {payload.begin(), payload.end()}});
        left = left.subspan(head + size);
    }
    return requests;
}

std::string to_bytes(const std::vector<haptogram::link::Reply>& replies) {
    std::string bytes;
    for (const haptogram::link::Reply& reply : replies) {
        for (const std::size_t word : {std::size_t{reply.live_level}, reply.data.size()})
            bytes += {static_cast<char>(word & 0xff), static_cast<char>(word >> 8)};
        bytes.append(reply.data.begin(), reply.data.end());
    }
    return bytes;
}

/// Of several boards sums, and what is so for any of them; connected are all.
haptogram_status status_of(const std::vector<std::optional<haptogram::link::Status>>& boards, bool busy) {
    haptogram_status all{};
    all.connected = 1;
    all.busy = busy ? 1 : 0;
    for (const auto& board : boards) {
        if (!board) all.connected = 0;
        if (!board) continue;
        all.enabled |= board->enabled ? 1 : 0;
        all.stopped |= board->stopped ? 1 : 0;
        all.present_index = board->present_index;
        all.underruns += board->underruns;
        all.refused_records += board->refused_records;
        all.watchdog_trips += board->watchdog_trips;
        all.guard_trips += board->guard_trips;
        all.frames_damaged += board->frames_damaged;
    }
    return all;
}

}  // namespace

namespace haptogram::c {

haptogram_code code_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::failed: return HAPTOGRAM_FAILED;
        case ErrorCode::bad_argument: return HAPTOGRAM_BAD_ARGUMENT;
        case ErrorCode::bad_input: return HAPTOGRAM_BAD_INPUT;
        case ErrorCode::device: return HAPTOGRAM_DEVICE;
        case ErrorCode::cancelled: return HAPTOGRAM_CANCELLED;
    }
    return HAPTOGRAM_FAILED;
}

PathMakers makers() {
    PathMakers made{.of_pattern = path_of_pattern};
#if defined(HAPTOGRAM_HAS_HAND)
    made = path_makers();
#elif defined(HAPTOGRAM_HAS_PERCEPTION)
    made.of_magnitude = [](Path& path, const Project& project, const Array& array) {
        return perception::give_magnitude(path, project, array);
    };
#endif
#ifdef HAPTOGRAM_HAS_FORMATS
    made.readers = formats::readers();
#endif
    return made;
}

Progress until(const std::int32_t* cancel) {
    if (cancel == nullptr) return {};
    return Progress([cancel = static_cast<const volatile std::int32_t*>(cancel)](double, std::string_view) {
        return *cancel == 0;  // which another thread writes, whole
    });
}

}  // namespace haptogram::c

extern "C" {

int32_t haptogram_abi(void) { return HAPTOGRAM_ABI; }

const char* haptogram_version(void) {
    static const std::string text = haptogram::version();
    return text.c_str();
}

const char* haptogram_error(void) { return last_error.c_str(); }
const char* haptogram_error_place(void) { return last_place.c_str(); }
const char* haptogram_remedies(void) { return last_remedies.c_str(); }

haptogram_code haptogram_compile(const haptogram_project* project, haptogram_image** image) {
    return guarded([&] {
        const haptogram_project given = known_part(project, "project");
        required(image, "image") = nullptr;
        haptogram::Compiled compiled = haptogram::compile(project_for(given),
                                                          given.name != nullptr   ? given.name
                                                          : given.file != nullptr ? given.file
                                                                                  : "image",
                                                          until(given.cancel));
        *image = image_of(std::move(compiled.bundle), compiled.warnings);
    });
}

haptogram_code haptogram_compile_path(const haptogram_path* path, haptogram_image** image) {
    return guarded([&] {
        const haptogram_path given = known_part(path, "path");
        required(image, "image") = nullptr;
        haptogram::Compiled compiled = haptogram::compile(
            path_for(given), instrument_for(given), given.loops, "image", haptogram::Method::gauss_newton, {},
            given.board_computes != 0 ? haptogram::ImageKind::foci : haptogram::ImageKind::records);
        *image = image_of(std::move(compiled.bundle), compiled.warnings);
    });
}

haptogram_code haptogram_read_image(const char* hex_file, haptogram_image** image) {
    return guarded([&] {
        required(image, "image") = nullptr;
        *image = image_of(haptogram::load_bundle(required_text(hex_file, "hex_file")), {});
    });
}

haptogram_code haptogram_save_image(const haptogram_image* image, const char* hex_file) {
    return guarded([&] {
        const std::string file = required_text(hex_file, "hex_file");
        haptogram::write_files(
            {{file, required(image, "image").bundle.hex}, {haptogram::manifest_path(file), image->manifest}});
    });
}

size_t haptogram_image_hex(const haptogram_image* image, char* to, size_t room) {
    return image == nullptr ? 0 : copy(image->bundle.hex, to, room);
}
size_t haptogram_image_manifest(const haptogram_image* image, char* to, size_t room) {
    return image == nullptr ? 0 : copy(image->manifest, to, room);
}
size_t haptogram_image_warnings(const haptogram_image* image, char* to, size_t room) {
    return image == nullptr ? 0 : copy(image->warnings, to, room);
}
size_t haptogram_image_level(const haptogram_image* image, char* to, size_t room) {
    return image == nullptr ? 0 : copy(level_text(image->bundle.manifest.array.transducer), to, room);
}
void haptogram_free_image(haptogram_image* image) { delete image; }

haptogram_code haptogram_pressure(const haptogram_image* image, uint32_t record, const double* points_m, size_t points,
                                  double* pressure_pa) {
    return guarded([&] {
        const haptogram::Excitation played = excitation_of(timeline_of(required(image, "image").bundle), record);
        double* const to = &required(pressure_pa, "pressure_pa");
        const std::vector<float> found =
            mean_square_pressure_at(played.array, played.sequence(), points_of(points_m, points, "points_m"));
        std::ranges::transform(found, to, [](float mean_square) { return std::sqrt(2.0 * mean_square); });
    });
}

haptogram_code haptogram_solve(const char* array, const haptogram_focus* foci, size_t count, const char* method,
                               double* drives, size_t* elements) {
    return guarded([&] {
        const haptogram::Array driven = haptogram::find_array(required_text(array, "array"));
        const std::size_t room = std::exchange(required(elements, "elements"), driven.elements.size());
        if (room < driven.elements.size())
            throw bad_argument("elements", fmt::format("there is room for {}, and {} has {}", room, driven.name,
                                                       driven.elements.size()));
        std::vector<haptogram::Focus> wanted;
        for (std::size_t i = 0; i < count; ++i) wanted.push_back(focus_of((&required(foci, "foci"))[i]));
        haptogram::SolveOptions options;
        if (method != nullptr) options.method = haptogram::method_of(method, "method");
        double* const to = &required(drives, "drives");
        const std::vector<std::complex<double>> found = solve(driven, wanted, options);
        std::memcpy(to, found.data(), found.size() * sizeof found.front());
    });
}

haptogram_code haptogram_compile_rig(const haptogram_project* project, const char* rig, const char* manifest_file) {
    return guarded([&] {
        const haptogram_project given = known_part(project, "project");
        const std::string manifest = required_text(manifest_file, "manifest_file");
        haptogram::write_files(
            files_of(compile_rig(project_for(given), required_text(rig, "rig"), manifest, until(given.cancel)).bundle));
    });
}

haptogram_code haptogram_open(const haptogram_port* port, haptogram_board** board) {
    return guarded([&] {
        const haptogram_port given = known_part(port, "port");
        required(board, "board") = nullptr;
        const auto baud = given.baud != 0 ? std::optional(given.baud) : std::nullopt;
        auto opened = std::make_shared<Opened>();
        if (given.rig != nullptr) {
            opened->rig = std::make_unique<haptogram::link::BackgroundRig>(given.rig, words_of(given.port), baud);
        } else {
            const std::chrono::milliseconds patience(given.patience_ms != 0 ? given.patience_ms : 3000);
            const haptogram::link::PortSettings settings{.port = required_text(given.port, "port"), .baud = baud};
            opened->one =
                std::make_unique<haptogram::link::BackgroundPlayer>(haptogram::sim::opener_of(settings), patience);
        }
        *board = Boards::all().add(std::move(opened));
    });
}

void haptogram_close(haptogram_board* board) {
    guarded([&] {
        if (const std::shared_ptr<Opened> opened = Boards::all().remove(board)) opened->end();
    });
}

haptogram_code haptogram_identify(haptogram_board* board, haptogram_identity* identity) {
    return guarded([&] {
        const std::shared_ptr<Opened> opened = Boards::all().find(board);
        const Opened& asked = *opened;
        give(identity, asked.one ? identity_of({asked.one->state().identity}) : identity_of(asked.rig->identities()),
             "identity");
    });
}

haptogram_code haptogram_get_status(haptogram_board* board, haptogram_status* status) {
    return guarded([&] {
        const std::shared_ptr<Opened> opened = Boards::all().find(board);
        const Opened& asked = *opened;
        if (!asked.one) return give(status, status_of(asked.rig->statuses(), asked.rig->busy()), "status");
        const haptogram::link::DeviceState state = asked.one->state();
        const haptogram::link::BackgroundWork work = asked.one->work();
        haptogram_status all = status_of({state.status}, work.busy);
        all.connected = state.connection == haptogram::link::Connection::connected ? 1 : 0;
        all.foci_sent = work.sent;
        all.lead_s = work.lead_s;
        all.patterns_late = work.late_patterns;
        all.patterns_lost = work.lost_patterns;
        give(status, all, "status");
    });
}

haptogram_code haptogram_upload(haptogram_board* board, const haptogram_image* image) {
    return guarded([&] {
        if (image != nullptr) return alone(board, "image")->upload(image->bundle);
        const std::shared_ptr<Opened> opened = Boards::all().find(board);
        if (!opened->rig) throw bad_argument("image", "is NULL");
        opened->rig->upload();
    });
}

haptogram_code haptogram_play(haptogram_board* board, const haptogram_playing* playing) {
    return guarded([&] {
        const std::shared_ptr<Opened> opened = Boards::all().find(board);
        if (opened->one) return opened->one->play(playing_alone(playing));
        opened->rig->play(playing_together(playing));
    });
}

haptogram_code haptogram_play_live(haptogram_board* board, const haptogram_playing* playing) {
    return guarded([&] { alone(board, "live")->play_live(playing_alone(playing)); });
}

haptogram_code haptogram_set_focus(haptogram_board* board, double x_m, double y_m, double z_m, double amplitude) {
    return guarded([&] { alone(board, "focus")->set_focus({{x_m, y_m, z_m}, amplitude}); });
}

haptogram_code haptogram_play_patterns(haptogram_board* board, const haptogram_playing* playing) {
    return guarded([&] { alone(board, "patterns")->play_patterns(playing_alone(playing)); });
}

haptogram_code haptogram_put_patterns(haptogram_board* board, const uint16_t* words, size_t patterns, size_t* taken) {
    return guarded([&] {
        const auto player = alone(board, "patterns");
        haptogram::link::PatternQueue& queue = player->patterns();
        required(taken, "taken") = 0;
        *taken = queue.put({&required(words, "words"), patterns * queue.words()});
    });
}

haptogram_code haptogram_set_pattern(haptogram_board* board, const uint16_t* words) {
    return guarded([&] {
        const auto player = alone(board, "patterns");
        haptogram::link::PatternQueue& queue = player->patterns();
        queue.set({&required(words, "words"), queue.words()});
    });
}

haptogram_code haptogram_wait(haptogram_board* board, uint32_t milliseconds, int32_t* busy) {
    return guarded([&] {
        bool goes_on = false;
        with(board, [&](auto& any) { goes_on = any.wait(std::chrono::milliseconds(milliseconds)); });
        if (busy != nullptr) *busy = goes_on ? 1 : 0;
    });
}

haptogram_code haptogram_stop(haptogram_board* board) {
    return guarded([&] { with(board, [](auto& any) { any.stop(); }); });
}

haptogram_code haptogram_shut_off(haptogram_board* board) {
    return guarded([&] { with(board, [](auto& any) { any.shut_off(); }); });
}

haptogram_code haptogram_set_intensity(haptogram_board* board, double factor) {
    return guarded([&] { alone(board, "intensity")->set_intensity(factor); });
}

haptogram_code haptogram_set_trigger(haptogram_board* board, const haptogram_trigger* trigger) {
    return guarded([&] {
        const haptogram_trigger given = known_part(trigger, "trigger");
        haptogram::link::TriggerSettings settings;
        if (given.event > HAPTOGRAM_EVENT_MODULATION)
            throw bad_argument("event", fmt::format("found {}, expected 0 to {}", given.event,
                                                    static_cast<int>(HAPTOGRAM_EVENT_MODULATION)));
        if (given.every_periods > 65535)
            throw bad_argument("every_periods", fmt::format("found {}, expected at most 65535", given.every_periods));
        require_time("pulse_s", given.pulse_s);
        require_time("settle_s", given.settle_s);
        settings.event = static_cast<haptogram::link::Event>(given.event);
        if (given.every_periods != 0) settings.every_periods = static_cast<std::uint16_t>(given.every_periods);
        if (given.pulse_s != 0.0) settings.pulse_s = given.pulse_s;
        settings.active_low = given.active_low != 0;
        settings.gates = given.gates != 0;
        settings.settle_s = given.settle_s;
        alone(board, "trigger")->ask([&](haptogram::link::Commands& device) { set_trigger(device, settings); });
    });
}

haptogram_code haptogram_get_trigger_times(haptogram_board* board, haptogram_trigger_times* times) {
    return guarded([&] {
        haptogram::link::TriggerTimes found;
        alone(board, "trigger")->ask([&](haptogram::link::Commands& device) { found = trigger_times(device); });
        give(times, {0, found.out_count, found.in_count, found.now, found.out, found.in}, "times");
    });
}

haptogram_code haptogram_open_link(const haptogram_port* port, haptogram_link** link) {
    return guarded([&] {
        const haptogram_port given = known_part(port, "port");
        required(link, "link") = nullptr;
        if (given.rig != nullptr) throw bad_argument("rig", "a link is to one board; open one for each");
        if (given.patience_ms != 0) throw bad_argument("patience_ms", "has no meaning here; the caller waits");
        haptogram::link::set_reference_boards(haptogram::sim::reference_line);
        *link = new haptogram_link{
            haptogram::link::AskedDevice({.port = required_text(given.port, "port"),
                                          .baud = given.baud != 0 ? std::optional(given.baud) : std::nullopt})};
    });
}

void haptogram_close_link(haptogram_link* link) {
    guarded([&] { delete link; });
}

haptogram_code haptogram_link_identify(haptogram_link* link) {
    return guarded([&] { required(link, "link").device.identify(); });
}

haptogram_code haptogram_link_ask(haptogram_link* link, const void* requests, size_t bytes, uint64_t gate) {
    return guarded([&] {
        haptogram::link::AskedDevice& device = required(link, "link").device;
        if (gate >> 48U != 0) throw bad_argument("gate", fmt::format("found {}, expected 48 bits", gate));
        device.ask(requests_of(requests, bytes), {gate});
    });
}

haptogram_code haptogram_link_shut_off(haptogram_link* link) {
    return guarded([&] { required(link, "link").device.shut_off(); });
}

haptogram_code haptogram_link_wait(haptogram_link* link, uint32_t milliseconds, int32_t* busy) {
    return guarded([&] {
        if (busy != nullptr) *busy = 0;
        const bool goes_on = required(link, "link").device.wait(std::chrono::milliseconds(milliseconds));
        if (busy != nullptr) *busy = goes_on ? 1 : 0;
    });
}

haptogram_code haptogram_link_interrupt(haptogram_link* link) {
    return guarded([&] { required(link, "link").device.interrupt(); });
}

size_t haptogram_link_replies(haptogram_link* link, void* to, size_t room) {
    size_t size = 0;
    guarded([&] { size = copy(to_bytes(required(link, "link").device.replies()), static_cast<char*>(to), room); });
    return size;
}

haptogram_code haptogram_link_stream(haptogram_link* link, uint64_t period, const uint16_t* words, size_t patterns) {
    return guarded([&] {
        haptogram::link::AskedDevice& device = required(link, "link").device;
        device.stream(period, &required(words, "words"), patterns);
    });
}

haptogram_code haptogram_link_keep_alive(haptogram_link* link, uint32_t milliseconds) {
    return guarded([&] { required(link, "link").device.keep_alive_every(std::chrono::milliseconds(milliseconds)); });
}

haptogram_code haptogram_get_link_state(haptogram_link* link, haptogram_link_state* state) {
    return guarded([&] {
        const haptogram::link::AskedDevice& device = required(link, "link").device;
        give(state, {0, device.found_baud(), device.retransmissions()}, "state");
    });
}

size_t haptogram_ports(char* to, size_t room) {
    std::string ports;
    guarded([&] {
        for (const haptogram::link::PortInfo& port : haptogram::link::available_ports())
            ports += fmt::format("{}\t{}\n", port.port, port.name);
    });
    return copy(ports, to, room);
}

}  // extern "C"
