// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <type_traits>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/shape/draw.hpp"
#include "haptogram/shape/parameters.hpp"
#include "haptogram/solve/segments.hpp"

namespace haptogram {
namespace {

using Three = std::array<double, 3>;

bool of_shapes(const Project& p) { return p.is_of_shapes(); }
bool is_paced(const Project& p) { return p.pace.speed_m_s || p.pace.frequency_hz; }
bool can_be_paced(const Project& p) { return p.path.empty(); }
bool is_drawn(const Project& p) { return p.hand || (p.is_of_shapes() && is_paced(p)); }
bool is_pattern(const Project& p) { return p.path.ends_with(".adaptics"); }
bool is_sampled(const Project& p) { return p.hand ? p.hand->frame.has_value() : p.is_of_shapes() || is_pattern(p); }
/// Of a hand, lines at random are those of two algorithms.
bool has_chance(const Project& p) {
    return p.hand ? p.hand->algorithm == "E" || p.hand->algorithm == "F" : of_shapes(p);
}

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

template <class T>
std::optional<SettingValue> value_of(const T& value, const SettingText& setting) {
    if constexpr (IsOptional<T>::value)
        return value ? value_of(*value, setting) : std::nullopt;
    else if constexpr (std::is_enum_v<T>)
        return std::string(std::get<Choices>(setting.kind)[static_cast<std::size_t>(value)]);
    else if constexpr (std::is_same_v<T, std::string>)
        return value.empty() ? std::nullopt : std::optional<SettingValue>(value);
    else if constexpr (std::is_same_v<T, double>)
        return std::holds_alternative<Length>(setting.kind) ? exact_mm(value) : value;
    else if constexpr (std::is_same_v<T, Vec3>)
        return std::holds_alternative<Place>(setting.kind)
                   ? Three{exact_mm(value.x), exact_mm(value.y), exact_mm(value.z)}
                   : Three{value.x, value.y, value.z};
    else if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, Three>)
        return value;
    else
        return static_cast<std::uint64_t>(value);
}

template <class T>
void assign(T& target, const SettingText& setting, const SettingValue& value) {
    if constexpr (IsOptional<T>::value) {
        assign(target.emplace(), setting, value);
    } else if constexpr (std::is_enum_v<T>) {
        const Choices names = std::get<Choices>(setting.kind);
        target = static_cast<T>(std::find(names.begin(), names.end(), std::get<std::string>(value)) - names.begin());
    } else if constexpr (std::is_same_v<T, double>) {
        target = std::get<double>(value) * (std::holds_alternative<Length>(setting.kind) ? millimetre : 1.0);
    } else if constexpr (std::is_same_v<T, Vec3>) {
        const auto& [x, y, z] = std::get<Three>(value);
        target = std::holds_alternative<Place>(setting.kind) ? from_mm(x, y, z) : Vec3{x, y, z};
    } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
        target = static_cast<T>(std::get<std::uint64_t>(value));
    } else {
        target = std::get<T>(value);
    }
}

template <class Member>
struct OwnerOf;
template <class Owner, class Member>
struct OwnerOf<Member Owner::*> {
    using Type = Owner;
};
/// What a member is of.
template <auto first>
using Owner = typename OwnerOf<decltype(first)>::Type;

template <auto first, auto... rest>
std::optional<SettingValue> get(const Owner<first>& owner, const SettingText& setting) {
    return value_of(((owner.*first).*....*rest), setting);
}
template <auto first, auto... rest>
void put(Owner<first>& owner, const SettingText& setting, const SettingValue& value) {
    assign(((owner.*first).*....*rest), setting, value);
}

// Of the three that say how fast, a project has one.
std::optional<SettingValue> get_rate(const Project& project, const SettingText& setting) {
    return is_paced(project) ? std::nullopt : value_of(project.rate_hz, setting);
}
void put_rate(Project& project, const SettingText&, const SettingValue& value) {
    project.pace = {};
    project.rate_hz = std::get<double>(value);
}
template <auto member>
void put_pace(Project& project, const SettingText&, const SettingValue& value) {
    project.pace = {};
    project.pace.*member = std::get<double>(value);
}

std::optional<SettingValue> get_fade(const Project& project, const SettingText&) {
    return project.fade ? std::optional<SettingValue>(to_text(*project.fade)) : std::nullopt;
}
void put_fade(Project& project, const SettingText&, const SettingValue& value) {
    project.fade = fade_of(std::get<std::string>(value)).value();  // of the right form
}

std::optional<SettingValue> get_form(const KeyFrame& frame, const SettingText& setting) {
    return frame.shape == 0 ? std::nullopt : value_of(frame.shape, setting);
}

constexpr std::string_view jumps[] = {"hop", "blank"};
constexpr std::string_view laws[] = {"pressure", "radiation"};
constexpr std::string_view images[] = {"records", "foci"};
constexpr std::string_view segments[] = {hoshi_segments.name};
constexpr Numbers any_positive = {1e-6, 1e6};

/// What can have a setting: everything, when there is no test.
template <class Owner>
struct Scope {
    bool (*has)(const Owner&) = nullptr;
    std::string_view subject{};
};
constexpr Scope<Project> for_shapes = {of_shapes, "shapes"};
constexpr Scope<Project> for_paced = {can_be_paced, "shapes and hands"};
constexpr Scope<Project> for_drawn = {is_drawn, "shapes that are drawn, by a speed or a frequency, and of hands"};
constexpr Scope<Project> for_sampled = {
    is_sampled, "shapes, of an AdapTics pattern, and of one frame of a hand: add a frame to [hand]"};
constexpr Scope<Project> for_patterns = {is_pattern, "an AdapTics pattern"};
constexpr Scope<Project> for_random = {has_chance, "shapes, and of a hand's algorithms E and F"};

constexpr Scope<ShapeSource> for_files = {[](const ShapeSource& s) { return !s.file.empty(); }, "shape files"};
constexpr Scope<ShapeSource> for_built_in = {[](const ShapeSource& s) { return s.file.empty(); }, "built-in shapes"};

constexpr Scope<HandSource> for_poses = {[](const HandSource& hand) { return hand.recording.ends_with(".pose"); },
                                         "a .pose file"};

constexpr Scope<ObjectSource> for_tall = {[](const ObjectSource& object) { return has_height(object.name); },
                                          "a cone, a pyramid and a cylinder"};
constexpr Scope<ObjectSource> for_meshes = {names_mesh, "a mesh file"};

template <class Owner>
constexpr SettingOf<Owner> with(SettingOf<Owner> setting, Scope<Owner> scope, std::string_view one_of = {}) {
    setting.one_of = one_of;
    setting.applies = scope.has;
    setting.subject = scope.subject;
    return setting;
}

template <class Owner>
constexpr SettingOf<Owner> by(std::optional<SettingValue> (*get)(const Owner&, const SettingText&),
                              void (*put)(Owner&, const SettingText&, const SettingValue&), std::string_view key,
                              std::string_view option, decltype(SettingText::kind) kind, std::string_view help,
                              std::string_view needed = {}) {
    return {{.key = key, .option = option, .help = help, .kind = kind, .needed = needed}, nullptr, get, put};
}
template <auto first, auto... rest>
constexpr SettingOf<Owner<first>> of(std::string_view key, std::string_view option, decltype(SettingText::kind) kind,
                                     std::string_view help, std::string_view needed = {}) {
    return by<Owner<first>>(get<first, rest...>, put<first, rest...>, key, option, kind, help, needed);
}

constexpr Setting table(std::string_view key) { return {{.key = key}}; }

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
                       "and intensity, or an .adaptics pattern, of which --points samples are taken"),
    with(of<&Project::set>("set", "--set",
                           Form{[](std::string_view text) { return parameters_of(text).has_value(); }, parameters_form,
                                parameters_pattern},
                           "Parameters of an AdapTics pattern, in place of their defaults: NAME=VALUE, several with "
                           "commas between them"),
         for_patterns),
    with(of<&Project::points>("points", "--points", WholeNumbers{1, 65535},
                              "Focal points to take from a surface, a curve or a larger cloud; samples of an AdapTics "
                              "pattern; steps of the pass of a hand's frame"),
         for_sampled),
    with(of<&Project::seed>("seed", "--seed", seeds, "Seed of the sampling"), for_random),
    with(of<&Project::clip>("clip", "--clip", Flag{},
                            "Leave out points that the array cannot reach, instead of refusing the shape"),
         for_shapes),
    with(by(get_rate, put_rate, "rate_hz", "--rate", any_positive,
            "Passes over the points of the shape a second, in a short tour, Hz"),
         for_shapes, how_fast),
    with(by(get<&Project::pace, &Pace::speed_m_s>, put_pace<&Pace::speed_m_s>, "speed_m_s", "--speed", any_positive,
            "Draw the shape's curves, or its tour, at this many m/s (7 is usual)"),
         for_paced, how_fast),
    with(by(get<&Project::pace, &Pace::frequency_hz>, put_pace<&Pace::frequency_hz>, "frequency_hz", "--frequency",
            any_positive, "Draw the shape's curves this many times a second, Hz"),
         for_paced, how_fast),
    with(of<&Project::jump>("jump", "--jump", Choices(jumps),
                            "Between curves: hop, in no time, or blank, silence for as long as the way takes"),
         for_drawn),
    with(of<&Project::even>("even", "--even", Flag{}, "Let weak points last longer, so that all feel alike"),
         for_shapes),
    of<&Project::am>("am", "--am", FileOrName{},
                     "Amplitude over time: static, sine:HZ, square:HZ[:DUTY], abs-sine:HZ, triangle:HZ, sawtooth:HZ, "
                     "several with + between them, wav:FILE or csv:FILE"),
    of<&Project::am_law>("am_law", "--am-law", Choices(laws),
                         "What the waveform's values are: fractions of the pressure, or of the radiation pressure, "
                         "which is its square"),
    of<&Project::amplitude>("amplitude", "--amplitude", Numbers{1e-6, 1.0},
                            "Amplitude of all foci, as a fraction of the pressure that the array can make there"),
    with(by(get_fade, put_fade, "fade", "--fade",
            Form{[](std::string_view text) { return fade_of(text).has_value(); }, fade_form, fade_pattern},
            "Fade from one side of the shapes (left, right, front, back, below or above): left:0.5 is full amplitude "
            "at the least x, half of it at the greatest x, and linear between"),
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
    with(table("place"), for_shapes),
    with(table("shape"), for_shapes),
    with(table("keyframe"), for_shapes),
    table("hand"),
    table("live"),
    table("trigger"),
};

constexpr std::string_view units[] = {"mm", "cm", "m", "inch", "in"};
constexpr std::string_view axes[] = {"y", "z"};
constexpr std::string_view eases[] = {"linear", "smooth", "step"};
constexpr std::string_view algorithms[] = {"A", "B", "C", "D", "E", "F", "G", "H", "I", "J", "K", "L"};
constexpr Numbers factors = {1e-9, 1e9};

constexpr SettingOf<Placement> of_places[] = {
    of<&Placement::scale>("scale", "--scale", factors, "Multiply every coordinate"),
    of<&Placement::size_m>("size_mm", "--size", Length{}, "Scale so that the largest extent is this many mm"),
    of<&Placement::rotate_deg>("rotate_deg", "--rotate", Turn{},
                               "Turn about the centre, degrees about x, then y, then z"),
    of<&Placement::center>("center_mm", "--center", Place{},
                           "Move the bounding box's centre to x,y,z mm (built-in shapes: 0,0,130)"),
};

constexpr SettingOf<KeyFrame> of_key_frames[] = {
    of<&KeyFrame::time_s>("time_s", {}, Numbers{0.0, 1e6}, "When the shapes are there, s since the path begins",
                          "seconds since the path begins"),
    of<&KeyFrame::move>("move_mm", {}, Place{}, "How far they have moved from where they were placed"),
    of<&KeyFrame::turn_deg>("rotate_deg", {}, Turn{}, "Turned about their centre, degrees about x, then y, then z"),
    of<&KeyFrame::scale>("scale", {}, factors, "Grown about their centre"),
    of<&KeyFrame::amplitude>("amplitude", {}, Numbers{0.0, 1.0}, "How strong they are"),
    of<&KeyFrame::am_hz>("am_hz", {}, Numbers{0.0, 1e6},
                         "How often the amplitude rises and falls a second, as a cosine from 0 to 1; 0: it is steady"),
    of<&KeyFrame::ease>("ease", {}, Choices(eases), "How it goes on to the next; step stays until then"),
    of<&KeyFrame::mark>("mark", {}, Flag{}, "A board's trigger output tells it"),
    by(get_form, put<&KeyFrame::shape>, "shape", {}, WholeNumbers{1, 65535},
       "Number of the shape that they have become; by default those that no key frame names"),
};

constexpr SettingOf<ObjectSource> of_objects[] = {
    of<&ObjectSource::name>("object", {}, FileOrName{}, "A built-in object, or a file with a closed mesh"),
    of<&ObjectSource::size_m>("size_mm", "--size", Length{},
                              "Edge or diameter of the object, largest extent of a mesh, mm (default: 100, a mesh as "
                              "it is)"),
    with(of<&ObjectSource::height_m>("height_mm", "--height", Length{},
                                     "Height of a cone, pyramid or cylinder, mm (default: the size)"),
         for_tall),
    of<&ObjectSource::centre>("center_mm", "--center", Place{}, "Center of the object: x,y,z mm"),
    of<&ObjectSource::angles_deg>("rotate_deg", "--rotate", Turn{},
                                  "Turns of the object: degrees about x, then y, then z"),
    with(of<&ObjectSource::unit>("unit", "--unit", Choices(units), "Unit of a mesh file's coordinates"), for_meshes),
};

constexpr SettingOf<HandSource> of_hands[] = {
    of<&HandSource::recording>("recording", "--hand", File{},
                               "A Leap recording (.json, .lz), poses (.pose), or synthetic:press, slide, grasp or "
                               "wave, with :HEIGHT of the palm in mm behind it if it is not 200",
                               "a file of recorded hands, or \"synthetic:SCRIPT\" in quotes"),
    with(of<&HandSource::model>("model", "--hand-model", FileOrName{},
                                "Bones of a .pose file (default: model_hand.json beside it)"),
         for_poses),
    with(of<&HandSource::rate_hz>("frames_hz", "--hand-rate", Numbers{1e-3, 1e6}, "Frames a second of a .pose file"),
         for_poses),
    of<&HandSource::algorithm>("algorithm", {}, Choices(algorithms), "How the hand feels it (see haptogram render)"),
    of<&HandSource::frame>("frame", "--frame", WholeNumbers{1, 1'000'000'000},
                           "Only this frame, from 1: one pass, to be repeated"),
};

std::string_view because(const Project& project) {
    if (!project.path.empty()) return "a path has its own places and times";
    if (project.hand) return "what a hand feels is where the hand meets the object, at a speed or a frequency";
    return "these shapes have neither a speed nor a frequency";  // the one thing that shapes can lack
}

template <class Owner>
const SettingOf<Owner>* find(std::string_view name, Settings<Owner> settings) {
    const auto found = std::find_if(settings.begin(), settings.end(), [name](const auto& one) {
        return !name.empty() && (name == one.option || name == one.key);
    });
    return found == settings.end() ? nullptr : &*found;
}

}  // namespace

std::string option_text(const SettingValue& value) {
    if (const auto* three = std::get_if<Three>(&value)) return fmt::format("{}", fmt::join(*three, ","));
    return std::visit([](const auto& one) { return fmt::format("{}", one); }, value);
}

Settings<Project> project_settings() { return of_projects; }
Settings<Placement> place_settings() { return of_places; }
Settings<KeyFrame> key_frame_settings() { return of_key_frames; }
Settings<HandSource> hand_settings() { return of_hands; }
Settings<ObjectSource> object_settings() { return of_objects; }
Settings<ShapeSource> shape_settings() {
    static const std::vector<std::string> names = primitive_kinds();
    static const std::vector<std::string_view> kinds(names.begin(), names.end());
    using Source = ShapeSource;
    using Measures = PrimitiveSpec;
    static const SettingOf<Source> of_shapes[] = {
        of<&Source::file>("file", {}, File{}, "A PLY, OBJ, STL, OFF, PCD, 3MF, glTF, SVG, XYZ or CSV file"),
        with(of<&Source::unit>("unit", "--unit", Choices(units), "Unit of the coordinates in the files"), for_files),
        with(of<&Source::up>("up", "--up", Choices(axes),
                             "Axis of the files that points upwards; z when it is not given"),
             for_files),
        of<&Source::primitive, &Measures::kind>("kind", {}, Choices(kinds), "Or a built-in shape"),
        with(of<&Source::primitive, &Measures::diameter>("diameter_mm", "--diameter", Length{},
                                                         "Diameter of a built-in round shape, mm"),
             for_built_in),
        with(of<&Source::primitive, &Measures::length>("length_mm", "--length", Length{},
                                                       "Length of a built-in line or plus, or the edge of a built-in "
                                                       "straight-edged shape, mm"),
             for_built_in),
        with(of<&Source::primitive, &Measures::height>("height_mm", "--height", Length{},
                                                       "Height of a built-in cone, cylinder or helix, mm"),
             for_built_in),
        with(of<&Source::primitive, &Measures::sides>("sides", "--sides", WholeNumbers{3, 1000},
                                                      "Sides of a built-in polygon"),
             for_built_in),
        with(of<&Source::primitive, &Measures::turns>("turns", "--turns", Numbers{1e-3, 1e3},
                                                      "Turns of a built-in helix"),
             for_built_in),
    };
    return of_shapes;
}

const Setting& setting_called(std::string_view name) {
    if (const Setting* one = find(name, project_settings())) return *one;
    throw bad_argument("setting", fmt::format("a project has none that is called '{}'", name));
}

std::string why_idle(std::string_view name, const Project& project) {
    const bool of_place = name.starts_with("--") && find(name, place_settings()) != nullptr;
    const Setting* one = find(of_place ? "place" : name, project_settings());
    if (one == nullptr || one->has_effect(project)) return {};
    if (one->applies == is_pattern) return fmt::format("is of {}, and this is none", one->subject);
    return fmt::format("is of {}; {}", one->subject, because(project));
}

void require_effect(std::span<const std::string> given, const Project& project) {
    for (const std::string& option : given)
        if (const std::string why = why_idle(option, project); !why.empty()) throw bad_argument(option, why);
}

}  // namespace haptogram
