// SPDX-License-Identifier: Apache-2.0
// The focal law in two steps. Single precision with vector instructions gives each delay with an error of at most δ,
// for which there is a bound. Where the delay is farther than δ from the middle between two ticks, rounding it gives
// the same tick as double precision does; the few others are computed again in double precision, with the formula of
// focal_law.hpp.
//
// Highway compiles this file once for each instruction set, and picks one when the program runs. Instruction sets whose
// vectors have no size at compile time are left out: the code below keeps vectors in structs.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/solve/focal_law.cpp"
#include "haptogram/solve/focal_law.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#ifndef HAPTOGRAM_SOLVE_FOCAL_LAW_ONCE
#define HAPTOGRAM_SOLVE_FOCAL_LAW_ONCE
namespace haptogram {

/// An array as the law needs it. Lengths are metres, or ticks: the time in which sound goes that far.
struct FocalLaw {
    std::size_t elements = 0, padded = 0;  ///< padded to whole vectors of any processor by repeating the last element
    const double *x = nullptr, *y = nullptr, *z = nullptr;  ///< metres
    const float *near_x = nullptr, *near_y = nullptr, *near_z = nullptr,
                *near_square = nullptr;        ///< from the centre, ticks
    std::span<const std::uint32_t> outermost;  ///< one of these is the farthest element from any point
    Vec3 centre, low, high;                    ///< of the box around the elements, metres
    Vec3 half;                                 ///< half of the box, ticks
    double radius = 0.0;                       ///< greatest distance of an element from the centre, ticks
    double ticks_per_m = 0.0;
    std::uint32_t cycle = 0;
    bool flat = false;  ///< all elements have the centre's z
};

inline constexpr std::size_t block_of_foci = 64;

/// Square of a distance. Products and sums are never fused: the result must not depend on the processor.
inline double square_of(double x, double y, double z) { return (x * x + y * y) + z * z; }

/// The tick of one element: the whole number nearest to (farthest − range)·ticks_per_m, modulo the cycle. Halves are
/// rounded up.
inline std::uint16_t tick_of(double farthest, double range, double ticks_per_m, std::uint32_t cycle) {
    const double delay = (farthest - range) * ticks_per_m;
    const double whole = std::floor(delay);
    const double nearest = delay - whole < 0.5 ? whole : whole + 1.0;
    return static_cast<std::uint16_t>(static_cast<std::uint32_t>(nearest) % cycle);
}

}  // namespace haptogram
#endif

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

#if HWY_TARGET <= HWY_AVX3
constexpr double root_error = 0x1p-14;  ///< of inverse_root(), relative: what the instruction set promises
HWY_INLINE V inverse_root(V x) { return hn::ApproximateReciprocalSqrt(x); }
#elif HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR
constexpr double root_error = 0x1p-20;  ///< 3/2 of the square of the 1.5·2⁻¹² that are promised, and rounding
HWY_INLINE V inverse_root(V x) {
    const D d;
    const V guess = hn::ApproximateReciprocalSqrt(x);
    const V slack = hn::NegMulAdd(hn::Mul(hn::Mul(hn::Set(d, 0.5F), x), guess), guess, hn::Set(d, 0.5F));
    return hn::MulAdd(guess, slack, guess);
}
#else
constexpr double root_error = 0x1p-22;  ///< two roundings
HWY_INLINE V inverse_root(V x) { return hn::Div(hn::Set(D(), 1.0F), hn::Sqrt(x)); }
#endif

/// What the elements' delays for one focus have in common, for a block of foci. With r₀ = farthest − a whole number of
/// cycles, near the focus' distance from the centre, delay = r₀ − r modulo the cycle. Ticks, unless said.
struct alignas(64) Block {
    double x[block_of_foci], y[block_of_foci], z[block_of_foci];                      ///< the foci, metres
    double farthest[block_of_foci], from_centre[block_of_foci];                       ///< metres
    float minus_2x[block_of_foci], minus_2y[block_of_foci], minus_2z[block_of_foci];  ///< −2·focus, from the centre
    float rest[block_of_foci];                                                        ///< |focus|² − r₀²
    float r0[block_of_foci], r0_square[block_of_foci];
    float safe[block_of_foci];  ///< 1/2 − δ; 2 where single precision will not do
};

/// Bound of the error of a delay that add_ticks() computes, in ticks. With u = 2⁻²⁴, the unit of rounding, w = r − r₀
/// and W ≥ |w|:
/// - q = r² − r₀² is the sum of |F|² − r₀², |E|² and the two or three products of −2F·E, of inputs rounded to float,
/// with
///   a rounding for each product and each sum. Its error is at most 5u or 6u times the sum of their sizes.
/// - The residual q − 2r₀w − w² adds at most 4u·r₀W + 2u·W².
/// - The first value of w is wrong by e ≤ r·(root_error + 4u) + (error of q + 2u·r₀²)/2r. Newton's step leaves at most
///   3/2·e²/r of it, divides the residual's error by 2r, and is rounded: u·W + 2u·e.
/// - 1e-6 covers the roundings in double precision, of r₀ and of the law itself, for ranges of up to 10⁸ ticks.
/// @param sizes  ||F|² − r₀²| + max |E|² + 2·Σ |F|·max |E| over the coordinates
HWY_INLINE double error_bound(bool flat, double sizes, double r0, double nearest, double farthest) {
    constexpr double u = 0x1p-24;
    const double beyond = farthest - r0, before = r0 - nearest, w = beyond > before ? beyond : before;
    const double q = (flat ? 5.0 : 6.0) * u * sizes;
    const double per_range = 1.0 / nearest;
    const double e = farthest * (root_error + 4.0 * u) + (q + 2.0 * u * r0 * r0) * 0.5 * per_range;
    const double residual = q + 4.0 * u * r0 * w + 2.0 * u * w * w;
    return 1.02 * ((0.5 * residual + 1.5 * e * e) * per_range + u * w + 2.0 * u * e) + 1e-6;
}

/// Plain loops are turned into vectors by the compiler. Only roots are not, because they might have to set errno.
HWY_INLINE void roots(const double* squares, double* values) {
    const hn::ScalableTag<double> d;
    for (std::size_t i = 0; i < block_of_foci; i += hn::Lanes(d))
        hn::Store(hn::Sqrt(hn::Load(d, squares + i)), d, values + i);
}

/// @param count  at most block_of_foci; the last focus is repeated up to there
HWY_INLINE void prepare(const FocalLaw& law, const Vec3* foci, std::size_t count, Block& block) {
    constexpr std::size_t n = block_of_foci;
    const double k = law.ticks_per_m, cycle = law.cycle, per_cycle = 1.0 / cycle;
    alignas(64) double most[n], square[n], nearest_square[n], nearest[n], error[n];
    const bool fits = cycle >= 2.0 && law.radius + 2.0 * cycle < 32'000.0;
    if (count == n) {
        for (std::size_t i = 0; i < n; ++i) block.x[i] = foci[i].x, block.y[i] = foci[i].y, block.z[i] = foci[i].z;
    } else {
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3& focus = foci[std::min(i, count - 1)];
            block.x[i] = focus.x, block.y[i] = focus.y, block.z[i] = focus.z;
        }
    }
    for (double& m : most) m = 0.0;
    for (const std::uint32_t e : law.outermost) {
        const double ex = law.x[e], ey = law.y[e], ez = law.z[e];
        for (std::size_t i = 0; i < n; ++i) {
            const double s = square_of(block.x[i] - ex, block.y[i] - ey, block.z[i] - ez);
            most[i] = s > most[i] ? s : most[i];
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        square[i] = square_of(block.x[i] - law.centre.x, block.y[i] - law.centre.y, block.z[i] - law.centre.z);
        const auto outside = [](double at, double low, double high) {
            const double below = low - at, above = at - high, beyond = below > above ? below : above;
            return beyond > 0.0 ? beyond : 0.0;
        };
        nearest_square[i] =
            square_of(outside(block.x[i], law.low.x, law.high.x), outside(block.y[i], law.low.y, law.high.y),
                      outside(block.z[i], law.low.z, law.high.z));
    }
    roots(most, block.farthest);
    roots(square, block.from_centre);
    roots(nearest_square, nearest);
    constexpr double to_whole = 0x1.8p52;  // adding and subtracting it rounds to a whole number
    for (std::size_t i = 0; i < n; ++i) {
        const double x = (block.x[i] - law.centre.x) * k, y = (block.y[i] - law.centre.y) * k,
                     z = (block.z[i] - law.centre.z) * k;
        const double farthest = block.farthest[i] * k, from_centre = block.from_centre[i] * k;
        const double cycles = ((farthest - from_centre) * per_cycle + to_whole) - to_whole;
        const double r0 = farthest - cycles * cycle, rest = square_of(x, y, z) - r0 * r0;
        block.minus_2x[i] = static_cast<float>(-2.0 * x);
        block.minus_2y[i] = static_cast<float>(-2.0 * y);
        block.minus_2z[i] = static_cast<float>(-2.0 * z);
        block.rest[i] = static_cast<float>(rest);
        block.r0[i] = static_cast<float>(r0);
        block.r0_square[i] = static_cast<float>(r0 * r0);
        const double sizes = std::abs(rest) + law.radius * law.radius +
                             2.0 * (std::abs(x) * law.half.x + std::abs(y) * law.half.y + std::abs(z) * law.half.z);
        error[i] = error_bound(law.flat, sizes, r0, nearest[i] * k, farthest);
    }
    for (std::size_t i = 0; i < n; ++i) {
        // Also false for a focus in the box, whose bound is infinite or not a number. Counts of ticks must fit in 16
        // bits, and ranges into the bound's roundings in double precision.
        const bool good = (error[i] < 0.25) & fits & (block.farthest[i] * k < 1e8);
        block.safe[i] = good ? static_cast<float>(0.5 - error[i]) : 2.0F;
    }
}

/// The ticks of a whole row of elements in double precision.
HWY_INLINE void exact_row(const FocalLaw& law, const Block& block, std::size_t i, double* scratch, std::uint16_t* row) {
    const hn::ScalableTag<double> d;
    for (std::size_t m = 0; m < law.padded; ++m)
        scratch[m] = square_of(block.x[i] - law.x[m], block.y[i] - law.y[m], block.z[i] - law.z[m]);
    for (std::size_t m = 0; m < law.padded; m += hn::Lanes(d))
        hn::Store(hn::Sqrt(hn::Load(d, scratch + m)), d, scratch + m);
    for (std::size_t m = 0; m < law.elements; ++m)
        row[m] = tick_of(block.farthest[i], scratch[m], law.ticks_per_m, law.cycle);
}

#if HWY_TARGET == HWY_SCALAR  // has no vector of ticks; single precision would gain nothing
constexpr bool has_fast_rows = false;
#else
constexpr bool has_fast_rows = true;

/// r₀ − r for a vector of elements and one focus, and how it rounds.
template <bool flat>
struct Delays {
    V minus_2x, minus_2y, minus_2z, rest, r0, r0_square, minus_2r0;
    HWY_INLINE Delays(const Block& block, std::size_t i) {
        const D d;
        minus_2x = hn::Set(d, block.minus_2x[i]);
        minus_2y = hn::Set(d, block.minus_2y[i]);
        minus_2z = hn::Set(d, block.minus_2z[i]);
        rest = hn::Set(d, block.rest[i]);
        r0 = hn::Set(d, block.r0[i]);
        r0_square = hn::Set(d, block.r0_square[i]);
        minus_2r0 = hn::Set(d, -2.0F * block.r0[i]);
    }
    /// w = r − r₀. Subtracting two ranges would lose digits, so w is made from q = r² − r₀² = w² + 2r₀w by one step of
    /// Newton's method from what the approximate root gives.
    HWY_INLINE V operator()(const float* x, const float* y, const float* z, const float* square_from_centre) const {
        const D d;
        V q = hn::Add(rest, hn::Load(d, square_from_centre));
        if constexpr (!flat) q = hn::MulAdd(minus_2z, hn::Load(d, z), q);
        q = hn::MulAdd(minus_2y, hn::Load(d, y), q);
        q = hn::MulAdd(minus_2x, hn::Load(d, x), q);
        const V square = hn::Add(q, r0_square);
        const V inverse = inverse_root(square);
        const V w = hn::MulSub(square, inverse, r0);
        const V residual = hn::NegMulAdd(w, w, hn::MulAdd(minus_2r0, w, q));
        return hn::MulAdd(residual, hn::Mul(inverse, hn::Set(d, 0.5F)), w);
    }
};

/// The rows of a block by single precision, with `unsure` bits for the elements whose delay is within δ of the middle
/// between two ticks: of each focus, `stride` bytes.
/// @param last  a row's room that may be overrun, for rows at the end of `ticks`
template <bool flat>
HWY_INLINE void fast_rows(const FocalLaw& law, const Block& block, std::size_t count, std::uint16_t* ticks,
                          const std::uint16_t* end, std::uint16_t* last, std::uint8_t* unsure, std::size_t stride) {
    const D d;
    const hn::Repartition<std::uint16_t, D> du;
    const std::size_t lanes = hn::Lanes(d), bytes = (lanes + 7) / 8, step = 2 * lanes;
    const std::uint32_t cycle = law.cycle, ahead = 32'767 / cycle * cycle;
    // Adding 1.5·2²³ rounds to a whole number and leaves it in the lowest bits. A whole number of cycles more makes it
    // positive.
    const V shift = hn::Set(d, 12'582'912.0F + static_cast<float>(ahead));
    const auto cycle_v = hn::Set(du, static_cast<std::uint16_t>(cycle));
    const auto per_cycle = hn::Set(du, static_cast<std::uint16_t>(65'536 / cycle));
    // Not through `law`, which the compiler believes the stores of ticks could change.
    const std::size_t elements = law.elements, padded = law.padded;
    const float *const x = law.near_x, *const y = law.near_y, *const z = law.near_z, *const square = law.near_square;
    for (std::size_t i = 0; i < count; ++i) {
        const Delays<flat> delays(block, i);
        const V safe = hn::Set(d, block.safe[i]);
        // Stores go beyond the row's end into the next one, which is written later.
        std::uint16_t* row = ticks + i * elements;
        std::uint16_t* const to = static_cast<std::size_t>(end - row) >= padded ? row : last;
        for (std::size_t m = 0; m < elements; m += step) {
            const V w0 = delays(x + m, y + m, z + m, square + m);
            V w1 = w0;  // of an odd number of vectors, the last one is twice the same
            if (m + lanes < elements) {
                const std::size_t next = m + lanes;
                w1 = delays(x + next, y + next, z + next, square + next);
            }
            const V n0 = hn::Sub(shift, w0), n1 = hn::Sub(shift, w1);
            const V off0 = hn::Add(w0, hn::Sub(n0, shift)), off1 = hn::Add(w1, hn::Sub(n1, shift));
            std::uint8_t* bits = unsure + i * stride + m / lanes * bytes;
            hn::StoreMaskBits(d, hn::Gt(hn::Abs(off0), safe), bits);
            hn::StoreMaskBits(d, hn::Gt(hn::Abs(off1), safe), bits + bytes);
            // The lower halves are the counts of ticks. The quotient by the cycle is right or one too small.
            const auto whole = hn::ConcatEven(du, hn::BitCast(du, n1), hn::BitCast(du, n0));
            const auto rest = hn::Sub(whole, hn::Mul(hn::MulHigh(whole, per_cycle), cycle_v));
            hn::StoreU(hn::Min(rest, hn::Sub(rest, cycle_v)), du, to + m);
        }
        if (to == last) std::copy_n(last, elements, row);
    }
}

#endif

/// @param scratch  room for law.padded doubles
/// @param unsure   room for block_of_foci·law.padded bytes, all 0
/// @param unsure_words  room for as many
void ticks_of_foci(const FocalLaw& law, const Vec3* foci, std::size_t count, double* scratch,
                   [[maybe_unused]] std::uint16_t* last, std::uint8_t* unsure, std::uint32_t* unsure_words,
                   std::uint16_t* ticks) {
    const std::size_t lanes = hn::Lanes(D()), per_byte = std::min<std::size_t>(lanes, 8);
    // Whole words of bits a focus.
    const std::size_t words = (law.padded / per_byte + 7) / 8;
    Block block;
    [[maybe_unused]] const std::uint16_t* const end = ticks + count * law.elements;
    for (std::size_t first = 0; first < count; first += block_of_foci) {
        const std::size_t some = std::min(block_of_foci, count - first);
        std::uint16_t* const rows = ticks + first * law.elements;
        prepare(law, foci + first, some, block);
#if HWY_TARGET != HWY_SCALAR
        if (law.flat)
            fast_rows<true>(law, block, some, rows, end, last, unsure, 8 * words);
        else
            fast_rows<false>(law, block, some, rows, end, last, unsure, 8 * words);
#endif
        // The words that have a bit are listed first. Without a branch: a wrong guess would cost as much as a focus.
        std::size_t listed = 0;
        for (std::size_t w = 0; w < (has_fast_rows ? some * words : 0); ++w) {
            unsure_words[listed] = static_cast<std::uint32_t>(w);
            std::uint64_t bits = 0;
            std::memcpy(&bits, unsure + 8 * w, sizeof bits);
            listed += bits != 0 ? 1U : 0U;
        }
        for (std::size_t j = 0; j < listed; ++j) {
            const std::size_t i = unsure_words[j] / words, first_byte = unsure_words[j] % words * 8;
            std::uint64_t bits = 0;
            std::memcpy(&bits, unsure + 8 * std::size_t{unsure_words[j]}, sizeof bits);
            do {
                const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
                // The padding may be unsure, too; it repeats the last element.
                const std::size_t m = std::min((first_byte + bit / 8) * per_byte + bit % 8, law.elements - 1);
                const double range =
                    std::sqrt(square_of(block.x[i] - law.x[m], block.y[i] - law.y[m], block.z[i] - law.z[m]));
                rows[i * law.elements + m] = tick_of(block.farthest[i], range, law.ticks_per_m, law.cycle);
                bits &= bits - 1;
            } while (HWY_UNLIKELY(bits != 0));
        }
        for (std::size_t i = 0; i < some; ++i)
            if (!has_fast_rows || block.safe[i] > 1.0F) exact_row(law, block, i, scratch, rows + i * law.elements);
    }
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <fmt/core.h>
#include <hwy/aligned_allocator.h>

#include <numeric>

#include "haptogram/base/error.hpp"

namespace haptogram {

HWY_EXPORT(ticks_of_foci);
HWY_EXPORT(target_name);

namespace {

constexpr double farthest_m = 1000.0;  ///< of a focus' or an element's coordinates from 0

void require_near(Vec3 point, const char* what, std::size_t i) {
    const auto near = [](double coordinate) { return std::abs(coordinate) <= farthest_m; };  // false also for NaN
    if (near(point.x) && near(point.y) && near(point.z)) return;
    throw bad_input("focal law", fmt::format("{} {} is at {}, {}, {} m; expected coordinates from -{:g} to {:g} m",
                                             what, i + 1, point.x, point.y, point.z, farthest_m, farthest_m));
}

/// Elements of which one is the farthest from any point: of a flat array the corners of its convex hull, and otherwise
/// all. A convex combination P of corners Cᵢ is nearer than the farthest of them by Σ λᵢ|P − Cᵢ|² in the square, which
/// is far more than rounding, unless P is very near a corner; then it stays.
std::vector<std::uint32_t> outermost_of(const std::vector<Element>& elements, bool flat) {
    std::vector<std::uint32_t> all(elements.size());
    std::iota(all.begin(), all.end(), 0U);
    if (!flat) return all;
    const auto at = [&](std::uint32_t i) { return elements[i].position; };
    std::vector<std::uint32_t> sorted = all, hull;
    std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
        return at(a).x != at(b).x ? at(a).x < at(b).x : at(a).y < at(b).y;
    });
    // The lower chain from left to right, then the upper one back (Andrew 1979).
    for (int chain = 0; chain < 2; ++chain) {
        const std::size_t begin = hull.size();
        for (const std::uint32_t i : sorted) {
            while (hull.size() >= begin + 2 &&
                   cross(at(hull.back()) - at(hull[hull.size() - 2]), at(i) - at(hull.back())).z <= 0.0)
                hull.pop_back();
            hull.push_back(i);
        }
        std::reverse(sorted.begin(), sorted.end());
    }
    constexpr double very_near_m = 1e-4;
    std::vector<std::uint32_t> outermost;
    for (const std::uint32_t i : all)
        if (std::any_of(hull.begin(), hull.end(),
                        [&](std::uint32_t h) { return distance(at(h), at(i)) < very_near_m; }))
            outermost.push_back(i);
    return outermost;
}

}  // namespace

void focal_law(const Array& array, const Timer& timer, std::span<const Vec3> foci, std::span<std::uint16_t> ticks) {
    const std::size_t elements = array.elements.size();
    for (std::size_t f = 0; f < foci.size(); ++f) require_near(foci[f], "focal point", f);
    for (std::size_t m = 0; m < elements; ++m) require_near(array.elements[m].position, "element", m);
    if (ticks.size() != foci.size() * elements)
        throw bad_argument("ticks", fmt::format("room for {}, expected {}: one for each of {} elements and {} foci",
                                                ticks.size(), foci.size() * elements, elements, foci.size()));
    if (ticks.empty()) return;

    FocalLaw law;
    law.elements = elements;
    law.ticks_per_m = 1.0 / (array.medium.speed_m_s * timer.tick_s());
    law.cycle = timer.cycle_ticks;
    law.low = law.high = array.elements.front().position;
    for (const Element& element : array.elements) {
        const Vec3& p = element.position;
        law.low = {std::min(law.low.x, p.x), std::min(law.low.y, p.y), std::min(law.low.z, p.z)};
        law.high = {std::max(law.high.x, p.x), std::max(law.high.y, p.y), std::max(law.high.z, p.z)};
    }
    law.flat = law.low.z == law.high.z;
    law.centre = 0.5 * (law.low + law.high);
    if (law.flat) law.centre.z = law.low.z;
    law.half = 0.5 * law.ticks_per_m * (law.high - law.low);
    // Two vectors of any instruction set that may be chosen; HWY_MAX_BYTES knows only the one that this is compiled
    // for.
    constexpr std::size_t most_lanes = 128;
    law.padded = (elements + most_lanes - 1) / most_lanes * most_lanes;
    const auto exact = hwy::AllocateAligned<double>(4 * law.padded);
    const auto near = hwy::AllocateAligned<float>(4 * law.padded);
    double *const x = exact.get(), *const y = x + law.padded, *const z = y + law.padded;
    float *const near_x = near.get(), *const near_y = near_x + law.padded, *const near_z = near_y + law.padded,
                 *const near_square = near_z + law.padded;
    for (std::size_t m = 0; m < law.padded; ++m) {
        const Vec3& p = array.elements[std::min(m, elements - 1)].position;
        const Vec3 ticks_away = (p - law.centre) * law.ticks_per_m;
        x[m] = p.x, y[m] = p.y, z[m] = p.z;
        near_x[m] = static_cast<float>(ticks_away.x);
        near_y[m] = static_cast<float>(ticks_away.y);
        near_z[m] = static_cast<float>(ticks_away.z);
        near_square[m] = static_cast<float>(dot(ticks_away, ticks_away));
        law.radius = std::max(law.radius, norm(ticks_away));
    }
    law.x = x, law.y = y, law.z = z;
    law.near_x = near_x, law.near_y = near_y, law.near_z = near_z, law.near_square = near_square;
    const std::vector<std::uint32_t> outermost = outermost_of(array.elements, law.flat);
    law.outermost = outermost;

    std::vector<std::uint16_t> last(law.padded);
    std::vector<std::uint8_t> unsure(block_of_foci * law.padded);
    std::vector<std::uint32_t> unsure_words(block_of_foci * law.padded);
    HWY_DYNAMIC_DISPATCH(ticks_of_foci)
    (law, foci.data(), foci.size(), z + law.padded, last.data(), unsure.data(), unsure_words.data(), ticks.data());
}

std::vector<std::uint16_t> focal_law(const Array& array, const Timer& timer, std::span<const Vec3> foci) {
    std::vector<std::uint16_t> ticks(foci.size() * array.elements.size());
    focal_law(array, timer, foci, ticks);
    return ticks;
}

const char* focal_law_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace haptogram
#endif
