// SPDX-License-Identifier: Apache-2.0
// Roots, once for each instruction set: for files that Highway compiles by foreach_target.h.
#if defined(HAPTOGRAM_ROOT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTOGRAM_ROOT_INL
#undef HAPTOGRAM_ROOT_INL
#else
#define HAPTOGRAM_ROOT_INL
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

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
