// SPDX-License-Identifier: Apache-2.0
// What the loops over waves share, once for each instruction set: for files that Highway compiles by foreach_target.h.
#if defined(HAPTOGRAM_TURN_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTOGRAM_TURN_INL
#undef HAPTOGRAM_TURN_INL
#else
#define HAPTOGRAM_TURN_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

/// 1/√x, with an error of a few units in the last place.
HWY_INLINE V inverse_root(V x) {
    const D d;
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR
    const V guess =
        hn::ApproximateReciprocalSqrt(x);  // at least 12 correct bits; a step of Newton's method doubles them
    const V slack = hn::NegMulAdd(hn::Mul(hn::Mul(hn::Set(d, 0.5F), x), guess), guess, hn::Set(d, 0.5F));
    return hn::MulAdd(guess, slack, guess);
#else
    return hn::Div(hn::Set(d, 1.0F), hn::Sqrt(x));
#endif
}

/// A complex number, amplitude·(cosine − j·sine).
struct Polar {
    V amplitude, cosine, sine;
};

/// amplitude·e^{−jπ·half_turns}. The phase is split into a whole number of half turns and a rest f, |f| ≤ 1/2. Cosine
/// and sine are polynomials in f; an odd number of half turns changes both signs, which is done once, in the amplitude.
HWY_INLINE Polar turn(V amplitude, V half_turns) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    const V shift = hn::Set(d, 12582912.0F);  // 1.5·2²³; adding it rounds to a whole number, whose lowest bit says odd
    const V shifted = hn::Add(half_turns, shift);
    const V f = hn::Sub(half_turns, hn::Sub(shifted, shift));
    const auto odd = hn::ShiftLeft<31>(hn::BitCast(du, shifted));
    const V u = hn::Mul(f, f);
    // Polynomials of least maximum error on |f| ≤ 1/2, which is 1.4e-8 for the sine and 4.7e-8 for the cosine.
    V sine = hn::MulAdd(hn::Set(d, 0.07765941F), u, hn::Set(d, -0.59829216F));
    V cosine = hn::MulAdd(hn::Set(d, 0.2196968F), u, hn::Set(d, -1.33188016F));
    sine = hn::MulAdd(sine, u, hn::Set(d, 2.55007766F));
    cosine = hn::MulAdd(cosine, u, hn::Set(d, 4.05841191F));
    sine = hn::MulAdd(sine, u, hn::Set(d, -5.16771009F));
    cosine = hn::MulAdd(cosine, u, hn::Set(d, -4.93479286F));
    sine = hn::MulAdd(sine, u, hn::Set(d, 3.14159264F));
    cosine = hn::MulAdd(cosine, u, hn::Set(d, 0.99999995F));
    return {hn::BitCast(d, hn::Xor(hn::BitCast(du, amplitude), odd)), cosine, hn::Mul(sine, f)};
}

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
