// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set by Highway, chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/solve/focal_law.cpp"
#include "haptogram/solve/focal_law.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// @param x, y, z        element coordinates in metres, the last one repeated up to a whole vector
/// @param ticks_per_m    timer ticks in which sound goes one metre
void ticks_of_foci(const float* x, const float* y, const float* z, std::size_t elements, float ticks_per_m, float cycle,
                   const Vec3* foci, std::size_t count, float* scratch, std::uint16_t* ticks) {
    const hn::ScalableTag<float> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::uint16_t, decltype(d)> du16;
    const std::size_t lanes = hn::Lanes(d);
    const auto cycle_v = hn::Set(d, cycle);
    const auto per_cycle = hn::Set(d, 1.0F / cycle);
    const auto scale = hn::Set(d, ticks_per_m);
    for (std::size_t f = 0; f < count; ++f) {
        const auto fx = hn::Set(d, static_cast<float>(foci[f].x));
        const auto fy = hn::Set(d, static_cast<float>(foci[f].y));
        const auto fz = hn::Set(d, static_cast<float>(foci[f].z));
        auto farthest = hn::Zero(d);
        for (std::size_t m = 0; m < elements; m += lanes) {
            const auto dx = hn::Sub(fx, hn::Load(d, x + m));
            const auto dy = hn::Sub(fy, hn::Load(d, y + m));
            const auto dz = hn::Sub(fz, hn::Load(d, z + m));
            // Multiply and add apart, never fused: the result must not depend on the processor.
            const auto range = hn::Sqrt(hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz)));
            hn::Store(range, d, scratch + m);
            farthest = hn::Max(farthest, range);
        }
        farthest = hn::MaxOfLanes(d, farthest);
        std::uint16_t* row = ticks + f * elements;
        for (std::size_t m = 0; m < elements; m += lanes) {
            const auto delay = hn::Mul(hn::Sub(farthest, hn::Load(d, scratch + m)), scale);
            const auto whole = hn::Floor(hn::Mul(delay, per_cycle));
            const auto rest = hn::Round(hn::Sub(delay, hn::Mul(whole, cycle_v)));
            // `whole` may be one too small or too large when the delay is a hair from a multiple of the cycle.
            const auto wrapped =
                hn::IfThenElse(hn::Ge(rest, cycle_v), hn::Sub(rest, cycle_v),
                               hn::IfThenElse(hn::Lt(rest, hn::Zero(d)), hn::Add(rest, cycle_v), rest));
            const auto tick = hn::DemoteTo(du16, hn::ConvertTo(di, wrapped));
            if (m + lanes <= elements) {
                hn::StoreU(tick, du16, row + m);
            } else {
                HWY_ALIGN std::uint16_t last[HWY_MAX_BYTES / 2];
                hn::Store(tick, du16, last);
                for (std::size_t i = 0; m + i < elements; ++i) row[m + i] = last[i];
            }
        }
    }
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <hwy/aligned_allocator.h>

#include "haptogram/base/error.hpp"

namespace haptogram {

HWY_EXPORT(ticks_of_foci);
HWY_EXPORT(target_name);

std::vector<std::uint16_t> focal_law(const Array& array, const Timer& timer, std::span<const Vec3> foci) {
    for (const Vec3& focus : foci)
        if (!is_finite(focus))
            throw bad_input("focal law", "a focal point is not finite; every coordinate must be a number");
    const std::size_t elements = array.elements.size();
    std::vector<std::uint16_t> ticks(foci.size() * elements);
    if (ticks.empty()) return ticks;
    // The most of all instruction sets that may be chosen; HWY_MAX_BYTES knows only the one that this is compiled for.
    constexpr std::size_t most_lanes = 64;
    const std::size_t padded = (elements + most_lanes - 1) / most_lanes * most_lanes;
    const auto buffer = hwy::AllocateAligned<float>(4 * padded);
    float* x = buffer.get();
    float* y = x + padded;
    float* z = y + padded;
    float* scratch = z + padded;
    for (std::size_t m = 0; m < padded; ++m) {
        const Vec3& element = array.elements[m < elements ? m : elements - 1].position;
        x[m] = static_cast<float>(element.x);
        y[m] = static_cast<float>(element.y);
        z[m] = static_cast<float>(element.z);
    }
    const auto ticks_per_m = static_cast<float>(1.0 / (array.medium.speed_m_s * timer.tick_s()));
    HWY_DYNAMIC_DISPATCH(ticks_of_foci)
    (x, y, z, elements, ticks_per_m, static_cast<float>(timer.cycle_ticks), foci.data(), foci.size(), scratch,
     ticks.data());
    return ticks;
}

const char* focal_law_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace haptogram
#endif
