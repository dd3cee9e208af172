// SPDX-License-Identifier: Apache-2.0
// A board that computes foci does so for the air that it is told: by the pulses at its pins, whose middles have to
// differ as the ways from two elements to the focus do, in that air.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/array/medium.hpp"
#include "haptogram/link/air.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/compile.hpp"
#include "reference_board.hpp"
#include "simulated_transport.hpp"

using namespace haptogram;

namespace {

constexpr double cycle = 1250;
const Vec3 spot{0.02, -0.01, 0.12};

struct Bench {
    interface::CoreConfiguration configuration = *interface::find_configuration("tile-100-wide");
    Array array = find_array("tile-10x10");
    sim::ReferenceBoard board{configuration};
    sim::SimulatedTransport line{board};
    link::Client client{line};

    Bench() {
        client.identify();
        Path still;
        still.steps = {{.foci = {{spot, 1.0}}, .periods = 1}};
        upload(client, compile(still, array, {"tile-100-wide", configuration.parameters}, 0, "image",
                               Method::gauss_newton, {}, ImageKind::foci)
                           .bundle.image);
    }
    /// Where in the carrier period the middle of each channel's pulse lies, 0 to 1.
    std::vector<double> middles() {
        std::vector<double> found(array.elements.size()), rise(found.size());
        std::uint64_t begun = 0;
        board.on_cycle_start([&](const sim::CycleStart& start) { begun = start.clock; });
        board.on_edge([&](const sim::Edge& edge) {
            const auto at = static_cast<double>(edge.clock);
            if (edge.rises)
                rise[edge.channel] = at;
            else
                found[edge.channel] =
                    std::fmod((0.5 * (rise[edge.channel] + at) - static_cast<double>(begun)) / cycle + 2.0, 1.0);
        });
        client.enable();
        client.start(1, 1, 0);
        board.run(static_cast<std::uint64_t>(40 * cycle));
        board.on_edge({});  // a pulse that is cut has another middle
        board.on_cycle_start({});
        client.turn_off();
        return found;
    }
    /// The worst of all channels, as a part of a turn, against the way of the sound.
    double error_at(double speed_m_s) {
        const std::vector<double> found = middles();
        double worst = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            const double ways =
                (distance(array.elements[0], spot) - distance(array.elements[i], spot)) * array.carrier_hz / speed_m_s;
            const double off = found[i] - found[0] - ways;
            worst = std::max(worst, std::abs(off - std::round(off)));
        }
        return worst;
    }
    std::vector<std::uint8_t> parameters() {
        return client.read(interface::parameters_base, static_cast<std::uint16_t>(2 * interface::parameters_words));
    }
};

}  // namespace

TEST_CASE("foci of a board follow the temperature of the air", "[air]") {
    Bench bench;
    const std::vector<std::uint8_t> before = bench.parameters();
    const double own = bench.array.medium.speed_m_s, warm = speed_of_sound(45.0);
    CHECK(bench.error_at(own) < 2e-3);
    CHECK(bench.error_at(warm) > 0.01);
    {
        link::AirOn air(bench.client, warm);
        CHECK(air.own_speed_m_s() == Approx(own).epsilon(1e-5));
        CHECK(bench.error_at(warm) < 2e-3);
        const double cold = speed_of_sound(-10.0);
        air.set(cold);
        CHECK(bench.error_at(cold) < 2e-3);
    }
    CHECK(bench.parameters() == before);
    CHECK(bench.error_at(own) < 2e-3);
}

TEST_CASE("a board that computes no foci keeps its air, and says why", "[air]") {
    sim::ReferenceBoard board("tile-100");
    sim::SimulatedTransport line(board);
    link::Client client(line);
    client.identify();
    CHECK_REFUSED(link::AirOn(client, 350.0));
}

TEST_CASE("what another air leaves of a focus is what the field says", "[air]") {
    const Array array = find_array("tile-10x10");
    Array other = array;
    other.medium.speed_m_s = speed_of_sound(40.0);
    // Drives for the one air, and the sound in the other.
    std::vector<std::complex<double>> drives, there;
    for (const Element& element : array.elements) {
        const auto phase_at = [&](const Array& air) {
            return 2.0 * std::numbers::pi / air.wavelength_m() * distance(element, spot);
        };
        drives.push_back(std::polar(1.0, phase_at(array)));
        there.push_back(std::polar(1.0, phase_at(other)));
    }
    const std::vector<Vec3> points{spot};
    const double kept =
        std::abs(pressure_at(other, drives, points).front()) / std::abs(pressure_at(other, there, points).front());
    CHECK(left_at_speed(array, spot, other.medium.speed_m_s) == Approx(kept).epsilon(1e-3));
    CHECK(kept < 0.999);
    CHECK(left_at_speed(array, spot, array.medium.speed_m_s) == Approx(1.0));
}
