// SPDX-License-Identifier: Apache-2.0
#include "live.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <variant>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/verbs/settings.hpp"

namespace haptogram::studio {
namespace {

std::string in_mm(Vec3 p) { return fmt::format("{},{},{}", p.x / millimetre, p.y / millimetre, p.z / millimetre); }

/// Where the hands come from, as `haptogram live --from` takes it.
std::string source_of(const HandSource& hand, const std::string& pipe) {
    if (pipe.empty())
        return hand.recording.starts_with(synthetic_prefix)
                   ? hand.recording
                   : fmt::format("{}:{}", hand.model.empty() ? "leap" : "poses", hand.recording);
    std::error_code ignored;  // what cannot be asked for is none
    if (!std::filesystem::is_fifo(pipe, ignored))
        throw bad_argument("from", fmt::format("{} is no named pipe; make one with mkfifo, and let haptogram-leap "
                                               "write to it",
                                               pipe));
    return "leap-pipe:" + pipe;
}

/// What the page, its board and its design decide, and files, which a document must not name. The others of [live]
/// hold.
constexpr std::string_view keys_of_page[] = {"from",     "algorithm", "object", "size",     "height", "center",
                                             "rotate",   "unit",      "array",  "rig",      "port",   "baud",
                                             "watchdog", "record",    "scene",  "scene_in", "json"};

/// Hands on the project's table [live].
void take_table(LiveStart& start, std::span<const LiveSetting> settings) {
    std::vector<LiveSetting> taken;
    std::string left_out;
    for (const LiveSetting& setting : settings)
        if (std::ranges::find(keys_of_page, setting.key) == std::end(keys_of_page))
            taken.push_back(setting);
        else
            left_out += (left_out.empty() ? "" : ", ") + setting.key;
    if (!left_out.empty())
        start.left_out = fmt::format(
            "Of the project's [live] the page does not take: {}. Design, board and page say "
            "that; haptogram live --settings takes all.",
            left_out);
    if (taken.empty()) return;
    constexpr const char* name = "live-settings.toml";
    write_file(start.folder->path() / name, to_toml(taken));
    start.words.push_back(fmt::format("--settings={}", name));
}

/// Settings of a design that `haptogram live` has, too.
constexpr std::string_view of_both[] = {"speed_m_s", "frequency_hz", "jump", "seed"};
/// Those of an image, which a session has none of, and of the page's board.
constexpr std::string_view of_image[] = {"array", "board", "points", "image", "loops"};

std::string option_of(const Setting& setting, const SettingValue& value) {
    return fmt::format("{}={}", setting.option, option_text(value));
}

/// Hands on how the design draws, but for what its table [live] says. What a session would play in another way than the
/// design is refused.
void take_drawing(LiveStart& start, const Project& project) {
    const auto in_table = [&](std::string_view option) {
        return std::ranges::any_of(project.live, [&](const LiveSetting& one) {
            return "--" + one.key == option || (option == "--speed" && one.key == "frequency") ||
                   (option == "--frequency" && one.key == "speed");
        });
    };
    for (const Setting& setting : project_settings()) {
        const bool both = std::ranges::find(of_both, setting.key) != std::end(of_both);
        if (setting.get == nullptr || std::ranges::find(of_image, setting.key) != std::end(of_image)) continue;
        const std::optional<SettingValue> value = setting.get(project, setting);
        if (!value || value == default_of(setting) || !setting.has_effect(project)) continue;
        if (!both)
            throw bad_argument(std::string(setting.key),
                               fmt::format("a live session has no such setting, and would play without it; leave {} "
                                           "out of the design",
                                           setting.key));
        if (!in_table(setting.option)) start.words.push_back(option_of(setting, *value));
    }
}

}  // namespace

LiveStart prepare_live(Scenes& scenes, const LiveMessage& asked) {
    const HandScene scene = scenes.hand(asked.document);
    const HandSource& hand = *scene.project.hand;
    const ObjectSource& object = hand.object;
    LiveStart start{std::make_shared<TemporaryFolder>(), {}, {}};
    for (const std::string& name : files_of(hand)) {
        const std::filesystem::path place = start.folder->path() / name;
        std::filesystem::create_directories(place.parent_path());
        write_file(place, scenes.file(name));
    }
    if (!hand.model.empty())  // where it is looked for beside a recording
        write_file((start.folder->path() / hand.recording).parent_path() / "model_hand.json", scenes.file(hand.model));
    if (hand.rate_hz != HandSource{}.rate_hz)
        throw bad_input("hand.frames_hz", fmt::format("found {:g}; a live session plays a .pose file at {:g} frames a "
                                                      "second, so leave it out",
                                                      hand.rate_hz, HandSource{}.rate_hz));
    const auto add = [&](const std::string& option, const std::string& value) {
        start.words.push_back(fmt::format("--{}={}", option, value));
    };
    add("from", source_of(hand, asked.from));
    add("algorithm", hand.algorithm);
    add("object", object.name);
    if (object.size_m) add("size", fmt::format("{}", *object.size_m / millimetre));
    if (object.height_m) add("height", fmt::format("{}", *object.height_m / millimetre));
    if (names_mesh(object)) add("unit", object.unit);
    add("center", in_mm(object.centre));
    add("rotate", fmt::format("{},{},{}", object.angles_deg.x, object.angles_deg.y, object.angles_deg.z));
    // By its file: a name may be that of a shipped one, too. The session runs in a folder of its own.
    const std::string& array = scene.instrument.array.file;
    add("array", array.starts_with(shipped_prefix) ? array : std::filesystem::absolute(array).string());
    take_drawing(start, scene.project);
    take_table(start, scene.project.live);
    if (hand.frame)
        start.left_out += fmt::format("{}The whole recording plays, not frame {} alone.",
                                      start.left_out.empty() ? "" : " ", *hand.frame);
    return start;
}

Child::Command live_command(const LiveStart& start, const BoardPort& port) {
    Child::Command command{
        {own_program().string(), "live", "--scene=-", "--port=" + port.name}, start.folder->path(), {}};
    if (port.baud) command.words.push_back(fmt::format("--baud={}", *port.baud));
    command.words.insert(command.words.end(), start.words.begin(), start.words.end());
    return command;
}

}  // namespace haptogram::studio
