// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/calibration.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram {
namespace {

using section::assign;
using section::quoted_text;
using section::Section;

constexpr double radians_a_degree = std::numbers::pi / 180.0;

bool is_file(const std::string& array) { return array.find('/') != std::string::npos || array.ends_with(".toml"); }

bool is_calibration(const toml::table& root) { return root["format"].value<std::string>() == calibration_format; }

MeasuredElement read_element(const std::string& file, const toml::table& table, std::uint32_t number) {
    const Section section(file, table);
    section.only({"gain", "phase_deg", "reversed", "dead", "channel", "gain_error", "phase_error_deg"});
    MeasuredElement element;
    assign(element.dead, section.flag("dead"));
    for (const char* key : {"gain", "phase_deg", "reversed", "gain_error", "phase_error_deg"})
        if (element.dead && section.find(key) != nullptr)
            throw bad_input(section.at(key), fmt::format("{} says nothing of an element that is dead", key));
    assign(element.gain, section.number("gain", 1e-3, 1e3));
    assign(element.phase_rad, section.number("phase_deg", -360.0, 360.0), radians_a_degree);
    assign(element.reversed, section.flag("reversed"));
    element.channel = section.whole("channel", 0, 65535).value_or(number);
    element.gain_error = section.number("gain_error", 0.0, 1e3);
    if (const auto error = section.number("phase_error_deg", 0.0, 360.0))
        element.phase_error_rad = *error * radians_a_degree;
    return element;
}

std::string line_of(const MeasuredElement& element, std::uint32_t number) {
    std::string line = element.dead ? "dead = true"
                                    : fmt::format("gain = {:.4f}, phase_deg = {:.2f}", element.gain,
                                                  element.phase_rad / radians_a_degree);
    if (element.reversed) line += ", reversed = true";
    if (element.gain_error && !element.dead) line += fmt::format(", gain_error = {:.4f}", *element.gain_error);
    if (element.phase_error_rad && !element.dead)
        line += fmt::format(", phase_error_deg = {:.2f}", *element.phase_error_rad / radians_a_degree);
    return line + (element.channel == number ? "" : fmt::format(", channel = {}", element.channel));
}

/// Weights of those that are alive.
void weigh(std::vector<Element>& elements, Drive drive) {
    double least = std::numeric_limits<double>::infinity(), most = 0.0;
    for (const Element& element : elements) {
        const double gain = std::abs(element.response);
        if (gain > 0.0) least = std::min(least, gain);
        most = std::max(most, gain);
    }
    for (Element& element : elements) {
        const double gain = std::abs(element.response);
        if (gain > 0.0 && drive != Drive::full) element.weight = drive == Drive::weighed ? gain / most : least / gain;
    }
}

}  // namespace

Calibration load_calibration(const std::filesystem::path& path) {
    const std::string file = path.string();
    const toml::table root = section::parse(path);
    const Section whole(file, root);
    whole.only({"format", "array", "date", "temperature_c", "speed_m_s", "residual", "source_pa_m", "measured", "drive",
                "element"});
    if (whole.required(whole.text("format"), "format", fmt::format("\"{}\"", calibration_format)) != calibration_format)
        throw whole.wrong(*whole.find("format"), "format", fmt::format("\"{}\"", calibration_format));
    Calibration found;
    const std::string named =
        whole.required(whole.text("array"), "array", "the name of the shipped array, or the path of the array file");
    found.array = is_file(named) ? named_in(path.parent_path(), named).string() : named;
    assign(found.date, whole.text("date"));
    found.temperature_c = whole.number("temperature_c", -50.0, 100.0);
    found.speed_m_s = whole.number("speed_m_s", 100.0, 2000.0);
    found.residual = whole.number("residual", 0.0, 1e3);
    found.source_pa_m = whole.number("source_pa_m", 1e-3, 1e3);
    assign(found.measured, whole.text("measured"));
    if (found.source_pa_m.has_value() == found.measured.empty())
        throw bad_input(whole.at("source_pa_m"),
                        "source_pa_m and measured, which says how, go together; give both or "
                        "neither");
    if (const auto drive = whole.text("drive")) {
        const auto* const named_drive = std::ranges::find(drive_names, *drive, &std::pair<Drive, const char*>::second);
        if (named_drive == drive_names.end())
            throw whole.wrong(*whole.find("drive"), "drive", "\"full\", \"weighed\" or \"equalised\"");
        found.drive = named_drive->first;
    }
    const toml::array* list = root["element"].as_array();
    if (list == nullptr || list->empty() || !list->is_array_of_tables())
        throw bad_input(whole.at("element"),
                        "expected a list of elements in the order of the array file, each { gain = 1, phase_deg = 0 }");
    for (const toml::node& node : *list)
        found.elements.push_back(
            read_element(file, *node.as_table(), static_cast<std::uint32_t>(found.elements.size())));
    return found;
}

std::string to_text(const Calibration& calibration) {
    std::string text = fmt::format("format = \"{}\"\narray = {}\n", calibration_format, quoted_text(calibration.array));
    const auto add = [&](const char* key, const std::optional<double>& value, int digits) {
        if (value) text += fmt::format("{} = {:.{}g}\n", key, *value, digits);
    };
    if (!calibration.date.empty()) text += fmt::format("date = {}\n", quoted_text(calibration.date));
    add("temperature_c", calibration.temperature_c, 4);
    add("speed_m_s", calibration.speed_m_s, 6);
    add("residual", calibration.residual, 3);
    add("source_pa_m", calibration.source_pa_m, 4);
    if (!calibration.measured.empty()) text += fmt::format("measured = {}\n", quoted_text(calibration.measured));
    if (calibration.drive != Drive::full)
        text += fmt::format("drive = \"{}\"\n", drive_names[static_cast<std::size_t>(calibration.drive)].second);
    text += "element = [\n";
    for (std::uint32_t number = 0; number < calibration.elements.size(); ++number)
        text += fmt::format("    {{ {} }},  # {}\n", line_of(calibration.elements[number], number), number);
    return text + "]\n";
}

Array calibrated(Array array, const Calibration& calibration, const std::string& file) {
    if (calibration.elements.size() != array.elements.size())
        throw bad_input(file, fmt::format("{} elements were measured, but {} has {}; measure that array",
                                          calibration.elements.size(), calibration.array, array.elements.size()));
    std::vector<Element> by_channel(array.elements.size());
    std::vector<std::optional<std::size_t>> taken(array.elements.size());
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const MeasuredElement& one = calibration.elements[m];
        if (one.channel >= taken.size() || taken[one.channel])
            throw bad_input(
                file,
                fmt::format("element {} is on channel {}, {}; each needs its own, below {}", m, one.channel,
                            one.channel >= taken.size() ? "which the array has not"
                                                        : fmt::format("and so is element {}", *taken[one.channel]),
                            taken.size()));
        taken[one.channel] = m;
        if (one.channel != m) array.columns = 0;
        by_channel[one.channel] = array.elements[m];
        by_channel[one.channel].response =
            one.dead ? 0.0 : std::polar(one.gain, one.phase_rad + (one.reversed ? std::numbers::pi : 0.0));
    }
    weigh(by_channel, calibration.drive);
    array.elements = std::move(by_channel);
    array.file = file;
    array.name = std::filesystem::path(file).stem().string();
    if (calibration.source_pa_m) {
        array.transducer.source_pa_m = *calibration.source_pa_m;
        array.transducer.measured = calibration.measured;
    }
    return array;
}

std::optional<std::string> array_named_in(std::string_view text) {
    const toml::table root = section::parse_text(text, "calibration");
    const auto array = root["array"].value<std::string>();
    return is_calibration(root) && array && is_file(*array) ? array : std::nullopt;
}

std::string array_file_of(const std::filesystem::path& path) {
    if (!is_calibration(section::parse(path))) return path.string();
    std::string array = path_or_shipped(load_calibration(path).array, "arrays", ".toml", "array");
    if (is_calibration(section::parse(array)))
        throw bad_input(path.string(),
                        fmt::format("{} is a calibration, too; name the array file that it is of", array));
    return array;
}

}  // namespace haptogram
