// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set by Highway, chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptogram/solve/even.cpp"
#include "haptogram/solve/even.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptogram::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One row of |p|²: the field of every focus at one point.
/// @param propagation_re, propagation_im  from each element to the point
/// @param drives_re, drives_im            of each element, a row an element, a column a focus
/// @param foci                            a multiple of two of the widest vectors
void squares_at(const float* propagation_re, const float* propagation_im, const float* drives_re,
                const float* drives_im, std::size_t elements, std::size_t foci, float* squares) {
    const hn::ScalableTag<float> d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t j = 0; j < foci; j += 2 * lanes) {
        auto re = hn::Zero(d), im = hn::Zero(d), re2 = hn::Zero(d), im2 = hn::Zero(d);
        for (std::size_t m = 0; m < elements; ++m) {
            // Multiply and add apart, never fused: the result must not depend on the processor.
            const auto hr = hn::Set(d, propagation_re[m]), hi = hn::Set(d, propagation_im[m]);
            const float* const at_re = drives_re + m * foci + j;
            const float* const at_im = drives_im + m * foci + j;
            const auto dr = hn::LoadU(d, at_re), di = hn::LoadU(d, at_im);
            const auto dr2 = hn::LoadU(d, at_re + lanes), di2 = hn::LoadU(d, at_im + lanes);
            re = hn::Add(re, hn::Sub(hn::Mul(hr, dr), hn::Mul(hi, di)));
            im = hn::Add(im, hn::Add(hn::Mul(hi, dr), hn::Mul(hr, di)));
            re2 = hn::Add(re2, hn::Sub(hn::Mul(hr, dr2), hn::Mul(hi, di2)));
            im2 = hn::Add(im2, hn::Add(hn::Mul(hi, dr2), hn::Mul(hr, di2)));
        }
        hn::StoreU(hn::Add(hn::Mul(re, re), hn::Mul(im, im)), d, squares + j);
        hn::StoreU(hn::Add(hn::Mul(re2, re2), hn::Mul(im2, im2)), d, squares + j + lanes);
    }
}

/// Σ weight·row over the rows of a matrix. Each column is added up in the same order, whatever the vectors' width.
void sum_of_rows(const float* matrix, const float* weights, std::size_t rows, std::size_t columns, float* sums) {
    const hn::ScalableTag<float> d;
    const std::size_t lanes = hn::Lanes(d);
    constexpr std::size_t tile = 4;
    for (std::size_t c = 0; c < columns; c += tile * lanes) {
        auto a = hn::Zero(d), b = hn::Zero(d), e = hn::Zero(d), f = hn::Zero(d);
        for (std::size_t r = 0; r < rows; ++r) {
            const auto weight = hn::Set(d, weights[r]);
            const float* at = matrix + r * columns + c;
            a = hn::Add(a, hn::Mul(weight, hn::LoadU(d, at)));
            b = hn::Add(b, hn::Mul(weight, hn::LoadU(d, at + lanes)));
            e = hn::Add(e, hn::Mul(weight, hn::LoadU(d, at + 2 * lanes)));
            f = hn::Add(f, hn::Mul(weight, hn::LoadU(d, at + 3 * lanes)));
        }
        hn::StoreU(a, d, sums + c);
        hn::StoreU(b, d, sums + c + lanes);
        hn::StoreU(e, d, sums + c + 2 * lanes);
        hn::StoreU(f, d, sums + c + 3 * lanes);
    }
}

}  // namespace haptogram::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

HWY_EXPORT(squares_at);
HWY_EXPORT(sum_of_rows);

/// Columns are padded to four of the widest vectors of any processor.
constexpr std::size_t padding = 256;

/// A transducer's directivity at any cosine. That of a piston comes from the polynomial of the fast fields, because its
/// Bessel function would take longer than everything else.
class FastDirectivity {
public:
    FastDirectivity(const Transducer& transducer, double k)
        : transducer_(transducer), k_(k), fitted_(fit_pattern(transducer, k)) {}
    double operator()(double cosine) const {
        if (fitted_.kind != FittedPattern::Kind::polynomial) return directivity(transducer_, k_, cosine);
        const double u = 2.0 * cosine * cosine - 1.0;
        double sum = 0.0;
        for (std::size_t i = fitted_.values.size(); i-- > 0;) sum = sum * u + static_cast<double>(fitted_.values[i]);
        return sum;
    }

private:
    const Transducer& transducer_;
    double k_;
    FittedPattern fitted_;
};

/// Raises what is below its floor, and lowers the rest in proportion, so that the sum stays.
void keep_floors(std::vector<double>& shares, std::span<const double> floors, double sum) {
    std::vector<bool> held(shares.size());
    for (bool again = true; again;) {
        again = false;
        double free = 0.0, left = sum;
        for (std::size_t j = 0; j < shares.size(); ++j) {
            if (held[j])
                left -= floors[j];
            else
                free += shares[j];
        }
        for (std::size_t j = 0; j < shares.size(); ++j) {
            shares[j] = held[j] ? floors[j] : free > 0.0 ? shares[j] * left / free : 0.0;
            if (held[j] || shares[j] >= floors[j]) continue;
            held[j] = again = true;
        }
    }
}

}  // namespace

CrossTalk::CrossTalk(const Array& array, std::span<const Vec3> points)
    : count_(points.size()), padded_((points.size() + padding - 1) / padding * padding) {
    if (count_ > most_points)
        throw bad_input(
            "even",
            fmt::format("{} points; at most {} can be made to feel even; take fewer points", count_, most_points),
            {"points"});
    const std::size_t elements = array.elements.size();
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    const FastDirectivity directivity(array.transducer, k);
    // A wave is amplitude·e^{−jkR}, and the drive that focuses on its point e^{+jkR}: one sine and cosine make both.
    // The drive takes the phase of the element's response away, so that of the response its gain stays.
    std::vector<float> drives_re(elements * padded_), drives_im(elements * padded_), amplitudes(count_ * elements);
    for (std::size_t j = 0; j < count_; ++j) {
        for (std::size_t m = 0; m < elements; ++m) {
            const Vec3 ray = points[j] - array.elements[m].position;
            const double range = norm(ray);
            if (range == 0.0) throw coincidence();
            drives_re[m * padded_ + j] = static_cast<float>(std::cos(k * range));
            drives_im[m * padded_ + j] = static_cast<float>(std::sin(k * range));
            amplitudes[j * elements + m] =
                static_cast<float>(std::abs(array.elements[m].response * array.elements[m].aligning()) *
                                   directivity(dot(ray, array.elements[m].normal) / range) / range *
                                   std::exp(-array.medium.absorption_np_m * range));
        }
    }
    at_points_.resize(count_ * padded_);
    of_foci_.resize(count_ * padded_);
    std::vector<float> re(elements), im(elements);
    for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t m = 0; m < elements; ++m) {
            re[m] = amplitudes[i * elements + m] * drives_re[m * padded_ + i];
            im[m] = -amplitudes[i * elements + m] * drives_im[m * padded_ + i];
        }
        if (std::all_of(re.begin(), re.end(), [](float one) { return one == 0.0F; }) &&
            std::all_of(im.begin(), im.end(), [](float one) { return one == 0.0F; }))
            throw bad_input(
                "even",
                fmt::format("point {} cannot be reached by any element: it is behind all of them; move it", i + 1));
        HWY_DYNAMIC_DISPATCH(squares_at)
        (re.data(), im.data(), drives_re.data(), drives_im.data(), elements, padded_, at_points_.data() + i * padded_);
    }
    const float largest = at_points_.empty() ? 0.0F : *std::max_element(at_points_.begin(), at_points_.end());
    for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t j = 0; j < padded_; ++j) {
            float& square = at_points_[i * padded_ + j];
            square = j < count_ && largest > 0.0F ? square / largest : 0.0F;
            if (j < count_) of_foci_[j * padded_ + i] = square;
        }
    }
    scale_ = largest * array.transducer.source_pa_m * array.transducer.source_pa_m;
}

std::vector<double> CrossTalk::felt(std::span<const double> shares) const {
    const std::vector<float> weights(shares.begin(), shares.end());
    std::vector<float> sums(padded_);
    HWY_DYNAMIC_DISPATCH(sum_of_rows)(of_foci_.data(), weights.data(), count_, padded_, sums.data());
    std::vector<double> result;
    for (std::size_t i = 0; i < count_; ++i) result.push_back(scale_ * static_cast<double>(sums[i]));
    return result;
}

Evenness CrossTalk::evenness(std::span<const double> shares) const {
    const std::vector<double> values = felt(shares);
    if (values.empty()) return {};
    const auto count = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return {std::sqrt(squares / count) / mean, *std::min_element(values.begin(), values.end())};
}

std::vector<double> CrossTalk::even_shares(std::span<const double> shares, std::span<const double> floors,
                                           std::size_t rounds) const {
    const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
    const std::vector<float> ones(count_, 1.0F);
    std::vector<float> columns(padded_), felt(padded_), pull(padded_), now(count_);
    HWY_DYNAMIC_DISPATCH(sum_of_rows)(at_points_.data(), ones.data(), count_, padded_, columns.data());
    std::vector<double> result(shares.begin(), shares.end());
    for (std::size_t round = 0; round < rounds; ++round) {
        for (std::size_t j = 0; j < count_; ++j) now[j] = static_cast<float>(result[j] / sum);
        HWY_DYNAMIC_DISPATCH(sum_of_rows)(of_foci_.data(), now.data(), count_, padded_, felt.data());
        for (std::size_t i = 0; i < count_; ++i) felt[i] = 1.0F / felt[i];
        HWY_DYNAMIC_DISPATCH(sum_of_rows)(at_points_.data(), felt.data(), count_, padded_, pull.data());
        for (std::size_t j = 0; j < count_; ++j) result[j] *= static_cast<double>(pull[j] / columns[j]);
        keep_floors(result, floors, sum);
    }
    return result;
}

}  // namespace haptogram
#endif
