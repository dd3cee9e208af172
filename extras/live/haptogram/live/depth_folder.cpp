// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/depth_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <utility>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/base/toml_value.hpp"
#include "haptogram/live/depth_png.hpp"

namespace haptogram {
namespace {

namespace fs = std::filesystem;
using section::number_text;

constexpr const char* format_name = "haptogram-depth-1";

Vec3 direction(const section::Section& keys, const char* key) {
    const auto numbers = keys.required(keys.numbers(key, 3), key, "a list of 3 numbers");
    return {numbers[0], numbers[1], numbers[2]};
}

DepthCamera read_camera(const section::Section& keys) {
    keys.only({"folder", "width", "height", "focal_px", "centre_px", "unit_mm", "baseline_mm", "position_mm", "right",
               "forward"});
    DepthCamera camera;
    camera.width = keys.required(keys.whole("width", 1, 65535), "width", "pixels");
    camera.height = keys.required(keys.whole("height", 1, 65535), "height", "pixels");
    const auto focal = keys.required(keys.numbers("focal_px", 2), "focal_px", "a list of 2 numbers");
    const auto centre = keys.required(keys.numbers("centre_px", 2), "centre_px", "a list of 2 numbers");
    camera.focal_x_px = focal[0];
    camera.focal_y_px = focal[1];
    camera.centre_x_px = centre[0];
    camera.centre_y_px = centre[1];
    if (!(focal[0] > 0.0 && focal[1] > 0.0)) throw bad_input(keys.at("focal_px"), "focal_px must be more than 0");
    camera.unit_m = keys.required(keys.number("unit_mm", 1e-6, 1e3), "unit_mm", "the length of a count") * millimetre;
    camera.baseline_m = keys.number("baseline_mm", 1e-3, 1e6).value_or(50.0) * millimetre;
    const Vec3 place = direction(keys, "position_mm");
    camera.pose.origin = from_mm(place.x, place.y, place.z);
    camera.pose.x = direction(keys, "right");
    camera.pose.z = direction(keys, "forward");
    constexpr double slack = 1e-6;
    if (std::abs(norm(camera.pose.x) - 1.0) > slack || std::abs(norm(camera.pose.z) - 1.0) > slack ||
        std::abs(dot(camera.pose.x, camera.pose.z)) > slack)
        throw bad_input(keys.at("forward"),
                        fmt::format("right and forward must have length 1 and be at right angles, found lengths of {} "
                                    "and {}, and a product of {}",
                                    norm(camera.pose.x), norm(camera.pose.z), dot(camera.pose.x, camera.pose.z)));
    camera.pose.y = cross(camera.pose.z, camera.pose.x);
    return camera;
}

/// The number that a picture's name is. Other files than .png are none of ours.
std::optional<std::uint64_t> number_of(const fs::path& file) {
    if (file.extension() != ".png") return {};
    const std::string stem = file.stem().string();
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (error != std::errc{} || end != stem.data() + stem.size())
        throw bad_input(file.string(), "the name of a picture must be the number of its shot, such as 0130.png");
    return number;
}

}  // namespace

DepthCameras cameras_from_toml(std::string_view text, const std::string& where) {
    const toml::table root = section::parse_text(text, where);
    const section::Section keys(where, root);
    keys.only({"format", "rate_hz", "camera"});
    const auto format = keys.required(keys.text("format"), "format", fmt::format("\"{}\"", format_name));
    if (format != format_name)
        throw bad_input(keys.at("format"), fmt::format("format must be \"{}\", found \"{}\"", format_name, format));
    DepthCameras found;
    found.rate_hz = keys.required(keys.number("rate_hz", 0.1, 10e3), "rate_hz", "shots a second");
    const toml::array* list = root["camera"].as_array();
    if (list == nullptr || list->empty() || !list->is_array_of_tables())
        throw bad_input(where, "there is no camera; expected a table [[camera]] for each");
    for (const toml::node& entry : *list) {
        const section::Section camera(where, *entry.as_table());
        found.cameras.push_back(read_camera(camera));
        found.folders.push_back(camera.text("folder"));
        found.lines.push_back(camera.at(found.folders.back() ? "folder" : "width"));
    }
    return found;
}

DepthFolder::DepthFolder(const fs::path& folder) {
    const fs::path file = folder / "cameras.toml";
    const DepthCameras found = cameras_from_toml(read_file(file), file.string());
    rate_hz_ = found.rate_hz;
    cameras_ = found.cameras;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
        if (!found.folders[i])
            throw bad_input(found.lines[i], fmt::format("camera {} has no folder, in which its pictures are", i + 1));
        const fs::path pictures = folder / *found.folders[i];
        std::error_code error;
        auto& numbered = pictures_.emplace_back();
        for (const auto& entry : fs::directory_iterator(pictures, error))
            if (const auto number = number_of(entry.path())) numbered.push_back({*number, entry.path()});
        if (error)
            throw bad_input(found.lines[i], fmt::format("{} cannot be read: {}", pictures.string(), error.message()));
        std::sort(numbered.begin(), numbered.end(),
                  [](const Picture& a, const Picture& b) { return a.number < b.number; });
    }
    if (std::all_of(pictures_.begin(), pictures_.end(), [](const auto& of_camera) { return of_camera.empty(); }))
        throw bad_input(folder.string(), "there are no pictures in it; expected files such as 0001.png");
    next_.assign(cameras_.size(), 0);
}

std::optional<DepthShot> DepthFolder::next() {
    std::optional<std::uint64_t> first;
    for (std::size_t i = 0; i < cameras_.size(); ++i)
        if (next_[i] < pictures_[i].size()) first = std::min(first.value_or(UINT64_MAX), pictures_[i][next_[i]].number);
    if (!first) return {};
    DepthShot shot{*first, static_cast<double>(*first) / rate_hz_, {}};
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
        shot.pictures.emplace_back();
        if (next_[i] == pictures_[i].size() || pictures_[i][next_[i]].number != *first) continue;
        const fs::path& file = pictures_[i][next_[i]++].file;
        shot.pictures.back() = depth_from_png(read_file(file), file.string(), cameras_[i]);
    }
    return shot;
}

std::string cameras_to_toml(const std::vector<DepthCamera>& cameras, double rate_hz) {
    std::string text = fmt::format("format = \"{}\"\nrate_hz = {}\n", format_name, number_text(rate_hz));
    const auto list = [](std::initializer_list<double> numbers) {
        std::string all;
        for (const double each : numbers) all += (all.empty() ? "" : ", ") + number_text(each);
        return "[" + all + "]";
    };
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const DepthCamera& c = cameras[i];
        const Vec3 &place = c.pose.origin, &right = c.pose.x, &forward = c.pose.z;
        text += fmt::format(
            "\n[[camera]]\nfolder = \"camera{}\"\nwidth = {}\nheight = {}\nfocal_px = {}\ncentre_px = {}\n"
            "unit_mm = {}\nbaseline_mm = {}\nposition_mm = {}\nright = {}\nforward = {}\n",
            i + 1, c.width, c.height, list({c.focal_x_px, c.focal_y_px}), list({c.centre_x_px, c.centre_y_px}),
            number_text(exact_mm(c.unit_m)), number_text(exact_mm(c.baseline_m)),
            list({exact_mm(place.x), exact_mm(place.y), exact_mm(place.z)}), list({right.x, right.y, right.z}),
            list({forward.x, forward.y, forward.z}));
    }
    return text;
}

DepthRecorder::DepthRecorder(fs::path folder, const std::vector<DepthCamera>& cameras, double rate_hz)
    : folder_(std::move(folder)), cameras_(cameras) {
    if (fs::exists(folder_ / "cameras.toml"))
        throw bad_input(folder_.string(), "it holds a recording already; name another folder");
    std::error_code error;
    for (std::size_t i = 0; i < cameras_.size() && !error; ++i)
        fs::create_directories(folder_ / fmt::format("camera{}", i + 1), error);
    if (error) throw bad_input(folder_.string(), fmt::format("cannot be made: {}", error.message()));
    write_file(folder_ / "cameras.toml", cameras_to_toml(cameras_, rate_hz));
}

void DepthRecorder::write(const DepthShot& shot) const {
    for (std::size_t i = 0; i < cameras_.size(); ++i)
        if (shot.pictures.at(i))
            write_file(folder_ / fmt::format("camera{}/{:06}.png", i + 1, shot.number),
                       depth_to_png(*shot.pictures[i], cameras_[i]));
}

}  // namespace haptogram
