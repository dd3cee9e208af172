// SPDX-License-Identifier: Apache-2.0
// Sines and cosines, rounded correctly, in the place of those of Emscripten's C library, whose last digit is often
// another than that of Debian's. Where two ways of a tour are equally long that digit decides, and images would differ.
// They are computed in 128 bits, which takes microseconds, so what was asked for last is kept: shapes ask again and
// again for the angles of one circle.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace {

struct Known {
    std::uint64_t asked = ~std::uint64_t{0};  // a NaN's bits, which are computed anew
    double value = 0.0;
};
constexpr std::size_t most_known = 4096;

template <long double (*Function)(long double)>
double of(double x) {
    static Known known[most_known];
    std::uint64_t bits = 0;
    std::memcpy(&bits, &x, sizeof bits);
    Known& place = known[(bits * 0x9e3779b97f4a7c15U) >> 52U];
    if (place.asked != bits) place = {bits, static_cast<double>(Function(x))};
    return place.value;
}

}  // namespace

extern "C" double sin(double x) { return of<sinl>(x); }
extern "C" double cos(double x) { return of<cosl>(x); }
