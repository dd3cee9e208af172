// SPDX-License-Identifier: Apache-2.0
// Highway compiles this file once for each instruction set, and picks one when the program runs; wave.cpp says more.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/acoustics/interpolate.cpp"
#include "haptogram/acoustics/interpolate.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

/// Along z: one row of the coarse grid in the wanted plane.
void along_z(const CoarseGrid& grid, const std::complex<float>* coarse, std::size_t plane, std::size_t row, float* re,
             float* im) {
    const D d;
    const std::size_t columns = grid.x.coarse.size(), rows = grid.y.coarse.size();
    const auto first = static_cast<std::size_t>(grid.z.first[plane]);
    for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
        V sum_re = hn::Zero(d), sum_im = hn::Zero(d);
        for (std::size_t t = 0; t < grid.z.taps; ++t) {
            const std::complex<float>* from = coarse + ((first + t) * rows + row) * columns + i;
            const V a = hn::Set(d, grid.z.re[t * grid.z.stride + plane]);
            const V b = hn::Set(d, grid.z.im[t * grid.z.stride + plane]);
            V f_re, f_im;
            hn::LoadInterleaved2(d, reinterpret_cast<const float*>(from), f_re, f_im);
            sum_re = hn::NegMulAdd(b, f_im, hn::MulAdd(a, f_re, sum_re));
            sum_im = hn::MulAdd(b, f_re, hn::MulAdd(a, f_im, sum_im));
        }
        hn::StoreU(sum_re, d, re + i);
        hn::StoreU(sum_im, d, im + i);
    }
}

/// Along x: a row of wanted points from a row of coarse ones. A vector of neighbouring points needs, for each tap,
/// coarse values that lie within one vector, because a coarse step is wider than a step of the wanted points.
template <std::size_t taps>
void along_x(const CoarseAxis& axis, const float* re, const float* im, float* to_re, float* to_im) {
    const D d;
    const hn::RebindToSigned<D> di;
    for (std::size_t i = 0; i < axis.size; i += hn::Lanes(d)) {
        const std::int32_t begin = axis.first[i];
        const auto lanes = hn::IndicesFromVec(d, hn::Sub(hn::LoadU(di, &axis.first[i]), hn::Set(di, begin)));
        V sum_re = hn::Zero(d), sum_im = hn::Zero(d);
        for (std::size_t t = 0; t < taps; ++t) {
            const V weight = hn::LoadU(d, &axis.re[t * axis.stride + i]);
            const V f_re = hn::TableLookupLanes(hn::LoadU(d, re + begin + t), lanes);
            const V f_im = hn::TableLookupLanes(hn::LoadU(d, im + begin + t), lanes);
            sum_re = hn::MulAdd(weight, f_re, sum_re);
            sum_im = hn::MulAdd(weight, f_im, sum_im);
        }
        hn::StoreU(sum_re, d, to_re + i);
        hn::StoreU(sum_im, d, to_im + i);
    }
}

/// Along y: a row of wanted points from rows at the same x, two vectors at a time so that each weight is loaded once.
template <std::size_t taps>
void along_y(const CoarseAxis& axis, std::size_t row, const float* re, const float* im, std::size_t stride,
             std::size_t points, float* out) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = 0; i < points; i += 2 * lanes) {
        V re_0 = hn::Zero(d), im_0 = re_0, re_1 = re_0, im_1 = re_0;
        for (std::size_t t = 0; t < taps; ++t) {
            const V weight = hn::Set(d, axis.re[t * axis.stride + row]);
            const float* from_re = re + t * stride + i;
            const float* from_im = im + t * stride + i;
            re_0 = hn::MulAdd(weight, hn::Load(d, from_re), re_0);
            im_0 = hn::MulAdd(weight, hn::Load(d, from_im), im_0);
            re_1 = hn::MulAdd(weight, hn::Load(d, from_re + lanes), re_1);
            im_1 = hn::MulAdd(weight, hn::Load(d, from_im + lanes), im_1);
        }
        if (i + 2 * lanes <= points) {
            hn::StoreInterleaved2(re_0, im_0, d, out + 2 * i);
            hn::StoreInterleaved2(re_1, im_1, d, out + 2 * (i + lanes));
        } else {
            HWY_ALIGN float tile[4 * HWY_MAX_BYTES / sizeof(float)];
            hn::StoreInterleaved2(re_0, im_0, d, tile);
            hn::StoreInterleaved2(re_1, im_1, d, tile + 2 * lanes);
            std::copy_n(tile, 2 * (points - i), out + 2 * i);
        }
    }
}

std::size_t up_to_lanes(std::size_t count) {
    const std::size_t two = 2 * hn::Lanes(D());
    return (count + two - 1) / two * two;
}

std::size_t scratch_for(const CoarseGrid& grid, std::size_t rows) {
    // A wanted row lies less than a coarse step behind the one before it.
    const std::size_t coarse_rows = std::min(grid.y.coarse.size(), rows + grid.y.taps);
    return 2 * (up_to_lanes(grid.x.coarse.size()) + up_to_lanes(1)) + 2 * coarse_rows * up_to_lanes(grid.x.size);
}

void interpolate_rows_to(const CoarseGrid& grid, const std::complex<float>* coarse, std::size_t plane,
                         std::size_t begin, std::size_t end, float* scratch, std::complex<float>* out) {
    const std::size_t stride = up_to_lanes(grid.x.size), in = up_to_lanes(grid.x.coarse.size()) + up_to_lanes(1);
    const auto first = static_cast<std::size_t>(grid.y.first[begin]);
    const std::size_t count = static_cast<std::size_t>(grid.y.first[end - 1]) + grid.y.taps - first;
    float *row_re = scratch, *row_im = row_re + in, *re = row_im + in, *im = re + count * stride;
    for (std::size_t j = 0; j < count; ++j) {
        along_z(grid, coarse, plane, first + j, row_re, row_im);
        if (grid.x.kept())
            along_x<1>(grid.x, row_re, row_im, re + j * stride, im + j * stride);
        else
            along_x<interpolation_taps>(grid.x, row_re, row_im, re + j * stride, im + j * stride);
    }
    for (std::size_t row = begin; row < end; ++row) {
        const std::size_t at = (static_cast<std::size_t>(grid.y.first[row]) - first) * stride;
        float* to = reinterpret_cast<float*>(out + (row - begin) * grid.x.size);
        if (grid.y.kept())
            along_y<1>(grid.y, row, re + at, im + at, stride, grid.x.size, to);
        else
            along_y<interpolation_taps>(grid.y, row, re + at, im + at, stride, grid.x.size, to);
    }
}

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace haptogram {

HWY_EXPORT(interpolate_rows_to);
HWY_EXPORT(scratch_for);

void interpolate_rows(const CoarseGrid& grid, const std::complex<float>* coarse, std::size_t plane, std::size_t begin,
                      std::size_t end, float* scratch, std::complex<float>* out) {
    HWY_DYNAMIC_DISPATCH(interpolate_rows_to)(grid, coarse, plane, begin, end, scratch, out);
}

std::size_t scratch_of_interpolation(const CoarseGrid& grid, std::size_t rows) {
    return HWY_DYNAMIC_DISPATCH(scratch_for)(grid, rows);
}

}  // namespace haptogram
#endif
