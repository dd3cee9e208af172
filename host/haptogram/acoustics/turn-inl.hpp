// SPDX-License-Identifier: Apache-2.0
// What the loops over waves share, once for each instruction set: for files that Highway compiles by foreach_target.h.
#if defined(HAPTOGRAM_TURN_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTOGRAM_TURN_INL
#undef HAPTOGRAM_TURN_INL
#else
#define HAPTOGRAM_TURN_INL
#endif

#include <hwy/highway.h>

#include "haptogram/acoustics/root-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Several vectors that are computed in step, so that none has to wait for its own last result. Functions below take
/// them as they take one vector; what is the same for all of them stays one.
template <std::size_t count>
struct InStep {
    V v[count];
};

HWY_INLINE V mul(V a, V b) { return hn::Mul(a, b); }
HWY_INLINE V add(V a, V b) { return hn::Add(a, b); }
HWY_INLINE V sub(V a, V b) { return hn::Sub(a, b); }
HWY_INLINE V mul_add(V a, V b, V c) { return hn::MulAdd(a, b, c); }         ///< a·b + c
HWY_INLINE V mul_sub(V a, V b, V c) { return hn::MulSub(a, b, c); }         ///< a·b − c
HWY_INLINE V neg_mul_add(V a, V b, V c) { return hn::NegMulAdd(a, b, c); }  ///< c − a·b

/// One of several vectors. A single vector stands for all of them.
HWY_INLINE V& one_of(V& v, std::size_t) { return v; }
HWY_INLINE const V& one_of(const V& v, std::size_t) { return v; }
template <std::size_t n>
HWY_INLINE V& one_of(InStep<n>& several, std::size_t i) {
    return several.v[i];
}
template <std::size_t n>
HWY_INLINE const V& one_of(const InStep<n>& several, std::size_t i) {
    return several.v[i];
}

/// The operation for each of the vectors.
template <std::size_t n, class Operation, class... Args>
HWY_INLINE InStep<n> each(Operation operation, const Args&... args) {
    InStep<n> result;
    for (std::size_t i = 0; i < n; ++i) result.v[i] = operation(one_of(args, i)...);
    return result;
}

#define HAPTOGRAM_IN_STEP(name)                                                        \
    template <std::size_t n, class... Args>                                            \
    HWY_INLINE InStep<n> name(const InStep<n>& first, const Args&... args) {           \
        return each<n>([](auto... a) HWY_ATTR { return name(a...); }, first, args...); \
    }
HAPTOGRAM_IN_STEP(mul)
HAPTOGRAM_IN_STEP(add)
HAPTOGRAM_IN_STEP(sub)
HAPTOGRAM_IN_STEP(mul_add)
HAPTOGRAM_IN_STEP(mul_sub)
HAPTOGRAM_IN_STEP(neg_mul_add)

/// A complex number, amplitude·(cosine − j·sine). Its parts are V or InStep.
template <class Vs>
struct Polar {
    Vs amplitude, cosine, sine;
};

/// The amplitude with the other sign where the lowest bit of `whole` is set.
HWY_INLINE V with_sign_of(V amplitude, V whole) {
    const hn::RebindToUnsigned<D> du;
    return hn::BitCast(D(), hn::Xor(hn::BitCast(du, amplitude), hn::ShiftLeft<31>(hn::BitCast(du, whole))));
}
HAPTOGRAM_IN_STEP(with_sign_of)

/// amplitude·e^{−jπ·half_turns}. The phase is split into a whole number of half turns and a rest f, |f| ≤ 1/2. Cosine
/// and sine are polynomials in f; an odd number of half turns changes both signs, which is done once, in the amplitude.
template <class Vs>
HWY_INLINE Polar<Vs> turn(const Vs& amplitude, const Vs& half_turns) {
    const D d;
    const V shift = hn::Set(d, 12582912.0F);  // 1.5·2²³; adding it rounds to a whole number, whose lowest bit says odd
    const Vs shifted = add(half_turns, shift);
    const Vs f = sub(half_turns, sub(shifted, shift));
    const Vs u = mul(f, f);
    // Polynomials of least maximum error on |f| ≤ 1/2, which is 1.4e-8 for the sine and 4.7e-8 for the cosine.
    Vs sine = mul_add(u, hn::Set(d, 0.07765941F), hn::Set(d, -0.59829216F));
    Vs cosine = mul_add(u, hn::Set(d, 0.2196968F), hn::Set(d, -1.33188016F));
    sine = mul_add(sine, u, hn::Set(d, 2.55007766F));
    cosine = mul_add(cosine, u, hn::Set(d, 4.05841191F));
    sine = mul_add(sine, u, hn::Set(d, -5.16771009F));
    cosine = mul_add(cosine, u, hn::Set(d, -4.93479286F));
    sine = mul_add(sine, u, hn::Set(d, 3.14159264F));
    cosine = mul_add(cosine, u, hn::Set(d, 0.99999995F));
    return {with_sign_of(amplitude, shifted), cosine, mul(sine, f)};
}

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
