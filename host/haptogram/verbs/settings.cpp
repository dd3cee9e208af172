// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/settings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <type_traits>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/draw.hpp"
#include "haptogram/solve/segments.hpp"

namespace haptogram {
namespace {

bool of_shapes(const Project& p) { return p.is_of_shapes(); }
bool is_paced(const Project& p) { return p.pace.speed_m_s || p.pace.frequency_hz; }
bool can_be_paced(const Project& p) { return p.path.empty(); }
bool is_drawn(const Project& p) { return p.hand || (p.is_of_shapes() && is_paced(p)); }
bool is_sampled(const Project& p) {
    return p.hand ? p.hand->frame.has_value() : p.is_of_shapes() || p.path.ends_with(".adaptics");
}
/// Of a hand, lines at random are those of two algorithms.
bool has_chance(const Project& p) {
    return p.hand ? p.hand->algorithm == "E" || p.hand->algorithm == "F" : of_shapes(p);
}

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

template <class T>
std::optional<SettingValue> value_of(const T& value, const Setting& setting) {
    if constexpr (IsOptional<T>::value)
        return value ? value_of(*value, setting) : std::nullopt;
    else if constexpr (std::is_enum_v<T>)
        return std::string(std::get<Choices>(setting.kind)[static_cast<std::size_t>(value)]);
    else if constexpr (std::is_same_v<T, std::string>)
        return value.empty() ? std::nullopt : std::optional<SettingValue>(value);
    else if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, double>)
        return value;
    else
        return static_cast<std::uint64_t>(value);
}

template <class T>
void assign(T& target, const Setting& setting, const SettingValue& value) {
    if constexpr (IsOptional<T>::value) {
        assign(target.emplace(), setting, value);
    } else if constexpr (std::is_enum_v<T>) {
        const Choices names = std::get<Choices>(setting.kind);
        target = static_cast<T>(std::find(names.begin(), names.end(), std::get<std::string>(value)) - names.begin());
    } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, bool> || std::is_same_v<T, double>) {
        target = std::get<T>(value);
    } else {
        target = static_cast<T>(std::get<std::uint64_t>(value));
    }
}

template <auto member>
std::optional<SettingValue> get(const Project& project, const Setting& setting) {
    return value_of(project.*member, setting);
}
template <auto member>
void put(Project& project, const Setting& setting, const SettingValue& value) {
    assign(project.*member, setting, value);
}

// Of the three that say how fast, a project has one.
std::optional<SettingValue> get_rate(const Project& project, const Setting& setting) {
    return is_paced(project) ? std::nullopt : value_of(project.rate_hz, setting);
}
void put_rate(Project& project, const Setting&, const SettingValue& value) {
    project.pace = {};
    project.rate_hz = std::get<double>(value);
}
template <auto member>
std::optional<SettingValue> get_pace(const Project& project, const Setting& setting) {
    return value_of(project.pace.*member, setting);
}
template <auto member>
void put_pace(Project& project, const Setting&, const SettingValue& value) {
    project.pace = {};
    project.pace.*member = std::get<double>(value);
}

std::optional<SettingValue> get_fade(const Project& project, const Setting&) {
    return project.fade ? std::optional<SettingValue>(to_text(*project.fade)) : std::nullopt;
}
void put_fade(Project& project, const Setting&, const SettingValue& value) {
    project.fade = fade_of(std::get<std::string>(value)).value();  // of the right form
}

constexpr std::string_view jumps[] = {"hop", "blank"};
constexpr std::string_view laws[] = {"pressure", "radiation"};
constexpr std::string_view images[] = {"records", "foci"};
constexpr std::string_view segments[] = {hoshi_segments.name};
constexpr Numbers any_positive = {1e-6, 1e6};

/// What can have a setting: everything, when there is no test.
struct Scope {
    bool (*has)(const Project&) = nullptr;
    std::string_view subject{};
};
constexpr Scope for_shapes = {of_shapes, "shapes"};
constexpr Scope for_paced = {can_be_paced, "shapes and hands"};
constexpr Scope for_drawn = {is_drawn, "shapes that are drawn, by a speed or a frequency, and of hands"};
constexpr Scope for_sampled = {is_sampled,
                               "shapes, of an AdapTics pattern, and of one frame of a hand: add a frame to [hand]"};
constexpr Scope for_random = {has_chance, "shapes, and of a hand's algorithms E and F"};

constexpr Setting with(Setting setting, Scope scope, std::string_view one_of = {}) {
    setting.one_of = one_of;
    setting.applies = scope.has;
    setting.subject = scope.subject;
    return setting;
}

template <auto member>
constexpr Setting of(std::string_view key, std::string_view option, decltype(Setting::kind) kind,
                     std::string_view help) {
    return {.key = key, .option = option, .help = help, .kind = kind, .get = get<member>, .put = put<member>};
}

constexpr Setting own(std::string_view key, std::string_view option = {}) { return {.key = key, .option = option}; }

constexpr std::string_view how_fast = "how fast";
constexpr WholeNumbers seeds = {0, std::numeric_limits<std::int64_t>::max()};  // a TOML file holds no more
static_assert(usual_speed_m_s == 7.0);                                         // as the help of --speed says

constexpr Setting of_projects[] = {
    of<&Project::array>("array", "--array", FileOrName{},
                        "Array file (TOML) or shipped array; by default the board's, or tile-10x10"),
    of<&Project::board>("board", "--board", FileOrName{},
                        "Board file (TOML), shipped board (see haptogram board list) or configuration of the core such "
                        "as tile-100; by default what the array's file says under [board]"),
    of<&Project::path>("path", "--path", File{},
                       "A path instead of shapes: .json as --save-path writes it, .csv of time_ms, x_mm, y_mm, z_mm "
                       "and intensity, or an .adaptics pattern, looked at --points times"),
    with(of<&Project::points>("points", "--points", WholeNumbers{1, 65535},
                              "Focal points to take from a surface, a curve or a larger cloud; samples of an AdapTics "
                              "pattern; steps of the pass of a hand's frame"),
         for_sampled),
    with(of<&Project::seed>("seed", "--seed", seeds, "Seed of the sampling"), for_random),
    with(of<&Project::clip>("clip", "--clip", Flag{},
                            "Leave out points that the array cannot reach, instead of refusing the shape"),
         for_shapes),
    with({.key = "rate_hz",
          .option = "--rate",
          .help = "Passes over the points of the shape a second, in a short tour, Hz",
          .kind = any_positive,
          .get = get_rate,
          .put = put_rate},
         for_shapes, how_fast),
    with({.key = "speed_m_s",
          .option = "--speed",
          .help = "Draw the shape's curves, or its tour, at this many m/s (7 is usual)",
          .kind = any_positive,
          .get = get_pace<&Pace::speed_m_s>,
          .put = put_pace<&Pace::speed_m_s>},
         for_paced, how_fast),
    with({.key = "frequency_hz",
          .option = "--frequency",
          .help = "Draw the shape's curves this many times a second, Hz",
          .kind = any_positive,
          .get = get_pace<&Pace::frequency_hz>,
          .put = put_pace<&Pace::frequency_hz>},
         for_paced, how_fast),
    with(of<&Project::jump>("jump", "--jump", Choices(jumps),
                            "Between curves that are drawn: hop, which takes no time, or blank, silence for as long as "
                            "the way takes"),
         for_drawn),
    with(of<&Project::even>("even", "--even", Flag{},
                            "Choose dwells that make all points feel alike, with what the foci add to each other, "
                            "instead of equal ones; each point keeps at least a third of an equal one"),
         for_shapes),
    of<&Project::am>("am", "--am", FileOrName{},
                     "Amplitude over time: static, sine:HZ, square:HZ[:DUTY], abs-sine:HZ, triangle:HZ, sawtooth:HZ, "
                     "several with + between them, wav:FILE or csv:FILE"),
    of<&Project::am_law>("am_law", "--am-law", Choices(laws),
                         "What the waveform's values are: fractions of the pressure, or of the radiation pressure, "
                         "which is its square"),
    of<&Project::amplitude>("amplitude", "--amplitude", Numbers{1e-6, 1.0},
                            "Amplitude of all foci, as a fraction of the pressure that the array can make there"),
    with(
        {.key = "fade",
         .option = "--fade",
         .help = "Strongest at one side of the shapes (left, right, front, back, below or above): left:0.5 is the full "
                 "amplitude where x is least, half of it where x is most, and evenly between",
         .kind = Form{[](std::string_view text) { return fade_of(text).has_value(); }, fade_form, fade_pattern},
         .get = get_fade,
         .put = put_fade},
        for_shapes),
    of<&Project::magnitude>("magnitude", "--magnitude", any_positive,
                            "How strong each focus feels to a palm under --am, from the array's force and the "
                            "Multimodal paper's tables (see haptogram magnitude)"),
    of<&Project::quantise>("quantise", "--quantise", Choices(segments),
                           "Phases and pulse lengths as a device has them: hoshi (16 phases, pulses of 0 to 8 of 16 "
                           "segments; Hoshi et al. 2010)"),
    of<&Project::image>("image", {}, Choices(images),
                        "Records of timings, or foci from which the board computes them; by the board when it is not "
                        "there"),
    of<&Project::loops>("loops", "--loops", WholeNumbers{0, 65535},
                        "Passes when the image is played by itself; 0 is for ever"),
    with(own("place", "--center"), for_shapes),
    with(own({}, "--size"), for_shapes),
    with(own({}, "--rotate"), for_shapes),
    with(own({}, "--scale"), for_shapes),
    with(own("shape"), for_shapes),
    with(own("keyframe"), for_shapes),
    own("hand"),
    own("live"),
    own("trigger"),
};

std::string_view because(const Project& project) {
    if (!project.path.empty()) return "a path has its own places and times";
    if (project.hand) return "what a hand feels is where the hand meets the object, at a speed or a frequency";
    return "these shapes have neither a speed nor a frequency";  // the one thing that shapes can lack
}

const Setting* find(std::string_view name) {
    const auto* found = std::find_if(std::begin(of_projects), std::end(of_projects), [name](const Setting& one) {
        return !name.empty() && (name == one.option || name == one.key);
    });
    return found == std::end(of_projects) ? nullptr : found;
}

}  // namespace

std::span<const Setting> project_settings() { return of_projects; }

const Setting& setting_called(std::string_view name) {
    if (const Setting* one = find(name)) return *one;
    throw bad_argument("setting", fmt::format("a project has none that is called '{}'", name));
}

std::optional<SettingValue> default_of(const Setting& setting) {
    static const Project standard;
    return setting.get == nullptr ? std::nullopt : setting.get(standard, setting);
}

std::string why_idle(std::string_view name, const Project& project) {
    const Setting* one = find(name);
    if (one == nullptr || one->applies == nullptr || one->applies(project)) return {};
    return fmt::format("is of {}; {}", one->subject, because(project));
}

void require_effect(std::span<const std::string> given, const Project& project) {
    for (const std::string& option : given)
        if (const std::string why = why_idle(option, project); !why.empty()) throw bad_argument(option, why);
}

}  // namespace haptogram
