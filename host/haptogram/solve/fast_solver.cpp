// SPDX-License-Identifier: Apache-2.0
// Highway compiles this file once for each instruction set, and picks one when the program runs. Instruction sets whose
// vectors have no size at compile time are left out: the code below keeps vectors in arrays.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/solve/fast_solver.cpp"
#include "haptogram/solve/fast_solver.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "haptogram/acoustics/root-inl.hpp"

#ifndef HAPTOGRAM_SOLVE_FAST_SOLVER_ONCE
#define HAPTOGRAM_SOLVE_FAST_SOLVER_ONCE
namespace haptogram {

inline constexpr std::size_t whole_vectors = 64;  ///< floats; a multiple of four vectors of any processor that is used

/// The numbers of solver.cpp's Problem, real and imaginary parts apart. Rows of elements are padded with zeros to
/// `stride`, those of foci to `most_foci`, both multiples of whole_vectors.
struct FociProblem {
    std::size_t foci = 0, stride = 0, most_foci = 0;
    float *a_re = nullptr, *a_im = nullptr;  ///< propagation over target, most_foci rows of elements
    float *x_re = nullptr, *x_im = nullptr;  ///< drives
    float *p_re = nullptr, *p_im = nullptr;  ///< pressures over targets
    float* size = nullptr;                   ///< |p|
    float *c_re = nullptr, *c_im = nullptr;  ///< coefficients of the foci, weighted
    float* weight = nullptr;
    float* slope = nullptr;   ///< d|p|/d phase, rows of elements
    float* normal = nullptr;  ///< slope·slopeᵀ, rows of foci
    float* step = nullptr;
};

}  // namespace haptogram
#endif

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

/// Vectors of elements that are computed in step, so that one need not wait for its last result. As many as registers.
constexpr std::size_t in_step = HWY_TARGET <= HWY_AVX3 ? 4 : 2;

/// 1/|re + j·im|, and a large number where that is 0: its product with 0 is 0.
HWY_INLINE V inverse_size(V re, V im) {
    return inverse_root(hn::MulAdd(re, re, hn::MulAdd(im, im, hn::Set(D(), 1e-30F))));
}

HWY_INLINE float sum_of(V v) {
    const D d;
    return hn::GetLane(hn::SumOfLanes(d, v));
}

/// Sum of the sizes of a row, Σ |A|.
float sum_of_sizes(const float* re, const float* im, std::size_t count) {
    const D d;
    V sum = hn::Zero(d);
    for (std::size_t m = 0; m < count; m += hn::Lanes(d)) {
        const V r = hn::Load(d, re + m), i = hn::Load(d, im + m);
        const V square = hn::MulAdd(r, r, hn::Mul(i, i));
        sum = hn::MulAdd(square, inverse_size(r, i), sum);
    }
    return sum_of(sum);
}

void scale_row(float* re, float* im, std::size_t count, float factor) {
    const D d;
    const V f = hn::Set(d, factor);
    for (std::size_t m = 0; m < count; m += hn::Lanes(d)) {
        hn::Store(hn::Mul(hn::Load(d, re + m), f), d, re + m);
        hn::Store(hn::Mul(hn::Load(d, im + m), f), d, im + m);
    }
}

/// x: the phases of Aᴴ·c.
HWY_INLINE void back(const FociProblem& q) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t m = 0; m < q.stride; m += in_step * lanes) {
        V re[in_step], im[in_step];
        for (std::size_t t = 0; t < in_step; ++t) re[t] = im[t] = hn::Zero(d);
        for (std::size_t k = 0; k < q.foci; ++k) {
            const V c_re = hn::Set(d, q.c_re[k]), c_im = hn::Set(d, q.c_im[k]);
            const float *a_re = q.a_re + k * q.stride + m, *a_im = q.a_im + k * q.stride + m;
            for (std::size_t t = 0; t < in_step; ++t) {
                const V r = hn::Load(d, a_re + t * lanes), i = hn::Load(d, a_im + t * lanes);
                re[t] = hn::MulAdd(r, c_re, hn::MulAdd(i, c_im, re[t]));
                im[t] = hn::MulAdd(r, c_im, hn::NegMulAdd(i, c_re, im[t]));
            }
        }
        for (std::size_t t = 0; t < in_step; ++t) {
            const V inverse = inverse_size(re[t], im[t]);
            hn::Store(hn::Mul(re[t], inverse), d, q.x_re + m + t * lanes);
            hn::Store(hn::Mul(im[t], inverse), d, q.x_im + m + t * lanes);
        }
    }
}

/// p = A·x. Rows beyond the foci are old ones, whose sums are not kept.
HWY_INLINE void forth(const FociProblem& q) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t k = 0; k < q.foci; k += in_step) {
        V re[in_step], im[in_step];
        for (std::size_t t = 0; t < in_step; ++t) re[t] = im[t] = hn::Zero(d);
        const float *a_re = q.a_re + k * q.stride, *a_im = q.a_im + k * q.stride;
        for (std::size_t m = 0; m < q.stride; m += lanes) {
            const V x_re = hn::Load(d, q.x_re + m), x_im = hn::Load(d, q.x_im + m);
            for (std::size_t t = 0; t < in_step; ++t) {
                const V r = hn::Load(d, a_re + t * q.stride + m), i = hn::Load(d, a_im + t * q.stride + m);
                re[t] = hn::MulAdd(r, x_re, hn::NegMulAdd(i, x_im, re[t]));
                im[t] = hn::MulAdd(r, x_im, hn::MulAdd(i, x_re, im[t]));
            }
        }
        for (std::size_t t = 0; t < in_step && k + t < q.foci; ++t) {
            q.p_re[k + t] = sum_of(re[t]);
            q.p_im[k + t] = sum_of(im[t]);
        }
    }
}

/// c: the directions of p, weighted. Beyond the foci p and the weights are 0.
HWY_INLINE void aim(const FociProblem& q) {
    const D d;
    for (std::size_t k = 0; k < q.foci; k += hn::Lanes(d)) {
        const V re = hn::Load(d, q.p_re + k), im = hn::Load(d, q.p_im + k);
        const V factor = hn::Mul(inverse_size(re, im), hn::Load(d, q.weight + k));
        hn::Store(hn::Mul(re, factor), d, q.c_re + k);
        hn::Store(hn::Mul(im, factor), d, q.c_im + k);
    }
}

/// Weights for the next round, and |p|. As Problem::reweigh() of solver.cpp.
HWY_INLINE void reweigh(const FociProblem& q) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    V sum = hn::Zero(d);
    for (std::size_t k = 0; k < q.foci; k += lanes) {
        const V re = hn::Load(d, q.p_re + k), im = hn::Load(d, q.p_im + k);
        const V size = hn::Mul(hn::MulAdd(re, re, hn::Mul(im, im)), inverse_size(re, im));
        hn::Store(size, d, q.size + k);
        sum = hn::Add(sum, size);
    }
    const float mean = sum_of(sum) / static_cast<float>(q.foci);
    for (std::size_t k = 0; k < q.foci; k += lanes) {
        V growth = hn::Div(hn::Set(d, mean), hn::Max(hn::Load(d, q.size + k), hn::Set(d, 1e-3F * mean)));
        if (q.foci <= 3) growth = hn::Sqrt(growth);
        hn::Store(hn::Mul(hn::Load(d, q.weight + k), growth), d, q.weight + k);
    }
}

/// normal = slope·slopeᵀ in tiles of rows, upper triangle.
HWY_INLINE void multiply_slopes(const FociProblem& q) {
    constexpr std::size_t tile = HWY_TARGET <= HWY_AVX3 ? 4 : 2;
    const D d;
    for (std::size_t k = 0; k < q.foci; k += tile)
        for (std::size_t l = k; l < q.foci; l += tile) {
            V sum[tile][tile];
            for (auto& row : sum)
                for (V& one : row) one = hn::Zero(d);
            const float *left = q.slope + k * q.stride, *right = q.slope + l * q.stride;
            for (std::size_t m = 0; m < q.stride; m += hn::Lanes(d)) {
                V row[tile];
                for (std::size_t i = 0; i < tile; ++i) row[i] = hn::Load(d, left + i * q.stride + m);
                for (std::size_t j = 0; j < tile; ++j) {
                    const V column = hn::Load(d, right + j * q.stride + m);
                    for (std::size_t i = 0; i < tile; ++i) sum[i][j] = hn::MulAdd(row[i], column, sum[i][j]);
                }
            }
            for (std::size_t i = 0; i < tile; ++i)
                for (std::size_t j = 0; j < tile; ++j) q.normal[(k + i) * q.most_foci + l + j] = sum_of(sum[i][j]);
        }
}

/// The positive definite system normal·step = step by Cholesky's method, upper triangle, in place. Not Eigen's, as in
/// solver.cpp: this source is compiled once for each instruction set, and inline functions of Eigen would then differ.
HWY_INLINE void solve_positive(const FociProblem& q) {
    const std::size_t n = q.foci, stride = q.most_foci;
    float* HWY_RESTRICT b = q.step;
    for (std::size_t j = 0; j < n; ++j) {
        float* HWY_RESTRICT row = q.normal + j * stride;
        const float inverse = 1.0F / std::sqrt(row[j]);
        for (std::size_t c = j; c < n; ++c) row[c] *= inverse;
        for (std::size_t i = j + 1; i < n; ++i) {
            float* HWY_RESTRICT below = q.normal + i * stride;
            const float factor = row[i];
            for (std::size_t c = i; c < n; ++c) below[c] -= factor * row[c];
        }
        b[j] *= inverse;
        for (std::size_t i = j + 1; i < n; ++i) b[i] -= row[i] * b[j];
        row[j] = inverse;  // what the way back needs
    }
    for (std::size_t j = n; j-- > 0;) {
        const float* row = q.normal + j * stride;
        float sum = b[j];
        for (std::size_t c = j + 1; c < n; ++c) sum -= row[c] * b[c];
        b[j] = sum * row[j];
    }
}

/// The Gauss-Newton step, as Problem::equalise() of solver.cpp.
HWY_INLINE void equalise(const FociProblem& q) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    float level = 0.0F, sum = 0.0F;
    for (std::size_t k = 0; k < q.foci; ++k) {
        q.size[k] = std::sqrt(q.p_re[k] * q.p_re[k] + q.p_im[k] * q.p_im[k]);
        level += q.weight[k] * q.size[k];
        sum += q.weight[k];
    }
    level /= sum;
    for (std::size_t k = 0; k < q.foci; ++k) {
        const float inverse = 1.0F / q.size[k];
        const V u_re = hn::Set(d, q.p_re[k] * inverse), u_im = hn::Set(d, q.p_im[k] * inverse);
        const float *a_re = q.a_re + k * q.stride, *a_im = q.a_im + k * q.stride;
        float* slope = q.slope + k * q.stride;
        for (std::size_t m = 0; m < q.stride; m += lanes) {
            const V r = hn::Load(d, a_re + m), i = hn::Load(d, a_im + m);
            const V x_re = hn::Load(d, q.x_re + m), x_im = hn::Load(d, q.x_im + m);
            const V y_re = hn::NegMulAdd(i, x_im, hn::Mul(r, x_re)), y_im = hn::MulAdd(r, x_im, hn::Mul(i, x_re));
            hn::Store(hn::NegMulAdd(u_re, y_im, hn::Mul(u_im, y_re)), d, slope + m);
        }
        q.step[k] = level - q.size[k];
    }
    multiply_slopes(q);
    float trace = 0.0F;
    for (std::size_t k = 0; k < q.foci; ++k) trace += q.normal[k * q.most_foci + k];
    float squares = 0.0F;
    for (std::size_t k = 0; k < q.foci; ++k) squares += q.size[k] * q.size[k];
    const float damped =
        std::max(1e-4F * trace, 1e-8F * squares / static_cast<float>(q.stride)) / static_cast<float>(q.foci);
    for (std::size_t k = 0; k < q.foci; ++k) q.normal[k * q.most_foci + k] += damped;
    solve_positive(q);
    for (std::size_t m = 0; m < q.stride; m += in_step * lanes) {
        V turn[in_step];
        for (V& t : turn) t = hn::Zero(d);
        for (std::size_t k = 0; k < q.foci; ++k) {
            const V y = hn::Set(d, q.step[k]);
            const float* slope = q.slope + k * q.stride + m;
            for (std::size_t t = 0; t < in_step; ++t) turn[t] = hn::MulAdd(y, hn::Load(d, slope + t * lanes), turn[t]);
        }
        for (std::size_t t = 0; t < in_step; ++t) {
            const std::size_t at = m + t * lanes;
            const V half = hn::Mul(turn[t], hn::Set(d, 0.5F)), square = hn::Mul(half, half), one = hn::Set(d, 1.0F);
            const V inverse = hn::Div(one, hn::Add(one, square));
            const V cosine = hn::Mul(hn::Sub(one, square), inverse), sine = hn::Mul(hn::Add(half, half), inverse);
            const V re = hn::Load(d, q.x_re + at), im = hn::Load(d, q.x_im + at);
            hn::Store(hn::NegMulAdd(sine, im, hn::Mul(cosine, re)), d, q.x_re + at);
            hn::Store(hn::MulAdd(sine, re, hn::Mul(cosine, im)), d, q.x_im + at);
        }
    }
}

/// @param follow  begin from x and the weights; otherwise from c
void improve(const FociProblem& q, unsigned rounds, bool follow) {
    if (follow) {
        forth(q);
        aim(q);
    }
    back(q);
    forth(q);
    for (unsigned round = follow ? 1 : 0; round < rounds; ++round) {
        reweigh(q);
        aim(q);
        back(q);
        forth(q);
    }
    // The weights learn from drives that have not been made equal yet; those of the next frame begin with them.
    reweigh(q);
    equalise(q);
    // As solver.cpp does, for two or three foci may not be even yet.
    for (int step = 1; q.foci <= 3 && step < 3; ++step) {
        forth(q);
        equalise(q);
    }
}

/// −arg(x) in cycles of `cycle` ticks, rounded to the nearest tick.
/// @param ticks  room for q.stride
void ticks_of_drives(const FociProblem& q, float cycle, std::int32_t* ticks) {
    const D d;
    const hn::RebindToSigned<D> di;
    for (std::size_t m = 0; m < q.stride; m += hn::Lanes(d)) {
        const V re = hn::Load(d, q.x_re + m), im = hn::Load(d, q.x_im + m);
        const V a = hn::Abs(re), b = hn::Abs(im);
        // Turns of the smaller over the larger, by a polynomial of least maximum error, which is 4e-8.
        const V ratio = hn::Div(hn::Min(a, b), hn::Max(hn::Max(a, b), hn::Set(d, 1e-30F))), u = hn::Mul(ratio, ratio);
        V turns = hn::MulAdd(hn::Set(d, 0.00108411699F), u, hn::Set(d, -0.00534823397F));
        for (const float c : {0.0126724476F, -0.0210614856F, 0.0315251090F, -0.0530262366F, 0.159154326F})
            turns = hn::MulAdd(turns, u, hn::Set(d, c));
        turns = hn::Mul(turns, ratio);
        turns = hn::IfThenElse(hn::Gt(b, a), hn::Sub(hn::Set(d, 0.25F), turns), turns);
        turns = hn::IfThenElse(hn::Lt(re, hn::Zero(d)), hn::Sub(hn::Set(d, 0.5F), turns), turns);
        turns = hn::IfThenElse(hn::Gt(im, hn::Zero(d)), hn::Sub(hn::Set(d, 1.0F), turns), turns);
        const auto tick = hn::NearestInt(hn::Mul(turns, hn::Set(d, cycle)));
        const auto whole = hn::ConvertTo(di, hn::Set(d, cycle));
        hn::Store(hn::IfThenElse(hn::Eq(tick, whole), hn::Zero(di), tick), di, ticks + m);
    }
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <fmt/core.h>
#include <hwy/aligned_allocator.h>

#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/wave.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

HWY_EXPORT(sum_of_sizes);
HWY_EXPORT(scale_row);
HWY_EXPORT(improve);
HWY_EXPORT(ticks_of_drives);
HWY_EXPORT(target_name);

namespace {

std::size_t padded(std::size_t count) { return (count + whole_vectors - 1) / whole_vectors * whole_vectors; }

Error bad_focus(std::size_t i, const std::string& what) { return bad_input(fmt::format("focus {}", i + 1), what); }

}  // namespace

struct FastSolver::State {
    Array array;
    Options options;
    FociProblem problem;
    hwy::AlignedFreeUniquePtr<float[]> room;
    hwy::AlignedFreeUniquePtr<std::int32_t[]> ticks;
    std::size_t last_foci = 0;
    /// By reciprocity the waves from the elements to a focus are those from the focus to the elements, which are the
    /// points of blocks here. The blocks are mirrored in z, so that a focus in front of the elements sees them in
    /// front.
    WaveModel model;
    std::vector<std::unique_ptr<WaveBlock>> blocks;
    std::vector<Vec3> centres;
    std::vector<double> radii;  ///< of the blocks around their centres

    State(const Array& given, std::size_t most_foci, const Options& chosen) : array(given), options(chosen) {
        const std::size_t elements = array.elements.size();
        if (elements == 0) throw bad_argument("array", "it has no elements");
        if (most_foci == 0 || most_foci > elements)
            throw bad_argument("most_foci", fmt::format("{} foci for {} elements; expected from 1 to as many as "
                                                        "elements",
                                                        most_foci, elements));
        problem.stride = padded(elements);
        problem.most_foci = padded(most_foci);
        const std::size_t matrix = problem.most_foci * problem.stride;
        const std::size_t all = 3 * matrix + 2 * problem.stride + problem.most_foci * (problem.most_foci + 7);
        room = hwy::AllocateAligned<float>(all);
        std::fill_n(room.get(), all, 0.0F);
        float* next = room.get();
        const auto take = [&next](std::size_t count) { return std::exchange(next, next + count); };
        for (float** one : {&problem.a_re, &problem.a_im, &problem.slope}) *one = take(matrix);
        for (float** one : {&problem.x_re, &problem.x_im}) *one = take(problem.stride);
        problem.normal = take(problem.most_foci * problem.most_foci);
        for (float** one : {&problem.p_re, &problem.p_im, &problem.size, &problem.c_re, &problem.c_im, &problem.weight,
                            &problem.step})
            *one = take(problem.most_foci);
        ticks = hwy::AllocateAligned<std::int32_t>(problem.stride);
        prepare_waves();
    }

    void prepare_waves() {
        for (const Element& element : array.elements)
            if (element.normal != Vec3{0.0, 0.0, 1.0}) return;  // rows by propagation() instead
        const double k = 2.0 * std::numbers::pi / array.wavelength_m();
        model = {static_cast<float>(2.0 / array.wavelength_m()), static_cast<float>(array.medium.absorption_np_m),
                 fit_pattern(array.transducer, k), false};
        for (std::size_t first = 0; first < array.elements.size(); first += WaveBlock::most) {
            const std::size_t count = std::min(WaveBlock::most, array.elements.size() - first);
            std::vector<double> x, y, z;
            Vec3 centre{};
            for (std::size_t m = first; m < first + count; ++m) {
                const Vec3& p = array.elements[m].position;
                x.push_back(p.x);
                y.push_back(p.y);
                z.push_back(-p.z);
                centre = centre + Vec3{p.x, p.y, -p.z} * (1.0 / static_cast<double>(count));
            }
            blocks.push_back(std::make_unique<WaveBlock>());
            centre_block(x.data(), y.data(), z.data(), count, centre, *blocks.back());
            centres.push_back(centre);
            double radius = 0.0;
            for (std::size_t i = 0; i < count; ++i) radius = std::max(radius, distance(centre, Vec3{x[i], y[i], z[i]}));
            radii.push_back(radius);
        }
    }

    void check(std::span<const Focus> foci) const {
        if (foci.empty()) throw bad_argument("foci", "there is none; expected at least one");
        if (foci.size() > std::min(problem.most_foci, array.elements.size()))
            throw bad_argument("foci", fmt::format("{} foci; this solver was made for at most {}", foci.size(),
                                                   std::min(problem.most_foci, array.elements.size())));
        const double same_place_m = 1e-3 * array.wavelength_m();
        for (std::size_t i = 0; i < foci.size(); ++i) {
            if (!is_finite(foci[i].position))
                throw bad_focus(i, "a coordinate is not finite; every coordinate must be a number");
            if (!(foci[i].amplitude > 0.0 && foci[i].amplitude <= 1.0))
                throw bad_focus(i, fmt::format("an amplitude of {}; expected above 0, up to 1", foci[i].amplitude));
            for (std::size_t j = 0; j < i; ++j) {
                const Vec3 apart = foci[i].position - foci[j].position;
                if (dot(apart, apart) < same_place_m * same_place_m)
                    throw bad_focus(i, fmt::format("it is where focus {} is; leave one of them out", j + 1));
            }
        }
    }

    void compute_row(const Vec3& focus, float* re, float* im) const {
        if (blocks.empty()) {
            for (std::size_t m = 0; m < array.elements.size(); ++m) {
                const std::complex<double> a = propagation(array, array.elements[m], focus);
                re[m] = static_cast<float>(a.real());
                im[m] = static_cast<float>(a.imag());
            }
            return;
        }
        std::size_t first = 0;
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            const Vec3 from = Vec3{focus.x, focus.y, -focus.z} - centres[b];
            const double range = norm(from), half_turns = range * 2.0 / array.wavelength_m();
            const WaveElement source{static_cast<float>(from.x),
                                     static_cast<float>(from.y),
                                     static_cast<float>(from.z),
                                     static_cast<float>(range),
                                     static_cast<float>(half_turns - 2.0 * std::nearbyint(0.5 * half_turns)),
                                     1.0F,
                                     0.0F,
                                     0.0F,
                                     1.0F,
                                     static_cast<float>(range * range)};
            blocks[b]->far = range - radii[b] >= range / 3.0;
            sum_waves(model, *blocks[b], {&source, 1}, re + first, im + first);
            first += blocks[b]->count;
        }
        for (std::size_t m = 0; m < array.elements.size(); ++m) {
            if (array.elements[m].response == 1.0) continue;
            const std::complex<float> wave =
                std::complex<float>(re[m], im[m]) * std::complex<float>(array.elements[m].response);
            re[m] = wave.real();
            im[m] = wave.imag();
        }
        // The sums go on to whole vectors, with points that are no elements.
        std::fill(re + first, re + problem.stride, 0.0F);
        std::fill(im + first, im + problem.stride, 0.0F);
    }

    void compute_rows(std::span<const Focus> foci) {
        for (std::size_t k = 0; k < foci.size(); ++k) {
            float *re = problem.a_re + k * problem.stride, *im = problem.a_im + k * problem.stride;
            compute_row(foci[k].position, re, im);
            const float reach = HWY_DYNAMIC_DISPATCH(sum_of_sizes)(re, im, problem.stride);
            if (!std::isfinite(reach)) throw bad_focus(k, "it coincides with an element; move it");
            if (reach == 0.0F) throw bad_focus(k, "it cannot be reached by any element: it is behind all of them");
            float target = static_cast<float>(foci[k].amplitude);
            if (options.level == Level::reachable) target *= reach;
            HWY_DYNAMIC_DISPATCH(scale_row)(re, im, problem.stride, 1.0F / target);
            problem.step[k] = target;
        }
        problem.foci = foci.size();
        // In whole vectors, zeros beyond the foci are no foci.
        for (float* row : {problem.p_re, problem.p_im, problem.c_re, problem.c_im})
            std::fill(row + problem.foci, row + problem.most_foci, 0.0F);
    }

    /// Weights of mean 1, which would drift otherwise.
    void level_weights() {
        float sum = 0.0F;
        for (std::size_t k = 0; k < problem.foci; ++k) sum += problem.weight[k];
        for (std::size_t k = 0; k < problem.foci; ++k) problem.weight[k] *= static_cast<float>(problem.foci) / sum;
        std::fill(problem.weight + problem.foci, problem.weight + problem.most_foci, 0.0F);
    }
};

FastSolver::FastSolver(const Array& array, std::size_t most_foci, const Options& options)
    : state_(std::make_unique<State>(array, most_foci, options)) {}
FastSolver::~FastSolver() = default;
FastSolver::FastSolver(FastSolver&&) noexcept = default;
FastSolver& FastSolver::operator=(FastSolver&&) noexcept = default;

void FastSolver::solve(std::span<const Focus> foci) {
    State& s = *state_;
    s.check(foci);
    s.last_foci = 0;  // until it has worked
    s.compute_rows(foci);
    FociProblem& q = s.problem;
    for (std::size_t k = 0; k < q.foci; ++k) q.weight[k] = q.step[k] * q.step[k];
    s.level_weights();
    std::copy_n(q.weight, q.foci, q.c_re);
    std::fill_n(q.c_im, q.foci, 0.0F);
    HWY_DYNAMIC_DISPATCH(improve)(q, s.options.rounds, false);
    s.last_foci = foci.size();
}

void FastSolver::follow(std::span<const Focus> foci) {
    State& s = *state_;
    if (foci.size() != s.last_foci)
        throw bad_argument(
            "foci", fmt::format("{} foci follow {}; solve() begins with another number", foci.size(), s.last_foci));
    s.check(foci);
    s.last_foci = 0;
    s.compute_rows(foci);
    s.level_weights();
    HWY_DYNAMIC_DISPATCH(improve)(s.problem, s.options.rounds_to_follow, true);
    s.last_foci = foci.size();
}

std::vector<std::complex<double>> FastSolver::drives() const {
    std::vector<std::complex<double>> drives;
    for (std::size_t m = 0; m < state_->array.elements.size(); ++m)
        drives.emplace_back(state_->problem.x_re[m], state_->problem.x_im[m]);
    return drives;
}

void FastSolver::ticks(const Timer& timer, std::span<std::uint16_t> ticks) const {
    const std::size_t elements = state_->array.elements.size();
    if (ticks.size() != elements)
        throw bad_argument("ticks", fmt::format("room for {}, expected {}: one an element", ticks.size(), elements));
    state_->array.require_one_weight();
    HWY_DYNAMIC_DISPATCH(ticks_of_drives)(state_->problem, static_cast<float>(timer.cycle_ticks), state_->ticks.get());
    for (std::size_t m = 0; m < elements; ++m)
        ticks[m] = state_->array.elements[m].response == 0.0 ? interface::silent_timing
                                                             : static_cast<std::uint16_t>(state_->ticks[m]);
}

const char* fast_solver_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace haptogram
#endif
