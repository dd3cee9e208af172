// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/skin_sense.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/perception/felt.hpp"

namespace haptogram::live {
namespace {

using std::numbers::pi;

constexpr double patch_m = 2.5e-3;    ///< of the patches
constexpr double behind_m = 12.5e-3;  ///< of the finger behind its round end

Vec3 beside(Vec3 a) { return unit(cross(a, std::abs(a.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})); }

}  // namespace

SkinSense::SkinSense(const Array& array, const SenseOptions& options)
    : carrier_hz_(array.carrier_hz), options_(options), weigher_(array), tables_(perception::find_tables()) {
    (void)perception::threshold_interval(tables_, perception::Region::finger, options.grip_n);
}

/// All around the round end and the first of the cylinder.
std::vector<SkinSense::Patch> SkinSense::skin_of(const FingerForm& finger) {
    const Vec3 x = beside(finger.to_hand), y = cross(finger.to_hand, x);
    std::vector<Patch> skin;
    const double round_m = 0.5 * pi * finger.radius;
    for (double way = 0.5 * patch_m; way < round_m + behind_m; way += patch_m) {
        const double angle = std::min(way / finger.radius, 0.5 * pi);
        const double radius = finger.radius * std::sin(angle);
        const double along = way < round_m ? -finger.radius * std::cos(angle) : way - round_m;
        const auto count = std::max(3, static_cast<int>(std::lround(2.0 * pi * radius / patch_m)));
        for (int i = 0; i < count; ++i) {
            const double turn = 2.0 * pi * i / count;
            skin.push_back(
                {finger.tip + along * finger.to_hand + (radius * std::cos(turn)) * x + (radius * std::sin(turn)) * y,
                 patch_m * 2.0 * pi * radius / count});
        }
    }
    return skin;
}

/// Radiation pressure of each patch, in each step.
std::vector<std::vector<double>> SkinSense::pressures(const Path& path, const std::vector<Patch>& skin,
                                                      const FingerForm& finger) {
    std::vector<Vec3> foci, places;
    for (const PathStep& step : path.steps)
        for (const Focus& focus : step.foci)
            if (std::find(foci.begin(), foci.end(), focus.position) == foci.end()) foci.push_back(focus.position);
    for (const Patch& patch : skin) places.push_back(patch.place);
    const auto full = weigher_.radiation_pa(places, foci, finger);
    if (!full) return {};
    std::vector<std::vector<double>> found(skin.size(), std::vector<double>(path.steps.size()));
    for (std::size_t j = 0; j < path.steps.size(); ++j)
        for (const Focus& focus : path.steps[j].foci) {
            const auto which =
                static_cast<std::size_t>(std::find(foci.begin(), foci.end(), focus.position) - foci.begin());
            for (std::size_t i = 0; i < skin.size(); ++i)
                found[i][j] += focus.amplitude * focus.amplitude * (*full)[which * skin.size() + i];
        }
    return found;
}

std::optional<Sensed> SkinSense::feel(const Path& path, const FingerForm& finger, std::mt19937_64& random) {
    const std::vector<Patch> skin = skin_of(finger);
    const std::vector<std::vector<double>> pressure = pressures(path, skin, finger);
    if (pressure.empty()) return {};
    const double rate_hz = carrier_hz_ / path.steps.front().periods;
    Sensed sensed{.place = {}, .over_db = -HUGE_VAL};
    Vec3 sum;
    double weights = 0.0;
    for (const Patch& here : skin) {
        std::vector<double> force(path.steps.size());
        for (std::size_t i = 0; i < skin.size(); ++i)
            if (distance(skin[i].place, here.place) < 0.5 * options_.contact_m)
                for (std::size_t j = 0; j < force.size(); ++j) force[j] += skin[i].area * pressure[i][j];
        const perception::Felt felt = perception::felt_of(perception::lines_of(force, rate_hz), tables_,
                                                          perception::Region::finger, options_.grip_n, 1);
        if (felt.lines.empty()) continue;
        const double over_db = felt.lines.front().over_db;
        sensed.over_db = std::max(sensed.over_db, over_db);
        if (over_db <= 0.0) continue;
        const double weight = here.area * (std::pow(10.0, over_db / 20.0) - 1.0);
        sum = sum + weight * here.place;
        weights += weight;
    }
    std::normal_distribution<double> normal;
    const bool is_felt = sensed.over_db + options_.threshold_sd_db * normal(random) > 0.0 && weights > 0.0;
    const double x = normal(random), y = normal(random), z = normal(random);
    if (!is_felt) return {};
    sensed.place = sum * (1.0 / weights) + options_.place_sd_m * Vec3{x, y, z};
    return sensed;
}

}  // namespace haptogram::live
