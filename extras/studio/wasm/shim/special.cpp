// SPDX-License-Identifier: Apache-2.0
// Special functions of C++17, which libc++ does not have.
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/ellint_2.hpp>
#include <boost/math/special_functions/legendre.hpp>

namespace std {

double cyl_bessel_j(double order, double x) { return boost::math::cyl_bessel_j(order, x); }
double ellint_2(double k, double phi) { return boost::math::ellint_2(k, phi); }
double comp_ellint_2(double k) { return boost::math::ellint_2(k); }
double legendre(unsigned degree, double x) { return boost::math::legendre_p(static_cast<int>(degree), x); }

}  // namespace std
