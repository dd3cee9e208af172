// SPDX-License-Identifier: Apache-2.0
// The focal law in two steps. Single precision with vector instructions gives each delay with an error of at most δ,
// for which there is a bound. Where the delay is farther than δ from the middle between two ticks, rounding it gives
// the same tick as double precision does; the few others are computed again in double precision, with the formula of
// focal_law.hpp.
//
// Single precision counts in units of its own. In a short cycle they are 2⁻¹⁶ of it: the lowest 16 bits of a whole
// number of them are the place in the cycle, without a division. In a long one, or for arrays of more than half a
// metre, they are ticks.
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
#include <limits>
#include <type_traits>

#include "haptogram/acoustics/root-inl.hpp"

#ifndef HAPTOGRAM_SOLVE_FOCAL_LAW_ONCE
#define HAPTOGRAM_SOLVE_FOCAL_LAW_ONCE
namespace haptogram {

/// An array as the law needs it. Lengths are metres, or units: the time in which sound goes that far.
struct FocalLaw {
    std::size_t elements = 0, padded = 0;  ///< padded to whole vectors of any processor by repeating the last element
    const double *x = nullptr, *y = nullptr, *z = nullptr;  ///< metres
    const float *near_x = nullptr, *near_y = nullptr, *near_z = nullptr,
                *half_square = nullptr;        ///< from the centre, units; half of the distance's square
    std::span<const std::uint32_t> outermost;  ///< one of these is the farthest element from any point
    Vec3 centre, low, high;                    ///< of the box around the elements, metres
    Vec3 half;                                 ///< half of the box, units
    double radius = 0.0;                       ///< greatest distance of an element from the centre, units
    double ticks_per_m = 0.0;
    std::uint32_t cycle = 0;
    bool flat = false;       ///< all elements have the centre's z
    bool fractions = false;  ///< a unit is 2⁻¹⁶ of a cycle, and not a tick
    double units_per_tick = 1.0;
};

inline constexpr std::size_t block_of_foci = 64;
inline constexpr double units_per_cycle = 65'536.0;         ///< of a law in fractions
inline constexpr std::uint32_t longest_in_fractions = 512;  ///< ticks a cycle; beyond it too many delays were unsure

/// Square of a distance. Products and sums are never fused: the result must not depend on the processor.
inline double square_of(double x, double y, double z) { return (x * x + y * y) + z * z; }

/// The tick of one element: the whole number nearest to (farthest − range)·ticks_per_m, modulo the cycle. Halves are
/// rounded up.
inline std::uint16_t tick_of(double farthest, double range, double ticks_per_m, std::uint32_t cycle) {
    const double delay = (farthest - range) * ticks_per_m;
    const double whole = std::floor(delay);
    // Added, not chosen: which way it goes cannot be guessed, and a wrong guess costs more than all the rest.
    const std::uint32_t up = delay - whole >= 0.5 ? 1 : 0;
    return static_cast<std::uint16_t>((static_cast<std::uint32_t>(whole) + up) % cycle);
}

}  // namespace haptogram
#endif

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

// The relative error of near_inverse_root().
#if HWY_TARGET <= HWY_AVX3
constexpr double root_error = 0x1p-14;  ///< what the instruction set promises
HWY_INLINE V near_inverse_root(V x) { return hn::ApproximateReciprocalSqrt(x); }
#else
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR
constexpr double root_error = 0x1p-20;  ///< 3/2 of the square of the 1.5·2⁻¹² that are promised, and rounding
#else
constexpr double root_error = 0x1p-22;  ///< two roundings
#endif
HWY_INLINE V near_inverse_root(V x) { return inverse_root(x); }
#endif

/// What the elements' delays for one focus have in common, for a block of foci. With r₀ = farthest − a whole number of
/// cycles, near the focus' distance from the centre, delay = r₀ − r modulo the cycle. Units, unless said; in fractions
/// half a tick is added to the delay and to r₀, so that the tick is what is below it.
struct alignas(64) Block {
    double x[block_of_foci], y[block_of_foci], z[block_of_foci];                   ///< the foci, metres
    double farthest[block_of_foci];                                                ///< metres
    float minus_x[block_of_foci], minus_y[block_of_foci], minus_z[block_of_foci];  ///< −focus, from the centre
    float half_rest[block_of_foci];                                                ///< (|focus|² − r₀²)/2
    float r0[block_of_foci], r0_square[block_of_foci];
    float error[block_of_foci];  ///< δ; infinite where single precision will not do
};

using DD = hn::ScalableTag<double>;
using VD = hn::Vec<DD>;
using DF = hn::Rebind<float, DD>;  ///< as many floats as doubles
using VF = hn::Vec<DF>;

HWY_INLINE VD constant(double value) { return hn::Set(DD(), value); }
HWY_INLINE VF about(double value) { return hn::Set(DF(), static_cast<float>(value)); }
HWY_INLINE VF about(VD value) { return hn::DemoteTo(DF(), value); }
HWY_INLINE VD squares(VD x, VD y, VD z) { return (x * x + y * y) + z * z; }

/// Bound of the error of a delay that Delays computes, in units. With u = 2⁻²⁴, the unit of rounding, w = r − r₀
/// and W ≥ |w|:
/// - q = r² − r₀² is the sum of |F|² − r₀², |E|² and the two or three products of −2F·E, of inputs rounded to float,
///   with a rounding for each product and each sum. Its error is at most 5u or 6u times the sum of their sizes. Halves
///   of all of them are taken, which changes no rounding.
/// - The residual q − 2r₀w − w² = q − 2w(r₀ + w/2) adds at most 4u·r₀W + u·W²: r₀ is rounded, and so is its sum.
/// - The first value of w is wrong by e ≤ r·(root_error + 4u) + (error of q + 2u·r₀²)/2r. Newton's step leaves at most
///   3/2·e²/r of it, divides the residual's error by 2r, and is rounded: u·W + 2u·e.
/// - 1e-6 of a tick covers the roundings in double precision, of r₀ and of the law itself, for ranges of up to 10⁸
///   ticks.
/// @param sizes  ||F|² − r₀²| + max |E|² + 2·Σ |F|·max |E| over the coordinates
HWY_INLINE VF error_bound(const FocalLaw& law, VF sizes, VF r0, VF nearest, VF farthest) {
    constexpr double u = 0x1p-24;
    const VF w = hn::Max(farthest - r0, r0 - nearest) + about(4.0 * u) * farthest;  // those are rounded, too
    const VF q = about((law.flat ? 5.0 : 6.0) * u) * sizes;
    const VF per_range = about(1.0) / nearest;
    const VF e = farthest * about(root_error + 4.0 * u) + (q + about(2.0 * u) * r0 * r0) * about(0.5) * per_range;
    const VF residual = q + about(4.0 * u) * r0 * w + about(u) * w * w;
    const VF sum = (about(0.5) * residual + about(1.5) * e * e) * per_range + about(u) * w + about(2.0 * u) * e;
    // 2 % more, for what is left out above and for the roundings of this bound itself.
    return about(1.02) * sum + about(1e-6 * law.units_per_tick);
}

/// How far a coordinate is outside of [low, high].
HWY_INLINE VD outside(VD at, double low, double high) {
    return hn::Max(hn::Max(constant(low) - at, at - constant(high)), constant(0.0));
}

/// @param count  at most block_of_foci; the last focus is repeated up to there
HWY_INLINE void prepare(const FocalLaw& law, const Vec3* foci, std::size_t count, Block& block) {
    const DD d;
    const DF df;
    Vec3 repeated[block_of_foci];
    if (count < block_of_foci) {
        for (std::size_t i = 0; i < block_of_foci; ++i) repeated[i] = foci[std::min(i, count - 1)];
        foci = repeated;
    }
    const double cycle = law.cycle * law.units_per_tick;
    const VD k = constant(law.ticks_per_m * law.units_per_tick);
    const VD early = constant(law.fractions ? 0.5 * law.units_per_tick : 0.0);
    const VD to_whole = constant(0x1.8p52);  // adding and subtracting it rounds to a whole number
    const bool fits = law.cycle >= 2 && law.radius + 2.0 * cycle < (law.fractions ? 0x1p22 : 32'000.0);
    const VF largest_error = about(fits ? 0.25 * law.units_per_tick : -1.0);
    for (std::size_t i = 0; i < block_of_foci; i += hn::Lanes(d)) {
        VD x, y, z;
        hn::LoadInterleaved3(d, &foci[i].x, x, y, z);
        hn::Store(x, d, block.x + i);
        hn::Store(y, d, block.y + i);
        hn::Store(z, d, block.z + i);
        VD most = constant(0.0);
        for (const std::uint32_t e : law.outermost)
            most = hn::Max(most, squares(x - constant(law.x[e]), y - constant(law.y[e]), z - constant(law.z[e])));
        most = hn::Sqrt(most);
        hn::Store(most, d, block.farthest + i);
        const VD beside = squares(outside(x, law.low.x, law.high.x), outside(y, law.low.y, law.high.y),
                                  outside(z, law.low.z, law.high.z));
        const VF nearest = hn::Sqrt(about(beside * k * k));
        x = (x - constant(law.centre.x)) * k;
        y = (y - constant(law.centre.y)) * k;
        z = (z - constant(law.centre.z)) * k;
        const VD square = squares(x, y, z), farthest = most * k;
        const VD from_centre = hn::PromoteTo(d, hn::Sqrt(about(square)));
        const VD cycles = ((farthest - from_centre) * constant(1.0 / cycle) + to_whole) - to_whole;
        const VD r0 = farthest - cycles * constant(cycle) + early, r0_square = r0 * r0, rest = square - r0_square;
        const VF minus_x = hn::Neg(about(x)), minus_y = hn::Neg(about(y)), minus_z = hn::Neg(about(z));
        hn::Store(minus_x, df, block.minus_x + i);
        hn::Store(minus_y, df, block.minus_y + i);
        hn::Store(minus_z, df, block.minus_z + i);
        hn::Store(about(constant(0.5) * rest), df, block.half_rest + i);
        hn::Store(about(r0), df, block.r0 + i);
        hn::Store(about(r0_square), df, block.r0_square + i);
        const VF sizes = hn::Abs(about(rest)) + about(law.radius * law.radius) +
                         about(2.0) * (hn::Abs(minus_x) * about(law.half.x) + hn::Abs(minus_y) * about(law.half.y) +
                                       hn::Abs(minus_z) * about(law.half.z));
        const VF error = error_bound(law, sizes, about(r0), nearest, about(farthest));
        // Also false for a focus in the box, whose bound is infinite or not a number. Counts of ticks must fit in 16
        // bits, and ranges into the bound's roundings in double precision.
        const auto good =
            hn::And(hn::Lt(error, largest_error), hn::Lt(about(farthest), about(1e8 * law.units_per_tick)));
        hn::Store(hn::IfThenElse(good, error, about(std::numeric_limits<double>::infinity())), df, block.error + i);
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

/// Bytes of bits that say which elements of a pair of vectors are unsure, and how many elements a byte is for.
template <bool fractions>
struct UnsureBits {
    static constexpr std::size_t lanes = hn::MaxLanes(D()), per_byte = fractions ? 8 : std::min<std::size_t>(lanes, 8);
    static constexpr std::size_t bytes_per_pair = 2 * lanes / per_byte;
};

#if HWY_TARGET == HWY_SCALAR  // has no vector of ticks; single precision would gain nothing
constexpr bool has_fast_rows = false;
#else
constexpr bool has_fast_rows = true;

/// r − r₀ for a vector of elements and one focus. Subtracting two ranges would lose digits, so w is made from
/// q = r² − r₀² = w² + 2r₀w by one step of Newton's method from what the approximate root gives.
template <bool flat>
struct Delays {
    V minus_x, minus_y, minus_z, half_rest, r0, r0_square;
    HWY_INLINE Delays(const Block& block, std::size_t i) {
        const D d;
        minus_x = hn::Set(d, block.minus_x[i]);
        minus_y = hn::Set(d, block.minus_y[i]);
        minus_z = hn::Set(d, block.minus_z[i]);
        half_rest = hn::Set(d, block.half_rest[i]);
        r0 = hn::Set(d, block.r0[i]);
        r0_square = hn::Set(d, block.r0_square[i]);
    }
    HWY_INLINE V operator()(const float* x, const float* y, const float* z, const float* half_square) const {
        const D d;
        V half_q = hn::Add(half_rest, hn::Load(d, half_square));
        if constexpr (!flat) half_q = hn::MulAdd(minus_z, hn::Load(d, z), half_q);
        half_q = hn::MulAdd(minus_y, hn::Load(d, y), half_q);
        half_q = hn::MulAdd(minus_x, hn::Load(d, x), half_q);
        const V square = hn::MulAdd(half_q, hn::Set(d, 2.0F), r0_square);
        const V inverse = near_inverse_root(square);
        const V w = hn::MulSub(square, inverse, r0);
        const V half_residual = hn::NegMulAdd(w, hn::MulAdd(w, hn::Set(d, 0.5F), r0), half_q);
        return hn::MulAdd(half_residual, inverse, w);
    }
};

/// The rows of a block by single precision, with `unsure` bits for the elements whose delay is within δ of the middle
/// between two ticks: of each focus, `stride` bytes.
/// @param last  a row's room that may be overrun, for rows at the end of `ticks`
template <bool flat, bool fractions>
HWY_INLINE void fast_rows(const FocalLaw& law, const Block& block, std::size_t count, std::uint16_t* ticks,
                          const std::uint16_t* end, std::uint16_t* last, std::uint8_t* unsure, std::size_t stride) {
    const D d;
    const hn::Repartition<std::uint16_t, D> du;
    using Bits = UnsureBits<fractions>;
    const std::size_t lanes = hn::Lanes(d), step = 2 * lanes;
    const std::uint32_t cycle = law.cycle, ahead = fractions ? 0 : 32'767 / cycle * cycle;
    // Adding 1.5·2²³ rounds to a whole number and leaves it in the lowest bits. A whole number of cycles more makes it
    // positive.
    const V shift = hn::Set(d, 12'582'912.0F + static_cast<float>(ahead));
    const auto cycle_v = hn::Set(du, static_cast<std::uint16_t>(cycle));
    [[maybe_unused]] const auto per_cycle = hn::Set(du, static_cast<std::uint16_t>(65'536 / cycle));
    // Not through `law`, which the compiler believes the stores of ticks could change.
    const std::size_t elements = law.elements, padded = law.padded, before_last = (elements - 1) / step * step;
    const float *const x = law.near_x, *const y = law.near_y, *const z = law.near_z, *const square = law.half_square;
    // Lanes of the last two vectors that are elements; the padding repeats the last one.
    using DM = std::conditional_t<fractions, decltype(du), D>;
    const std::size_t left = elements - before_last;
    const auto in_first = hn::FirstN(DM(), left), in_second = hn::FirstN(DM(), left > lanes ? left - lanes : 0);
    for (std::size_t i = 0; i < count; ++i) {
        const Delays<flat> delays(block, i);
        const float error = block.error[i];
        // Not below 0, so that 0 is safe; a focus without a bound is computed anew as a whole.
        [[maybe_unused]] const V safe = hn::Set(d, std::max(0.5F - error, 0.0F));
        // The middle between two ticks is where the fraction's product with the cycle is a whole number of 2¹⁶. The
        // rounding to whole units and δ, in such products, and 1 for this sum's own rounding:
        const float margin = std::min((0.5F + error) * static_cast<float>(cycle) + 1.0F, 16'383.0F);
        [[maybe_unused]] const auto below = hn::Set(du, static_cast<std::uint16_t>(margin));
        [[maybe_unused]] const auto within = hn::Add(below, below);
        // Stores go beyond the row's end into the next one, which is written later.
        std::uint16_t* row = ticks + i * elements;
        std::uint16_t* const to = static_cast<std::size_t>(end - row) >= padded ? row : last;
        std::uint8_t* bits = unsure + i * stride;
        // `of_elements` leaves out what is of the padding, in what bits are made from.
        const auto two_vectors = [&](std::size_t m, auto both, auto of_elements) HWY_ATTR {
            const V w0 = delays(x + m, y + m, z + m, square + m);
            V w1 = w0;
            if constexpr (both) {
                const std::size_t next = m + lanes;
                w1 = delays(x + next, y + next, z + next, square + next);
            }
            const V n0 = hn::Sub(shift, w0), n1 = hn::Sub(shift, w1);
            // The lower halves are the counts of units.
            const auto whole = hn::ConcatEven(du, hn::BitCast(du, n1), hn::BitCast(du, n0));
            if constexpr (fractions) {
                const auto product = hn::Mul(whole, cycle_v);  // its lowest 16 bits
                hn::StoreMaskBits(du, hn::Lt(hn::Add(product, below), of_elements(within, 0)), bits);
                hn::StoreU(hn::MulHigh(whole, cycle_v), du, to + m);
            } else {
                const V off0 = hn::Add(w0, hn::Sub(n0, shift)), off1 = hn::Add(w1, hn::Sub(n1, shift));
                hn::StoreMaskBits(d, hn::Lt(safe, of_elements(hn::Abs(off0), 0)), bits);
                hn::StoreMaskBits(d, hn::Lt(safe, of_elements(hn::Abs(off1), 1)), bits + Bits::bytes_per_pair / 2);
                // The quotient by the cycle is right or one too small.
                const auto rest = hn::Sub(whole, hn::Mul(hn::MulHigh(whole, per_cycle), cycle_v));
                hn::StoreU(hn::Min(rest, hn::Sub(rest, cycle_v)), du, to + m);
            }
            bits += Bits::bytes_per_pair;
        };
        for (std::size_t m = 0; m < before_last; m += step)
            two_vectors(m, std::true_type(), [](auto value, int) HWY_ATTR { return value; });
        const auto of_elements = [&](auto value, int which)
                                     HWY_ATTR { return hn::IfThenElseZero(which == 0 ? in_first : in_second, value); };
        if (left > lanes)
            two_vectors(before_last, std::true_type(), of_elements);
        else
            two_vectors(before_last, std::false_type(), of_elements);
        if (to == last) std::copy_n(last, elements, row);
    }
}

#endif

/// @param scratch  room for law.padded doubles
/// @param unsure   room for block_of_foci·law.padded/8 words, all 0: bits, as UnsureBits says, of whole words a focus
/// @param unsure_words  room for as many; which words have a bit
template <bool fractions>
HWY_INLINE void ticks_of_foci_in(const FocalLaw& law, const Vec3* foci, std::size_t count, double* scratch,
                                 [[maybe_unused]] std::uint16_t* last, std::uint64_t* unsure,
                                 std::uint64_t* unsure_words, std::uint16_t* ticks) {
    using Bits = UnsureBits<fractions>;
    constexpr std::size_t per_word = 8 * Bits::per_byte;  // elements
    // Whole words of bits a focus.
    const std::size_t words = (law.elements + per_word - 1) / per_word;
    Block block;
    [[maybe_unused]] const std::uint16_t* const end = ticks + count * law.elements;
    for (std::size_t first = 0; first < count; first += block_of_foci) {
        const std::size_t some = std::min(block_of_foci, count - first);
        std::uint16_t* const rows = ticks + first * law.elements;
        prepare(law, foci + first, some, block);
#if HWY_TARGET != HWY_SCALAR
        if (law.flat)
            fast_rows<true, fractions>(law, block, some, rows, end, last, reinterpret_cast<std::uint8_t*>(unsure),
                                       8 * words);
        else
            fast_rows<false, fractions>(law, block, some, rows, end, last, reinterpret_cast<std::uint8_t*>(unsure),
                                        8 * words);
#endif
        // The words that have a bit are listed first. Without a branch: a wrong guess would cost as much as a focus.
        std::size_t listed = 0;
        for (std::size_t w = 0; w < (has_fast_rows ? some * words : 0); ++w) {
            unsure_words[listed] = w;
            listed += unsure[w] != 0 ? 1U : 0U;
        }
        for (std::size_t j = 0; j < listed; ++j) {
            const std::size_t i = unsure_words[j] / words, w = unsure_words[j] % words;
            std::uint64_t bits = unsure[unsure_words[j]];
            do {
                const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
                const std::size_t m = w * per_word + bit / 8 * Bits::per_byte + bit % 8;
                const double range =
                    std::sqrt(square_of(block.x[i] - law.x[m], block.y[i] - law.y[m], block.z[i] - law.z[m]));
                rows[i * law.elements + m] = tick_of(block.farthest[i], range, law.ticks_per_m, law.cycle);
                bits &= bits - 1;
            } while (HWY_UNLIKELY(bits != 0));
        }
        for (std::size_t i = 0; i < some; ++i)
            if (!has_fast_rows || std::isinf(block.error[i]))
                exact_row(law, block, i, scratch, rows + i * law.elements);
    }
}

void ticks_of_foci(const FocalLaw& law, const Vec3* foci, std::size_t count, double* scratch, std::uint16_t* last,
                   std::uint64_t* unsure, std::uint64_t* unsure_words, std::uint16_t* ticks) {
    if (law.fractions)
        ticks_of_foci_in<true>(law, foci, count, scratch, last, unsure, unsure_words, ticks);
    else
        ticks_of_foci_in<false>(law, foci, count, scratch, last, unsure, unsure_words, ticks);
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <fmt/core.h>
#include <hwy/aligned_allocator.h>

#include <numbers>
#include <numeric>

#include "haptogram/base/error.hpp"
#include "haptogram/format/interface.hpp"

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

/// The law for elements that differ: a wave that leads by a phase starts later by as much. All in double precision.
void corrected_law(const Array& array, const Timer& timer, std::span<const Vec3> foci, std::span<std::uint16_t> ticks) {
    const double ticks_per_m = 1.0 / (array.medium.speed_m_s * timer.tick_s());
    std::vector<double> later_m;
    for (const Element& e : array.elements) {
        const double turns = std::arg(e.response) / (2.0 * std::numbers::pi);
        later_m.push_back((turns - std::floor(turns)) * timer.cycle_ticks / ticks_per_m);
    }
    auto tick = ticks.begin();
    for (const Vec3 focus : foci) {
        double farthest = 0.0;
        for (const Element& e : array.elements) farthest = std::max(farthest, distance(e, focus));
        for (std::size_t m = 0; m < array.elements.size(); ++m) {
            const Element& e = array.elements[m];
            *tick++ = e.response == 0.0
                          ? interface::silent_timing
                          : tick_of(farthest + later_m[m], distance(e, focus), ticks_per_m, timer.cycle_ticks);
        }
    }
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
    array.require_one_weight();
    if (std::ranges::any_of(array.elements, [](const Element& e) { return e.response != 1.0; })) {
        corrected_law(array, timer, foci, ticks);
        return;
    }

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
    // Whole numbers of units up to 2²² can be told apart, which is 64 cycles; half of that is the array's.
    law.fractions = law.cycle <= longest_in_fractions && law.ticks_per_m * norm(law.high - law.low) <= 32.0 * law.cycle;
    law.units_per_tick = law.fractions ? units_per_cycle / law.cycle : 1.0;
    const double units_per_m = law.ticks_per_m * law.units_per_tick;
    law.half = 0.5 * units_per_m * (law.high - law.low);
    // Two vectors of any instruction set that may be chosen; HWY_MAX_BYTES knows only the one that this is compiled
    // for.
    constexpr std::size_t most_lanes = 128;
    law.padded = (elements + most_lanes - 1) / most_lanes * most_lanes;
    const auto exact = hwy::AllocateAligned<double>(4 * law.padded);
    const auto near = hwy::AllocateAligned<float>(4 * law.padded);
    double *const x = exact.get(), *const y = x + law.padded, *const z = y + law.padded;
    float *const near_x = near.get(), *const near_y = near_x + law.padded, *const near_z = near_y + law.padded,
                 *const half_square = near_z + law.padded;
    for (std::size_t m = 0; m < law.padded; ++m) {
        const Vec3& p = array.elements[std::min(m, elements - 1)].position;
        const Vec3 units_away = (p - law.centre) * units_per_m;
        x[m] = p.x, y[m] = p.y, z[m] = p.z;
        near_x[m] = static_cast<float>(units_away.x);
        near_y[m] = static_cast<float>(units_away.y);
        near_z[m] = static_cast<float>(units_away.z);
        half_square[m] = static_cast<float>(0.5 * dot(units_away, units_away));
        law.radius = std::max(law.radius, norm(units_away));
    }
    law.x = x, law.y = y, law.z = z;
    law.near_x = near_x, law.near_y = near_y, law.near_z = near_z, law.half_square = half_square;
    const std::vector<std::uint32_t> outermost = outermost_of(array.elements, law.flat);
    law.outermost = outermost;

    std::vector<std::uint16_t> last(law.padded);
    const std::size_t words = block_of_foci * law.padded / 8;
    std::vector<std::uint64_t> unsure(words), unsure_words(words);
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
