// SPDX-License-Identifier: Apache-2.0
// Highway compiles this file once for each instruction set, and picks one when the program runs.
//
// Instruction sets whose vectors have no size at compile time are left out: the code below keeps vectors in structs and
// arrays.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/acoustics/wave.cpp"
#include "haptogram/acoustics/wave.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <type_traits>
// These headers must come after highway.h.
#include <hwy/contrib/math/math-inl.h>

#include "haptogram/acoustics/turn-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

/// 1/√x to 12 bits at least.
HWY_INLINE V rough_inverse_root(V x) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
    return hn::ApproximateReciprocalSqrt(x);  // 14 bits
#else
    return inverse_root(x);
#endif
}
HAPTOGRAM_IN_STEP(rough_inverse_root)

/// a/b, with an error of a few units in the last place.
HWY_INLINE V quotient(V a, V b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR
    const D d;
    const V guess = hn::ApproximateReciprocal(b);
    const V rough = hn::Mul(a, guess);
    return hn::MulAdd(rough, hn::NegMulAdd(b, guess, hn::Set(d, 1.0F)), rough);
#else
    return hn::Div(a, b);
#endif
}

/// Points as an element that faces +z sees them.
struct SeenUpright {
    V x, y, z;  ///< from the element to the points, metres
    HWY_INLINE SeenUpright(const WaveElement&, V dx, V dy, V dz) : x(dx), y(dy), z(dz) {}
    /// Distance along the element's normal; negative behind the element.
    HWY_INLINE V along() const { return z; }
    /// Square of the distance from the line through the element along its normal.
    HWY_INLINE V across_square() const { return hn::MulAdd(x, x, hn::Mul(y, y)); }
};

/// Points as an element that faces anywhere sees them.
struct SeenTilted {
    V x, y, z, nx, ny, nz;
    HWY_INLINE SeenTilted(const WaveElement& element, V dx, V dy, V dz)
        : x(dx),
          y(dy),
          z(dz),
          nx(hn::Set(D(), element.nx)),
          ny(hn::Set(D(), element.ny)),
          nz(hn::Set(D(), element.nz)) {}
    HWY_INLINE V along() const { return hn::MulAdd(x, nx, hn::MulAdd(y, ny, hn::Mul(z, nz))); }
    /// By the cross product: range² − along² would have no correct digit near the axis.
    HWY_INLINE V across_square() const {
        const V cx = hn::MulSub(y, nz, hn::Mul(z, ny));
        const V cy = hn::MulSub(z, nx, hn::Mul(x, nz));
        const V cz = hn::MulSub(x, ny, hn::Mul(y, nx));
        return hn::MulAdd(cx, cx, hn::MulAdd(cy, cy, hn::Mul(cz, cz)));
    }
};

struct PointPattern {
    explicit PointPattern(const FittedPattern&) {}
    template <class Seen>
    HWY_INLINE V operator()(const Seen&, V /*inverse_range*/) const {
        return hn::Set(D(), 1.0F);
    }
    template <class Seen>
    HWY_INLINE V with_slope(const Seen&, V /*inverse_range*/, V& slope) const {
        slope = hn::Zero(D());
        return hn::Set(D(), 1.0F);
    }
};

/// @tparam behind  elements radiate backwards, too
template <std::size_t degree, bool behind = true>
struct PolynomialPattern {
    const float* c;
    explicit PolynomialPattern(const FittedPattern& pattern) : c(pattern.values.data()) {}
    template <class Seen>
    HWY_INLINE V operator()(const Seen& seen, V inverse_range) const {
        return at(seen.along(), inverse_range);
    }
    /// @param along  distance along the element's normal
    template <class Vs>
    HWY_INLINE Vs at(const Vs& along, const Vs& inverse_range) const {
        const D d;
        // √2·cos θ, so that its square less 1 is the polynomial's variable, 2·cos²θ − 1.
        const Vs cosine = mul(mul(along, hn::Set(d, 1.41421356F)), inverse_range);
        const Vs t = mul_sub(cosine, cosine, hn::Set(d, 1.0F));
        Vs sum = mul_add(t, hn::Set(d, c[degree]), hn::Set(d, c[degree - 1]));
        for (std::size_t i = degree - 1; i-- > 0;) sum = mul_add(sum, t, hn::Set(d, c[i]));
        if constexpr (!behind) sum = hn::IfThenElseZero(hn::Ge(along, hn::Zero(d)), sum);
        return sum;
    }
    /// Also the slope dD/d(cos θ), which is 4·cos θ·dD/dt.
    template <class Seen>
    HWY_INLINE V with_slope(const Seen& seen, V inverse_range, V& slope) const {
        const D d;
        const V along = seen.along(), cosine = hn::Mul(along, inverse_range);
        const V t = hn::MulSub(hn::Add(cosine, cosine), cosine, hn::Set(d, 1.0F));
        V sum = hn::Set(d, c[degree]);
        slope = hn::Zero(d);
        for (std::size_t i = degree; i-- > 0;) {  // Horner's rule, and its derivative
            slope = hn::MulAdd(slope, t, sum);
            sum = hn::MulAdd(sum, t, hn::Set(d, c[i]));
        }
        slope = hn::Mul(slope, hn::Mul(hn::Set(d, 4.0F), cosine));
        if constexpr (!behind) {
            const auto front = hn::Ge(along, hn::Zero(d));
            sum = hn::IfThenElseZero(front, sum);
            slope = hn::IfThenElseZero(front, slope);
        }
        return sum;
    }
};

using Places = hn::Vec<hn::RebindToSigned<D>>;

/// A table with straight lines between its values, which are gathered from memory.
struct GatheredTable {
    const float* values;
    int last;
    explicit GatheredTable(const std::vector<float>& table)
        : values(table.data()), last(static_cast<int>(table.size()) - 1) {}
    HWY_INLINE V at(V place) const {
        const D d;
        const hn::RebindToSigned<D> di;
        // Held inside the table even when a coordinate is not a number, because it is used as an address.
        const Places low = hn::Max(hn::Min(hn::ConvertTo(di, place), hn::Set(di, last - 1)), hn::Zero(di));
        const V from = hn::GatherIndex(d, values, low);
        const V to = hn::GatherIndex(d, values, hn::Add(low, hn::Set(di, 1)));
        return hn::MulAdd(hn::Sub(to, from), hn::Sub(place, hn::ConvertTo(d, low)), from);
    }
};

/// The same for a table with no more values than a vector has lanes: they stay in a register.
struct HeldTable {
    V values, steps;
    Places last;
    explicit HeldTable(const std::vector<float>& table) {
        const D d;
        HWY_ALIGN float all[HWY_MAX_BYTES / sizeof(float)] = {}, next[HWY_MAX_BYTES / sizeof(float)] = {};
        for (std::size_t i = 0; i < table.size(); ++i) all[i] = table[i];
        for (std::size_t i = 0; i + 1 < table.size(); ++i) next[i] = table[i + 1] - table[i];
        values = hn::Load(d, all);
        steps = hn::Load(d, next);
        last = hn::Set(hn::RebindToSigned<D>(), static_cast<int>(table.size()) - 1);
    }
    static bool holds(const std::vector<float>& table) { return table.size() <= hn::Lanes(D()); }
    HWY_INLINE V at(V place) const {
        const D d;
        const hn::RebindToSigned<D> di;
        const Places low = hn::ConvertTo(di, place);
        const V rest = hn::Sub(place, hn::ConvertTo(d, low));
        const auto lanes = hn::IndicesFromVec(d, hn::Max(hn::Min(low, last), hn::Zero(di)));
        return hn::MulAdd(hn::TableLookupLanes(steps, lanes), rest, hn::TableLookupLanes(values, lanes));
    }
};

/// The arc sine of 0 to 0.71, by an odd polynomial of least maximum error, which is 4e-7.
HWY_INLINE V small_arc_sine(V x) {
    const D d;
    const V u = hn::Mul(x, x);
    V sum = hn::MulAdd(hn::Set(d, 0.11306883F), u, hn::Set(d, -0.04699958F));
    sum = hn::MulAdd(sum, u, hn::Set(d, 0.07217813F));
    sum = hn::MulAdd(sum, u, hn::Set(d, 0.07047878F));
    sum = hn::MulAdd(sum, u, hn::Set(d, 0.16697747F));
    sum = hn::MulAdd(sum, u, hn::Set(d, 0.99999398F));
    return hn::Mul(sum, x);
}

template <class Table>
struct TablePattern {
    Table table;
    int last;
    bool behind;
    explicit TablePattern(const FittedPattern& pattern)
        : table(pattern.values), last(static_cast<int>(pattern.values.size()) - 1), behind(pattern.behind) {}
    template <class Seen>
    HWY_INLINE V operator()(const Seen& seen, V inverse_range) const {
        const D d;
        const V along = seen.along();
        // The angle follows from the smaller of its sine and cosine: the larger one hardly changes with the angle, and
        // its rounding would be an error of many digits in the angle.
        const V along_square = hn::Mul(along, along), across_square = seen.across_square();
        const V smaller = hn::Max(hn::Min(along_square, across_square), hn::Set(d, 1e-30F));  // 0 has no inverse
        const V small = small_arc_sine(hn::Mul(hn::Mul(smaller, inverse_root(smaller)), inverse_range));
        const V angle =
            hn::IfThenElse(hn::Lt(across_square, along_square), small, hn::Sub(hn::Set(d, 1.57079633F), small));
        const V place = hn::Mul(angle, hn::Set(d, static_cast<float>(last) / 1.57079633F));
        const V found = table.at(place);
        // A point exactly at 90° counts as in front. For an element that faces +z this is decided as in double
        // precision, because rounding to float never swaps two heights. For a tilted one, rounding of the dot product
        // decides for points within about 1e-7 of the range from its plane.
        return behind ? found : hn::IfThenElseZero(hn::Ge(along, hn::Zero(d)), found);
    }
};

/// From an element to points: their range, and by how much the wave lags there.
struct Way {
    V dx, dy, dz, inverse, range, phase;
    HWY_INLINE Way(const WaveElement& element, V half_turns, V x, V y, V z, V half_square) {
        const D d;
        const V ex = hn::Set(d, element.x), ey = hn::Set(d, element.y), ez = hn::Set(d, element.z);
        dx = hn::Sub(x, ex);
        dy = hn::Sub(y, ey);
        dz = hn::Sub(z, ez);
        const V square = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
        inverse = inverse_root(square);
        range = hn::Mul(square, inverse);
        // The phase needs r − r0, the point's range less the block centre's. Subtracting two nearly equal ranges would
        // lose digits; (r² − r0²)/(r + r0) does not, with r² − r0² written as |p|² − 2·p·e.
        const V half_growth = hn::NegMulAdd(x, ex, hn::NegMulAdd(y, ey, hn::NegMulAdd(z, ez, half_square)));
        const V half_way = quotient(half_growth, hn::Add(range, hn::Set(d, element.range)));
        phase = hn::MulAdd(half_way, half_turns, hn::Set(d, element.phase));
    }
};

/// The wave of an element that faces +z and whose directivity is a polynomial, in air that absorbs nothing, at points
/// that are all far (WaveBlock::far): a sixth fewer instructions than Wave's.
///
/// r² = r₀² + q is exact enough there, q being the difference of the squares. So r − r₀ and 1/r follow from a guess of
/// 1/r by one step of Newton's method each, which share their correction, and nothing is divided.
template <std::size_t degree>
struct FarWave {
    static constexpr std::size_t in_step = HWY_TARGET <= HWY_AVX3 ? 8 : 4;  ///< vectors; found by trying
    PolynomialPattern<degree> pattern;
    float half_turns;
    explicit FarWave(const WaveModel& model) : pattern(model.pattern), half_turns(model.half_turns_per_m) {}

    template <class Vs>
    HWY_INLINE Polar<Vs> operator()(const WaveElement& element, const Vs& x, const Vs& y, const Vs& z,
                                    const Vs& half_square) const {
        const D d;
        const V r0 = hn::Set(d, element.range);
        Vs half_growth = neg_mul_add(x, hn::Set(d, element.x), half_square);
        half_growth = neg_mul_add(y, hn::Set(d, element.y), half_growth);
        half_growth = neg_mul_add(z, hn::Set(d, element.z), half_growth);
        const Vs square = mul_add(half_growth, hn::Set(d, 2.0F), hn::Set(d, element.range_square));
        const Vs guess = rough_inverse_root(square);
        const Vs rough = mul_sub(square, guess, r0);  // about r − r₀, which solves w² + 2r₀w = q
        const Vs rest = neg_mul_add(rough, mul_add(rough, hn::Set(d, 0.5F), r0), half_growth);
        const Vs step = mul(rest, guess);
        const Vs growth = add(rough, step);
        const Vs inverse = mul_add(mul(guess, step), guess, guess);
        const Vs phase = mul_add(growth, hn::Set(d, half_turns), hn::Set(d, element.phase));
        const Vs directivity = pattern.at(sub(z, hn::Set(d, element.z)), inverse);
        return turn(mul(mul(inverse, hn::Set(d, element.amplitude)), directivity), phase);
    }
};

/// The gradient of a wave is e^{−jφ}·(radial·r̂ + axial·n), with the direction r̂ from the element and its normal n.
/// What changes along r̂ is the range; the directivity D changes with cos θ, whose gradient is (n − cos θ·r̂)/R.
struct Gradient {
    V along_re, along_im, axial_re, axial_im;  ///< along is over R, so that it multiplies the way itself
};

template <class PatternAt, class Seen, bool absorbs>
struct Wave {
    static constexpr std::size_t in_step = 1;
    PatternAt pattern;
    float half_turns, absorption;
    explicit Wave(const WaveModel& model)
        : pattern(model.pattern), half_turns(2.0F * model.half_turns_per_m), absorption(-model.absorption_np_m) {}

    /// p = amplitude·(cosine − j·sine), from `element` to the points (x, y, z).
    HWY_INLINE Polar<V> operator()(const WaveElement& element, V x, V y, V z, V half_square) const {
        const D d;
        const Way way(element, hn::Set(d, half_turns), x, y, z, half_square);
        const V directivity = pattern(Seen(element, way.dx, way.dy, way.dz), way.inverse);
        V amplitude = hn::Mul(hn::Mul(way.inverse, hn::Set(d, element.amplitude)), directivity);
        if constexpr (absorbs) amplitude = hn::Mul(amplitude, hn::Exp(d, hn::Mul(hn::Set(d, absorption), way.range)));
        return turn(amplitude, way.phase);
    }

    HWY_INLINE Gradient gradient(const WaveElement& element, const Way& way) const {
        const D d;
        const Seen seen(element, way.dx, way.dy, way.dz);
        V slope;
        const V directivity = pattern.with_slope(seen, way.inverse, slope);
        V amplitude = hn::Mul(way.inverse, hn::Set(d, element.amplitude));
        if constexpr (absorbs) amplitude = hn::Mul(amplitude, hn::Exp(d, hn::Mul(hn::Set(d, absorption), way.range)));
        const Polar<V> wave = turn(amplitude, way.phase);
        const V re = hn::Mul(wave.amplitude, wave.cosine), im = hn::Neg(hn::Mul(wave.amplitude, wave.sine));
        const V axial = hn::Mul(slope, way.inverse);
        const V cosine = hn::Mul(seen.along(), way.inverse);
        // radial = −D·(1/R + α) − axial·cos θ − jkD
        const V loss = hn::Sub(way.inverse, hn::Set(d, absorption));
        const V radial_re = hn::Neg(hn::MulAdd(directivity, loss, hn::Mul(axial, cosine)));
        const V radial_im = hn::Mul(directivity, hn::Set(d, -1.57079633F * half_turns));  // −k, as half_turns is 4/λ
        return {hn::Mul(hn::MulSub(re, radial_re, hn::Mul(im, radial_im)), way.inverse),
                hn::Mul(hn::MulAdd(re, radial_im, hn::Mul(im, radial_re)), way.inverse), hn::Mul(re, axial),
                hn::Mul(im, axial)};
    }
};

template <class PatternAt, class Seen, class Call>
void with_absorption(const WaveModel& model, Call call) {
    if (model.absorption_np_m == 0.0F)
        call(Wave<PatternAt, Seen, false>(model));
    else
        call(Wave<PatternAt, Seen, true>(model));
}

template <class Seen, class Call>
void with_polynomial(const WaveModel& model, Call call) {
    const FittedPattern& pattern = model.pattern;
    const bool lowest = pattern.values.size() == polynomial_degrees[0] + 1;
    if (!pattern.behind && lowest)
        return with_absorption<PolynomialPattern<polynomial_degrees[0], false>, Seen>(model, call);
    if (!pattern.behind) return with_absorption<PolynomialPattern<polynomial_degrees[1], false>, Seen>(model, call);
    if (lowest) return with_absorption<PolynomialPattern<polynomial_degrees[0]>, Seen>(model, call);
    if (pattern.values.size() == polynomial_degrees[1] + 1)
        return with_absorption<PolynomialPattern<polynomial_degrees[1]>, Seen>(model, call);
    with_absorption<PolynomialPattern<polynomial_degrees[2]>, Seen>(model, call);
}

template <class Seen, class Call>
void with_pattern(const WaveModel& model, Call call) {
    if (model.pattern.kind != FittedPattern::Kind::table)
        with_polynomial<Seen>(model, call);
    else if (HeldTable::holds(model.pattern.values))
        with_absorption<TablePattern<HeldTable>, Seen>(model, call);
    else
        with_absorption<TablePattern<GatheredTable>, Seen>(model, call);
}

/// Calls call(wave) with the Wave type that fits the model. All choices are made here, once, so that the loops over
/// points and elements contain none.
template <class Call>
void with_wave(const WaveModel& model, Call call) {
    if (model.pattern.kind == FittedPattern::Kind::point)  // radiates alike in every direction, however it is turned
        with_absorption<PointPattern, SeenUpright>(model, call);
    else if (model.tilted)
        with_pattern<SeenTilted>(model, call);
    else
        with_pattern<SeenUpright>(model, call);
}

/// A plain loop that the compiler turns into vectors: Highway has none of double for some processors.
void centre_block_at(const double* HWY_RESTRICT x, const double* HWY_RESTRICT y, const double* HWY_RESTRICT z,
                     std::size_t count, Vec3 centre, WaveBlock& block) {
    float* HWY_RESTRICT to_x = block.x.data();
    float* HWY_RESTRICT to_y = block.y.data();
    float* HWY_RESTRICT to_z = block.z.data();
    float* HWY_RESTRICT half_square = block.half_square.data();
    for (std::size_t i = 0; i < count; ++i) {
        const double dx = x[i] - centre.x, dy = y[i] - centre.y, dz = z[i] - centre.z;
        to_x[i] = static_cast<float>(dx);
        to_y[i] = static_cast<float>(dy);
        to_z[i] = static_cast<float>(dz);
        half_square[i] = static_cast<float>((dx * dx + dy * dy + dz * dz) * 0.5);
    }
    block.count = count;
}

/// The same for a block of which all is far, if the model has a quicker wave there.
template <class Call>
void with_far_wave(const WaveModel& model, Call call) {
    const FittedPattern& pattern = model.pattern;
    const bool quick = !model.tilted && model.absorption_np_m == 0.0F && pattern.behind &&
                       pattern.kind == FittedPattern::Kind::polynomial;
    if (quick && pattern.values.size() == polynomial_degrees[0] + 1)
        call(FarWave<polynomial_degrees[0]>(model));
    else if (quick && pattern.values.size() == polynomial_degrees[1] + 1)
        call(FarWave<polynomial_degrees[1]>(model));
    else
        with_wave(model, call);
}

/// Adds up the waves from the point `i` on, `n` vectors of points in step, as long as there are so many; then half as
/// many, down to one.
template <std::size_t n, class Wave>
HWY_INLINE void sum_in_step(const Wave& wave, const WaveBlock& block, const WaveElement* elements, std::size_t count,
                            std::size_t i, float* re, float* im) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    for (; i + (n - 1) * lanes < block.count; i += n * lanes) {
        std::conditional_t<n == 1, V, InStep<n>> x, y, z, half_square, sum_re, sum_im;
        for (std::size_t t = 0; t < n; ++t) {
            const std::size_t at = i + t * lanes;
            one_of(x, t) = hn::Load(d, &block.x[at]);
            one_of(y, t) = hn::Load(d, &block.y[at]);
            one_of(z, t) = hn::Load(d, &block.z[at]);
            one_of(half_square, t) = hn::Load(d, &block.half_square[at]);
            one_of(sum_re, t) = one_of(sum_im, t) = hn::Zero(d);
        }
        for (const WaveElement* e = elements; e != elements + count; ++e) {
            const auto p = wave(*e, x, y, z, half_square);
            sum_re = mul_add(p.amplitude, p.cosine, sum_re);
            sum_im = neg_mul_add(p.amplitude, p.sine, sum_im);
        }
        for (std::size_t t = 0; t < n; ++t) {
            hn::StoreU(one_of(sum_re, t), d, re + i + t * lanes);
            hn::StoreU(one_of(sum_im, t), d, im + i + t * lanes);
        }
    }
    if constexpr (n > 1) sum_in_step<n / 2>(wave, block, elements, count, i, re, im);
}

void sum_waves_to(const WaveModel& model, const WaveBlock& block, const WaveElement* elements, std::size_t count,
                  float* re, float* im) {
    const auto sum = [&](auto wave)
                         HWY_ATTR { sum_in_step<decltype(wave)::in_step>(wave, block, elements, count, 0, re, im); };
    if (block.far)
        with_far_wave(model, sum);
    else
        with_wave(model, sum);
}

void sum_gradients_to(const WaveModel& model, const WaveBlock& block, const WaveElement* elements, std::size_t count,
                      const std::array<float*, 6>& parts) {
    const D d;
    const auto sum = [&](auto wave) HWY_ATTR {
        const V half_turns = hn::Set(d, wave.half_turns);
        for (std::size_t i = 0; i < block.count; i += hn::Lanes(d)) {
            const V x = hn::Load(d, &block.x[i]), y = hn::Load(d, &block.y[i]), z = hn::Load(d, &block.z[i]);
            const V half_square = hn::Load(d, &block.half_square[i]);
            V sums[6];
            for (V& one : sums) one = hn::Zero(d);
            for (const WaveElement* e = elements; e != elements + count; ++e) {
                const Way way(*e, half_turns, x, y, z, half_square);
                const Gradient g = wave.gradient(*e, way);
                const V ways[3] = {way.dx, way.dy, way.dz};
                const V normal[3] = {hn::Set(d, e->nx), hn::Set(d, e->ny), hn::Set(d, e->nz)};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    V& re = sums[2 * axis];
                    V& im = sums[2 * axis + 1];
                    re = hn::MulAdd(g.along_re, ways[axis], hn::MulAdd(g.axial_re, normal[axis], re));
                    im = hn::MulAdd(g.along_im, ways[axis], hn::MulAdd(g.axial_im, normal[axis], im));
                }
            }
            for (std::size_t part = 0; part < 6; ++part) hn::StoreU(sums[part], d, parts[part] + i);
        }
    };
    // Seen as tilted whether they are or not: the normals are needed in any case.
    if (model.pattern.kind == FittedPattern::Kind::point)
        with_absorption<PointPattern, SeenTilted>(model, sum);
    else
        with_polynomial<SeenTilted>(model, sum);
}

/// The pair's weighted |p|² at two vectors of points, added to `sum`.
/// @param field  of each element: two vectors of real parts, then two of imaginary parts
HWY_INLINE void add_pair(const DrivePair* drives, std::size_t elements, const float* weights, const float* field,
                         V& sum_0, V& sum_1) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    V re[2][2], im[2][2];
    for (auto& r : re) r[0] = r[1] = hn::Zero(d);
    for (auto& r : im) r[0] = r[1] = hn::Zero(d);
    for (std::size_t m = 0; m < elements; ++m, field += 4 * lanes) {
        const V f_re[2] = {hn::Load(d, field), hn::Load(d, field + lanes)};
        const V f_im[2] = {hn::Load(d, field + 2 * lanes), hn::Load(d, field + 3 * lanes)};
        for (int r = 0; r < 2; ++r) {
            const V a = hn::Set(d, drives[m].re[r]), b = hn::Set(d, drives[m].im[r]);
            for (int i = 0; i < 2; ++i) {
                re[r][i] = hn::NegMulAdd(b, f_im[i], hn::MulAdd(a, f_re[i], re[r][i]));
                im[r][i] = hn::MulAdd(b, f_re[i], hn::MulAdd(a, f_im[i], im[r][i]));
            }
        }
    }
    for (int r = 0; r < 2; ++r) {
        const V w = hn::Set(d, weights[r]);
        sum_0 = hn::MulAdd(w, hn::MulAdd(re[r][0], re[r][0], hn::Mul(im[r][0], im[r][0])), sum_0);
        sum_1 = hn::MulAdd(w, hn::MulAdd(re[r][1], re[r][1], hn::Mul(im[r][1], im[r][1])), sum_1);
    }
}

void sum_squares_to(const WaveModel& model, const WaveBlock& block, const WaveElement* elements, std::size_t count,
                    const DrivePair* drives, const float* weights, std::size_t pairs, float* scratch, float* mean) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    constexpr std::size_t run =
        32;  // pairs in a partial sum; partial sums keep rounding small however long the sequence is
    with_wave(model, [&](auto wave) HWY_ATTR {
        for (std::size_t i = 0; i < block.count; i += 2 * lanes) {
            for (std::size_t half = 0; half < 2; ++half) {
                const std::size_t at = i + half * lanes;
                const V x = hn::Load(d, &block.x[at]), y = hn::Load(d, &block.y[at]), z = hn::Load(d, &block.z[at]);
                const V half_square = hn::Load(d, &block.half_square[at]);
                for (std::size_t m = 0; m < count; ++m) {
                    const Polar<V> p = wave(elements[m], x, y, z, half_square);
                    float* field = scratch + (4 * m + half) * lanes;
                    hn::Store(hn::Mul(p.amplitude, p.cosine), d, field);
                    hn::Store(hn::Neg(hn::Mul(p.amplitude, p.sine)), d, field + 2 * lanes);
                }
            }
            V sum_0 = hn::Zero(d), sum_1 = hn::Zero(d);
            for (std::size_t begin = 0; begin < pairs; begin += run) {
                V part_0 = hn::Zero(d), part_1 = hn::Zero(d);
                for (std::size_t pair = begin; pair < pairs && pair < begin + run; ++pair)
                    add_pair(drives + pair * count, count, weights + 2 * pair, scratch, part_0, part_1);
                sum_0 = hn::Add(sum_0, part_0);
                sum_1 = hn::Add(sum_1, part_1);
            }
            hn::StoreU(sum_0, d, mean + i);
            hn::StoreU(sum_1, d, mean + i + lanes);
        }
    });
}

/// Computes `vectors` vectors of points in each of `rows` rows at once, so that each value of the field is loaded once
/// for all rows.
template <std::size_t rows, std::size_t vectors>
void sum_shifted_tile(const float* field_re, const float* field_im, const ShiftedShare* shares, std::size_t count,
                      std::size_t from, float* const* out, std::size_t points) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    V re[rows][vectors], im[rows][vectors];
    for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t v = 0; v < vectors; ++v) re[r][v] = im[r][v] = hn::Zero(d);
    for (const ShiftedShare* share = shares; share != shares + count; ++share) {
        const float* from_re = field_re + share->at + from;
        const float* from_im = field_im + share->at + from;
        for (std::size_t v = 0; v < vectors; ++v) {
            const V f_re = hn::LoadU(d, from_re + v * lanes), f_im = hn::LoadU(d, from_im + v * lanes);
            for (std::size_t r = 0; r < rows; ++r) {
                const V a = hn::Set(d, share->drives.re[r]), b = hn::Set(d, share->drives.im[r]);
                re[r][v] = hn::NegMulAdd(b, f_im, hn::MulAdd(a, f_re, re[r][v]));
                im[r][v] = hn::MulAdd(b, f_re, hn::MulAdd(a, f_im, im[r][v]));
            }
        }
    }
    HWY_ALIGN float tile[2 * shifted_tile];
    const bool whole = from + vectors * lanes <= points;
    for (std::size_t r = 0; r < rows; ++r) {
        float* to = whole ? out[r] + 2 * from : tile;
        for (std::size_t v = 0; v < vectors; ++v) hn::StoreInterleaved2(re[r][v], im[r][v], d, to + 2 * v * lanes);
        if (!whole)
            for (std::size_t i = 0; i < 2 * (points - from); ++i) out[r][2 * from + i] = tile[i];
    }
}

template <std::size_t rows>
void sum_shifted_rows(const float* field_re, const float* field_im, const ShiftedShare* shares, std::size_t count,
                      float* const* out, std::size_t points) {
    const std::size_t lanes = hn::Lanes(D());
    constexpr std::size_t most = HWY_TARGET <= HWY_AVX3 || !HWY_ARCH_X86 ? 4 : 2;  // as many as fit into the registers
    static_assert(most * HWY_MAX_BYTES / sizeof(float) <= shifted_tile);
    std::size_t from = 0;
    for (; from + (most - 1) * lanes < points; from += most * lanes)
        sum_shifted_tile<rows, most>(field_re, field_im, shares, count, from, out, points);
    if constexpr (most > 2)
        for (; from + lanes < points; from += 2 * lanes)
            sum_shifted_tile<rows, 2>(field_re, field_im, shares, count, from, out, points);
    for (; from < points; from += lanes)
        sum_shifted_tile<rows, 1>(field_re, field_im, shares, count, from, out, points);
}

void sum_shifted_to(const float* field_re, const float* field_im, const ShiftedShare* shares, std::size_t count,
                    float* first, float* second, std::size_t points) {
    float* const out[2] = {first, second};
    if (second == nullptr)
        sum_shifted_rows<1>(field_re, field_im, shares, count, out, points);
    else
        sum_shifted_rows<2>(field_re, field_im, shares, count, out, points);
}

std::size_t lanes() { return hn::Lanes(D()); }
const char* target_of_waves() { return hwy::TargetName(HWY_TARGET); }

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace haptogram {

HWY_EXPORT(centre_block_at);
HWY_EXPORT(sum_waves_to);
HWY_EXPORT(sum_gradients_to);
HWY_EXPORT(sum_squares_to);
HWY_EXPORT(sum_shifted_to);
HWY_EXPORT(lanes);
HWY_EXPORT(target_of_waves);

void centre_block(const double* x, const double* y, const double* z, std::size_t count, Vec3 centre, WaveBlock& block) {
    HWY_DYNAMIC_DISPATCH(centre_block_at)(x, y, z, count, centre, block);
}

void sum_waves(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements, float* re,
               float* im) {
    HWY_DYNAMIC_DISPATCH(sum_waves_to)(model, block, elements.data(), elements.size(), re, im);
}

void sum_gradients(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements,
                   const std::array<float*, 6>& parts) {
    HWY_DYNAMIC_DISPATCH(sum_gradients_to)(model, block, elements.data(), elements.size(), parts);
}

void sum_squares(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements,
                 std::span<const DrivePair> drives, std::span<const float> weights, float* scratch, float* mean) {
    HWY_DYNAMIC_DISPATCH(sum_squares_to)
    (model, block, elements.data(), elements.size(), drives.data(), weights.data(), weights.size() / 2, scratch, mean);
}

std::size_t scratch_of_sum_squares(std::size_t elements) { return 4 * elements * HWY_DYNAMIC_DISPATCH(lanes)(); }

void sum_shifted(const float* field_re, const float* field_im, std::span<const ShiftedShare> shares,
                 std::complex<float>* first, std::complex<float>* second, std::size_t points) {
    HWY_DYNAMIC_DISPATCH(sum_shifted_to)
    (field_re, field_im, shares.data(), shares.size(), reinterpret_cast<float*>(first),
     reinterpret_cast<float*>(second), points);
}

const char* wave_target() { return HWY_DYNAMIC_DISPATCH(target_of_waves)(); }

}  // namespace haptogram
#endif
