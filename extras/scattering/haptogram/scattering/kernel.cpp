// SPDX-License-Identifier: Apache-2.0
// Highway compiles this file once for each instruction set, and picks one when the program runs.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/scattering/kernel.cpp"
#include "haptogram/scattering/kernel.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <numbers>
// This header must come after highway.h.
#include "haptogram/acoustics/turn-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptogram::scattering::HWY_NAMESPACE {
using namespace haptogram::HWY_NAMESPACE;

/// One kernel a lane, from the vector R from the source to the point.
class KernelLanes {
public:
    explicit KernelLanes(const Kernel& kernel)
        : k_(static_cast<float>(kernel.wave_number)),
          half_turns_(static_cast<float>(kernel.wave_number / std::numbers::pi)),
          coupling_(static_cast<float>(kernel.coupling_m)) {}

    /// With r = |R|, u = 1/r² and q = k/r the kernels are e^{−jkr}/(4πr) times (u + jq)·(R·n_y), and times
    /// (u + jq)·(n_x·n_y) − (R·n_x)(R·n_y)·u·(3u + 3jq − k²).
    /// @param weight  over 4π
    HWY_INLINE void operator()(V dx, V dy, V dz, V along_source, V along_point, V normals, V weight, V& re,
                               V& im) const {
        const D d;
        const V square = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
        const auto apart = hn::Gt(square, hn::Set(d, 1e-16F));  // 10 nm
        const V inverse = inverse_root(hn::IfThenElse(apart, square, hn::Set(d, 1.0F)));
        const V u = hn::Mul(inverse, inverse), q = hn::Mul(hn::Set(d, k_), inverse);
        const V c = hn::Mul(hn::Set(d, coupling_), normals);
        const V e = hn::Mul(hn::Mul(hn::Set(d, coupling_), hn::Mul(along_source, along_point)), u);
        const V three = hn::Set(d, 3.0F);
        const V even = hn::NegMulAdd(hn::Mul(three, e), q, hn::MulAdd(along_source, u, hn::Mul(c, q)));
        const V rest = hn::MulSub(three, u, hn::Set(d, k_ * k_));
        const V odd = hn::MulAdd(e, rest, hn::NegMulAdd(c, u, hn::Mul(along_source, q)));
        const Polar<V> wave =
            turn(hn::Mul(weight, inverse), hn::Mul(hn::Mul(square, inverse), hn::Set(d, half_turns_)));  // cos − j·sin
        const V amplitude = hn::IfThenElseZero(apart, wave.amplitude);
        re = hn::Mul(amplitude, hn::MulAdd(even, wave.cosine, hn::Mul(odd, wave.sine)));
        im = hn::Mul(amplitude, hn::NegMulAdd(even, wave.sine, hn::Mul(odd, wave.cosine)));
    }

private:
    float k_, half_turns_, coupling_;
};

HWY_INLINE V dot_of(V ax, V ay, V az, V bx, V by, V bz) {
    return hn::MulAdd(ax, bx, hn::MulAdd(ay, by, hn::Mul(az, bz)));
}

void kernel_column_to(const Kernel& kernel, const KernelPoints& points, Vec3 source, Vec3 normal, double weight,
                      float* column) {
    const D d;
    const KernelLanes lanes(kernel);
    const auto all = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
    const V sx = all(source.x), sy = all(source.y), sz = all(source.z);
    const V mx = all(normal.x), my = all(normal.y), mz = all(normal.z);
    const V share = all(-weight / (4.0 * std::numbers::pi));
    for (std::size_t i = 0; i < points.x.size(); i += hn::Lanes(d)) {
        const V nx = hn::LoadU(d, &points.nx[i]), ny = hn::LoadU(d, &points.ny[i]), nz = hn::LoadU(d, &points.nz[i]);
        const V dx = hn::Sub(hn::LoadU(d, &points.x[i]), sx), dy = hn::Sub(hn::LoadU(d, &points.y[i]), sy),
                dz = hn::Sub(hn::LoadU(d, &points.z[i]), sz);
        V re, im;
        lanes(dx, dy, dz, dot_of(dx, dy, dz, mx, my, mz), dot_of(dx, dy, dz, nx, ny, nz),
              dot_of(mx, my, mz, nx, ny, nz), share, re, im);
        hn::StoreInterleaved2(re, im, d, column + 2 * i);
    }
}

void kernel_sum_to(const Kernel& kernel, const KernelPoints& sources, Vec3 point, Vec3 normal, double* found) {
    const D d;
    const KernelLanes lanes(kernel);
    const auto all = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
    const V px = all(point.x), py = all(point.y), pz = all(point.z);
    const V nx = all(normal.x), ny = all(normal.y), nz = all(normal.z);
    const V share = all(1.0 / (4.0 * std::numbers::pi));
    V sum_re = hn::Zero(d), sum_im = hn::Zero(d);
    for (std::size_t i = 0; i < sources.x.size(); i += hn::Lanes(d)) {
        const V mx = hn::LoadU(d, &sources.nx[i]), my = hn::LoadU(d, &sources.ny[i]), mz = hn::LoadU(d, &sources.nz[i]);
        const V dx = hn::Sub(px, hn::LoadU(d, &sources.x[i])), dy = hn::Sub(py, hn::LoadU(d, &sources.y[i])),
                dz = hn::Sub(pz, hn::LoadU(d, &sources.z[i]));
        V re, im;
        lanes(dx, dy, dz, dot_of(dx, dy, dz, mx, my, mz), dot_of(dx, dy, dz, nx, ny, nz),
              dot_of(mx, my, mz, nx, ny, nz), hn::Mul(share, hn::LoadU(d, &sources.weight[i])), re, im);
        sum_re = hn::Add(sum_re, re);
        sum_im = hn::Add(sum_im, im);
    }
    found[0] = static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum_re)));
    found[1] = static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum_im)));
}

}  // namespace haptogram::scattering::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace haptogram::scattering {

HWY_EXPORT(kernel_column_to);
HWY_EXPORT(kernel_sum_to);

void KernelPoints::clear() {
    for (std::vector<float>* row : {&x, &y, &z, &nx, &ny, &nz, &weight}) row->clear();
}

void KernelPoints::add(Vec3 point, Vec3 normal, double point_weight) {
    const double values[] = {point.x, point.y, point.z, normal.x, normal.y, normal.z, point_weight};
    const double* value = values;
    for (std::vector<float>* row : {&x, &y, &z, &nx, &ny, &nz, &weight}) row->push_back(static_cast<float>(*value++));
}

void KernelPoints::pad() {
    while (x.size() < padded(x.size())) {
        for (std::vector<float>* row : {&x, &y, &z, &nx, &ny, &nz}) row->push_back(row->back());
        weight.push_back(0.0F);
    }
}

void kernel_column(const Kernel& kernel, const KernelPoints& points, Vec3 source, Vec3 normal, double weight,
                   std::complex<float>* column) {
    HWY_DYNAMIC_DISPATCH(kernel_column_to)
    (kernel, points, source, normal, weight, reinterpret_cast<float*>(column));
}

std::complex<float> kernel_sum(const Kernel& kernel, const KernelPoints& sources, Vec3 point, Vec3 normal) {
    double found[2];
    HWY_DYNAMIC_DISPATCH(kernel_sum_to)(kernel, sources, point, normal, found);
    return {static_cast<float>(found[0]), static_cast<float>(found[1])};
}

}  // namespace haptogram::scattering
#endif
