// SPDX-License-Identifier: Apache-2.0
// Sines and cosines, as good as rounded correctly, in the place of those of Emscripten's C library, whose last digit is
// often another than that of Debian's. Where two ways of a tour are equally long that digit decides, and images would
// differ. The argument less multiples of π/2 and the first terms of the series are sums of two doubles; what is large,
// or next to a multiple, is computed in 128 bits, which takes microseconds.
#include <cmath>

namespace {

struct Sum {
    double high, low;
};

Sum plus(double a, double b) {
    const double high = a + b, part = high - a;
    return {high, (a - (high - part)) + (b - part)};
}

/// a · b, by Dekker's halves.
Sum times(double a, double b) {
    constexpr double half = 134217729.0;  // 2^27 + 1
    const double high = a * b;
    const double a_high = a * half - (a * half - a), b_high = b * half - (b * half - b);
    const double a_low = a - a_high, b_low = b - b_high;
    return {high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

Sum plus(Sum a, Sum b) {
    const Sum high = plus(a.high, b.high);
    return plus(high.high, high.low + a.low + b.low);
}

Sum times(Sum a, Sum b) {
    const Sum high = times(a.high, b.high);
    return plus(high.high, high.low + (a.high * b.low + a.low * b.high));
}

constexpr Sum sixth = {-0x1.5555555555555p-3, -0x1.5555555555555p-57};    // −1/3!
constexpr Sum per_120 = {0x1.1111111111111p-7, 0x1.1111111111111p-63};    // 1/5!
constexpr Sum per_24 = {0x1.5555555555555p-5, 0x1.5555555555555p-59};     // 1/4!
constexpr Sum per_720 = {-0x1.6c16c16c16c17p-10, 0x1.f49f49f49f49fp-65};  // −1/6!

/// |r| ≤ π/4
double sine(Sum r) {
    const Sum z = times(r, r);
    const double s = z.high;
    const double rest =
        s * (-1.0 / 5040 +
             s * (1.0 / 362880 + s * (-1.0 / 39916800 + s * (1.0 / 6227020800.0 +
                                                             s * (-1.0 / 1307674368000.0 + s / 355687428096000.0)))));
    const Sum factor = times(z, plus(sixth, times(z, plus(per_120, Sum{rest, 0.0}))));
    const Sum value = plus(r, times(r, factor));
    return value.high + value.low;
}

double cosine(Sum r) {
    const Sum z = times(r, r);
    const double s = z.high;
    const double rest =
        s * (1.0 / 40320 +
             s * (-1.0 / 3628800 + s * (1.0 / 479001600 + s * (-1.0 / 87178291200.0 + s * (1.0 / 20922789888000.0 -
                                                                                           s / 6402373705728000.0)))));
    const Sum inner = plus(per_24, times(z, plus(per_720, Sum{rest, 0.0})));
    const Sum value = plus(Sum{1.0, 0.0}, times(z, plus(Sum{-0.5, 0.0}, times(z, inner))));
    return value.high + value.low;
}

/// sin(x + turns · π/2)
double turned(double x, int turns) {
    const double n = std::nearbyint(x * 0x1.45f306dc9c883p-1);  // 2/π
    // π/2 in parts of 33 bits, so that n times the first two is exact.
    const double near = x - n * 0x1.921fb544p+0;
    const Sum first = plus(near, -(n * 0x1.0b4611a6p-34));
    const Sum r = plus(first.high, first.low - n * 0x1.3198a2e037073p-69);
    if (!(std::fabs(n) < 0x1p19) || (n != 0.0 && std::fabs(r.high) < 0x1p-20))
        return static_cast<double>(turns == 0 ? sinl(x) : cosl(x));
    switch ((static_cast<int>(n) + turns) & 3) {
        case 0: return sine(r);
        case 1: return cosine(r);
        case 2: return -sine(r);
        default: return -cosine(r);
    }
}

}  // namespace

extern "C" double sin(double x) { return turned(x, 0); }
extern "C" double cos(double x) { return turned(x, 1); }
