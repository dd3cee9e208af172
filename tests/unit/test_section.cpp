// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/hand/surface.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

/// Points on a part of an ellipse of 8 × 6.5 mm around (1, −2) mm, at even parameters to both sides of the end of its
/// short axis, with noise: what a camera sees of a finger that lies before it.
std::vector<PlanePoint> noisy_arc(double cover_deg, std::mt19937_64& random, std::size_t count = 200) {
    std::normal_distribution<double> noise(0.0, 0.3e-3);
    std::vector<PlanePoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle =
            (cover_deg * (static_cast<double>(i) + 0.5) / static_cast<double>(count) + 90.0 - 0.5 * cover_deg) * pi /
            180.0;
        points.push_back(
            {1e-3 + 8e-3 * std::cos(angle) + noise(random), -2e-3 + 6.5e-3 * std::sin(angle) + noise(random)});
    }
    return points;
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

Ellipse lying(double half_major, double half_minor) {
    Ellipse e;
    e.half_major = half_major;
    e.half_minor = half_minor;
    return e;
}

}  // namespace

TEST_CASE("section: ten exact points give their ellipse back (F5)") {
    std::vector<PlanePoint> points;
    const double turn = 30.0 * pi / 180.0;
    for (int i = 0; i < 10; ++i) {
        const double angle = 2.0 * pi * i / 10.0, x = 6e-3 * std::cos(angle), y = 4e-3 * std::sin(angle);
        points.push_back(
            {1e-3 + x * std::cos(turn) - y * std::sin(turn), 2e-3 + x * std::sin(turn) + y * std::cos(turn)});
    }
    const auto e = fit_ellipse(points);
    REQUIRE(e.has_value());
    CHECK(std::abs(e->x - 1e-3) < 1e-12);
    CHECK(std::abs(e->y - 2e-3) < 1e-12);
    CHECK(std::abs(e->half_major - 6e-3) < 1e-12);
    CHECK(std::abs(e->half_minor - 4e-3) < 1e-12);
    CHECK(std::abs(std::remainder(e->angle - turn, pi)) < 1e-9);
}

TEST_CASE("section: what the direct fit makes of parts of an outline, and the constrained fit of the same (F4)") {
    std::mt19937_64 random(Catch::rngSeed());
    struct Row {
        double cover, major, minor, off;
    };
    // Medians from numpy's own fits.
    for (const Row& row : {Row{360, 8.00, 6.52, 0.0}, Row{270, 8.02, 6.49, 0.0}, Row{180, 7.79, 5.58, 0.89},
                           Row{150, 7.22, 4.30, 2.14}, Row{120, 6.15, 2.69, 3.77}}) {
        INFO(row.cover);
        std::vector<double> major, minor, off;
        double size = 0.0, x = 0.0, y = 0.0;
        constexpr int rounds = 400;
        for (int round = 0; round < rounds; ++round) {
            const auto points = noisy_arc(row.cover, random);
            const auto direct = fit_ellipse(points);
            REQUIRE(direct.has_value());
            major.push_back(1e3 * direct->half_major);
            minor.push_back(1e3 * direct->half_minor);
            off.push_back(1e3 * std::hypot(direct->x - 1e-3, direct->y + 2e-3));
            const auto held = fit_constrained(points, 0.8125);
            REQUIRE(held.has_value());
            size += 1e3 * held->half_major / rounds;
            x += 1e3 * held->x / rounds;
            y += 1e3 * held->y / rounds;
        }
        CHECK(median(major) == Approx(row.major).margin(0.06));
        CHECK(median(minor) == Approx(row.minor).margin(0.06));
        if (row.off > 0.0) CHECK(median(off) == Approx(row.off).margin(0.12));
        CHECK(size == Approx(8.0).epsilon(0.005));
        CHECK(std::hypot(x - 1.0, y + 2.0) < 0.05);
    }
}

TEST_CASE("section: one side of a finger is fitted as half of a finger, the whole of it as it is") {
    std::mt19937_64 random(Catch::rngSeed());
    const Vec3 surface{0.01, 0.02, 0.2}, inward{0, 0.6, -0.8};
    const Vec3 x{1, 0, 0}, y = cross(inward, x);
    const auto in_space = [&](const std::vector<PlanePoint>& points) {
        std::vector<Vec3> there;
        for (const PlanePoint& p : points) there.push_back(surface + p[0] * x + p[1] * y + 1e-3 * inward);
        return there;
    };
    const Vec3 centre = surface + 1e-3 * x - 2e-3 * y;
    const auto whole = section_of(in_space(noisy_arc(360, random)), surface, inward);
    REQUIRE(whole.has_value());
    CHECK_FALSE(whole->constrained);
    CHECK(distance(whole->ellipse.centre, centre) < 0.2e-3);
    CHECK(std::abs(dot(whole->ellipse.centre - surface, inward)) < 1e-12);
    CHECK(dot(cross(whole->ellipse.major, whole->ellipse.minor), inward) == Approx(1.0));
    const auto half = section_of(in_space(noisy_arc(150, random)), surface, inward, -1.0 * y);
    REQUIRE(half.has_value());
    CHECK(half->constrained);
    CHECK(distance(half->ellipse.centre, centre) < 0.5e-3);
    CHECK(half->ellipse.half_major == Approx(8e-3).epsilon(0.05));
    CHECK(half->ellipse.half_minor == Approx(6.5e-3).epsilon(0.05));
    CHECK(section_of(in_space(noisy_arc(150, random)), surface, inward)->constrained);  // the sight is found by itself
    CHECK_FALSE(section_of(std::vector<Vec3>(4, surface), surface, inward).has_value());
    CHECK_FALSE(section_of(std::vector<Vec3>(50, surface), surface, inward).has_value());
}

TEST_CASE("ring: perimeters, and the speed of a focus at 100 turns a second (F6)") {
    struct Row {
        double a, b, perimeter;
    };
    for (const Row& row :
         {Row{3, 2, 15.865}, Row{5, 4, 28.362}, Row{6, 4, 31.731}, Row{8, 6, 44.207}, Row{10, 7, 53.824}})
        CHECK(1e3 * lying(row.a * 1e-3, row.b * 1e-3).perimeter() == Approx(row.perimeter).margin(5e-4));
    CHECK(lying(5e-3, 5e-3).perimeter() == Approx(2.0 * pi * 5e-3));
    CHECK(100.0 * lying(6e-3, 4e-3).perimeter() == Approx(3.17).margin(5e-3));
}

TEST_CASE("ring: ten points of 1 ms, evenly along the outline, from where the focus is (F1)") {
    Ellipse e = lying(6e-3, 4e-3);
    e.centre = {0.01, 0, 0.15};
    const Vec3 start = e.at(1.234);
    const std::vector<std::optional<Vec3>> starts{start};
    const Path path = ring_path(std::vector<Ellipse>{e}, starts, 40e3);
    REQUIRE(path.steps.size() == 10);
    CHECK(path.periods() == 400);  // exactly 100 Hz
    for (const PathStep& step : path.steps) CHECK(step.periods == 40);
    CHECK(distance(path.steps[0].foci.at(0).position, start) < 0.03e-3);
    // Lengths between neighbours by many short chords, which know nothing of elliptic integrals.
    double shortest = 1.0, longest = 0.0;
    for (std::size_t j = 0; j < 10; ++j) {
        const auto parameter = [&](std::size_t k) {
            const Vec3 p = path.steps[k % 10].foci.at(0).position - e.centre;
            CHECK(std::abs(std::pow(p.x / 6e-3, 2) + std::pow(p.y / 4e-3, 2) - 1.0) < 1e-9);
            return std::atan2(p.y / 4e-3, p.x / 6e-3);
        };
        const double from = parameter(j);
        double to = parameter(j + 1);
        if (to < from) to += 2.0 * pi;
        double length = 0.0;
        for (int k = 0; k < 1000; ++k)
            length += distance(e.at(from + (to - from) * k / 1000.0), e.at(from + (to - from) * (k + 1) / 1000.0));
        shortest = std::min(shortest, length);
        longest = std::max(longest, length);
    }
    CHECK(1e3 * shortest == Approx(3.1731).margin(1e-3));
    CHECK(longest - shortest < 1e-7);
}

TEST_CASE("ring: several fingers share each step, and the still focus is a modulated one") {
    Ellipse a = lying(6e-3, 4e-3), b = lying(5e-3, 5e-3);
    a.centre = {-0.015, 0, 0.15};
    b.centre = {0.015, 0, 0.15};
    const std::vector<Ellipse> both{a, b};
    const std::vector<std::optional<Vec3>> nowhere(2);
    for (const PathStep& step : ring_path(both, nowhere, 40e3).steps) CHECK(step.foci.size() == 2);
    RingOptions options;
    options.motion = FocusMotion::still;
    const Path still = ring_path(both, nowhere, 40e3, options);
    double sum = 0.0, wave = 0.0;
    for (std::size_t j = 0; j < still.steps.size(); ++j) {
        if (still.steps[j].foci.empty()) continue;
        CHECK(still.steps[j].foci.at(0).position == a.centre);
        CHECK(still.steps[j].foci.at(1).position == b.centre);
        sum += still.steps[j].foci.at(0).amplitude;
        wave += still.steps[j].foci.at(0).amplitude * std::cos(2.0 * pi * 200.0 * static_cast<double>(j) * 1e-3);
    }
    CHECK(sum == Approx(5.0));
    CHECK(wave == Approx(-2.5));
    options.still_am_hz = 250.0;
    CHECK_REFUSED(ring_path(both, nowhere, 40e3, options));
    options = {};
    options.turns_hz = 1000.0;
    options.points = 100;
    CHECK_REFUSED(ring_path(both, nowhere, 40e3, options));
}

TEST_CASE("ring: pressing foci turn slowly around each finger, as algorithm L's, and a pass can be repeated") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int round = 0; round < 20; ++round) {
        RingOptions options;
        options.motion = FocusMotion::pressing;
        options.press.foci = 1 + static_cast<unsigned>(round % 5);
        options.points = options.press.foci == 1 ? 24 : 10;
        Ellipse section;
        section.centre = {20e-3 * unit(random), 20e-3 * unit(random), 0.2};
        section.half_major = 8e-3;
        section.half_minor = 6.5e-3;
        const std::vector<Ellipse> sections{section, section};
        const Vec3 start = section.centre + 3e-3 * Vec3{0.6, -0.8, 0};
        const std::vector<std::optional<Vec3>> starts{start, {}};
        const Path path = ring_path(sections, starts, 40e3, options);
        const std::size_t foci = options.press.foci;
        REQUIRE(path.steps.size() == options.points);
        double periods = 0.0;
        for (std::size_t j = 0; j < path.steps.size(); ++j) {
            const auto& step = path.steps[j].foci;
            periods += path.steps[j].periods;
            REQUIRE(step.size() == 2 * foci);
            const auto& next = path.steps[(j + 1) % options.points].foci;
            for (std::size_t k = 0; k < step.size(); ++k) {
                CHECK(distance(step[k].position, section.centre) == Approx(3e-3));
                CHECK(step[k].position.z == Approx(0.2));
                // The next step, and the first one after the last, has a focus less than a millimetre on.
                double least = 1.0;
                for (const Focus& f : next) least = std::min(least, distance(f.position, step[k].position));
                CHECK(least < longest_press_step_m);
                CHECK(least > 0.1e-3);
            }
        }
        CHECK(distance(path.steps[0].foci[0].position, start) < 1e-9);
        CHECK(periods * 25e-6 * static_cast<double>(foci) == Approx(1.0 / 5.0).epsilon(0.01));
    }
    RingOptions coarse;
    coarse.motion = FocusMotion::pressing;
    coarse.press.radius_m = 8e-3;
    CHECK_REFUSED(require_sound(coarse));
}

TEST_CASE("ring: a wave in steps has so much of its fundamental left") {
    RingOptions options;
    options.motion = FocusMotion::still;
    for (const auto& [hz, points] : {std::pair(200.0, 10), {100.0, 10}, {300.0, 20}, {400.0, 10}}) {
        options.still_am_hz = hz;
        options.points = static_cast<std::size_t>(points);
        const double waves = hz / options.turns_hz;
        double held[2] = {0, 0}, smooth[2] = {0, 0};  // the fundamental of the amplitude's square, over a turn
        constexpr int fine = 20000;
        for (int i = 0; i < fine; ++i) {
            const double turn = (i + 0.5) / fine, step = std::floor(turn * points) / points;
            const double phase = 2 * pi * waves * turn;
            const double a = 0.5 - 0.5 * std::cos(2 * pi * waves * step), b = 0.5 - 0.5 * std::cos(phase);
            held[0] += a * a * std::cos(phase);
            held[1] += a * a * std::sin(phase);
            smooth[0] += b * b * std::cos(phase);
            smooth[1] += b * b * std::sin(phase);
        }
        // From five steps a wave on, no other part of the wave falls onto its fundamental.
        if (points / waves < 4.5) continue;
        CHECK(std::hypot(held[0], held[1]) / std::hypot(smooth[0], smooth[1]) ==
              Approx(held_fundamental(options)).epsilon(1e-3));
    }
}
