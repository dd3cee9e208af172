// SPDX-License-Identifier: Apache-2.0
// Measures boundary elements on a finger for tools/bench.py, on one thread; prints one JSON object. Times are the least
// of several runs, as other programs only add to them.
#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/scattering/scatterer.hpp"
#include "haptogram/scattering/shells.hpp"
#include "haptogram/scattering/skin.hpp"
#include "haptogram/shape/place.hpp"
#include "least.hpp"

namespace {

using namespace haptogram;
using namespace haptogram::scattering;
using haptogram::bench::least_s;

constexpr double edge_m = 1.16e-3;  // 4320 triangles or so on 5 cm of a finger, as the paper Fingers has them

std::vector<float> radiation_of_ten(const Array& array, const Body& body, const Scatterer& scatterer, const Skin& skin,
                                    double around_mm) {
    std::vector<IncidentSound> sounds;
    for (int i = 0; i < 10; ++i) {
        const Vec3 focus = from_mm(around_mm + i, 2.0, 130.0);
        sounds.push_back(incident_from(array, ideal_drives(array, focus), body));
    }
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    std::vector<float> last;
    for (const auto& pressure : scatterer.pressures(sounds).pressure)
        last = skin.radiation_pressure(pressure, k, array.medium);
    return last;
}

}  // namespace

int main() {
    const Array array = find_array("tile-10x10");
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    const Shape lying = placed_at(Shape{{capsule_mesh(8e-3, 50e-3, edge_m)}},
                                  {.rotate_deg = {0.0, 90.0, 0.0}, .center = from_mm(0, 0, 138)});
    const Mesh& mesh = std::get<Mesh>(lying.pieces.front());
    nlohmann::ordered_json measured;
    double sum = 0.0;
    measured["cold_s"] = least_s(5, [&] {
        const Body body = body_of(mesh, "finger");
        const Scatterer scatterer(body, k);
        sum += static_cast<double>(radiation_of_ten(array, body, scatterer, Skin(body), -5.0).front());
    });
    const Body body = body_of(mesh, "finger");
    const Skin skin(body);
    Scatterer scatterer(body, k);
    measured["factorise_s"] = least_s(1, [&] { scatterer.factorise(); });
    double around = -10.0;
    measured["further_s"] = least_s(
        10, [&] { sum += static_cast<double>(radiation_of_ten(array, body, scatterer, skin, around += 1.0).front()); });
    measured["triangles"] = body.panels.size();
    if (sum == 0.0) return 1;  // so that no compiler leaves the work out
    fmt::print("{}\n", measured.dump());
    return 0;
}
