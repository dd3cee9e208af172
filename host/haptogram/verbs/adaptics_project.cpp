// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/adaptics_project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/adaptics.hpp"

namespace haptogram {
namespace {

constexpr double most_steps = 400.0;                           // each a record, of which the usual core has so many
constexpr double most_of_a_circle = 16.0, least_points = 6.0;  // of a circle, that show its shape
constexpr double most_rate_hz = 1000.0;

}  // namespace

bool is_adaptics(std::string_view text) { return text.find("\"$DATA_FORMAT\"") != std::string_view::npos; }

Project project_from_adaptics(std::string_view text, const std::string& where) {
    AdapticsFrames pattern = frames_from_adaptics(text, where);
    const double lasts_s = pattern.frames.back().time_s;
    Project project;
    ShapeSource shape;
    if (pattern.diameter_m) {
        const double points = std::floor(most_steps / (adaptics_brush_hz * lasts_s));
        if (points < least_points)
            throw bad_input(where, fmt::format("it lasts {:g} s, and {:g} circles a second of {} points each are more "
                                               "than the {} steps that key frames are played in",
                                               lasts_s, adaptics_brush_hz, least_points, most_steps));
        shape.primitive.kind = "circle";
        shape.primitive.diameter = pattern.diameter_m;
        project.pace.frequency_hz = adaptics_brush_hz;
        project.points = static_cast<std::size_t>(std::min(points, most_of_a_circle));
    } else {
        shape.primitive.kind = "point";
        project.points = 1;
        project.rate_hz = std::min(most_steps / lasts_s, most_rate_hz);
    }
    project.shapes.push_back(shape);
    project.placement.center = pattern.centre;
    project.key_frames = std::move(pattern.frames);
    return project;
}

}  // namespace haptogram
