// SPDX-License-Identifier: Apache-2.0
// What Debian's Emscripten, whose C++ library is of 2021, lacks of C++17 and C++20: as much as the sources use, with
// the standard's names and meaning. It is included before every source.
#pragma once
#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <string>
#include <system_error>

namespace std {

/// In the C locale, which is the only one here.
inline from_chars_result from_chars(const char* begin, const char* end, double& value,
                                    chars_format = chars_format::general) {
    if (begin == end || *begin == '+' || *begin == ' ' || *begin == '\t') return {begin, errc::invalid_argument};
    const string text(begin, end);
    char* stop = nullptr;
    const double found = strtod(text.c_str(), &stop);
    if (stop == text.c_str()) return {begin, errc::invalid_argument};
    value = found;
    return {begin + (stop - text.c_str()), errc{}};
}

// By Boost, in special.cpp.
double cyl_bessel_j(double order, double x);
double ellint_2(double k, double phi);
double comp_ellint_2(double k);
double legendre(unsigned degree, double x);

#ifndef __cpp_lib_bit_cast
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
    return __builtin_bit_cast(To, from);
}
#endif

namespace ranges {

template <class Compare, class Projection>
auto by(Compare compare, Projection projection) {
    return [=](const auto& a, const auto& b) { return invoke(compare, invoke(projection, a), invoke(projection, b)); };
}

template <class Range, class Value, class Projection = std::identity>
auto find(Range&& range, const Value& value, Projection projection = {}) {
    return std::find_if(std::begin(range), std::end(range),
                        [&](const auto& each) { return invoke(projection, each) == value; });
}
/// A function, or a member that is a flag, as the algorithms of before take it.
template <class Is>
auto asked(const Is& is) {
    return [&is](const auto& each) { return static_cast<bool>(invoke(is, each)); };
}
template <class Range, class Is>
bool all_of(Range&& range, Is is) {
    return std::all_of(std::begin(range), std::end(range), asked(is));
}
template <class Range, class Is>
bool any_of(Range&& range, Is is) {
    return std::any_of(std::begin(range), std::end(range), asked(is));
}
template <class Range, class Is>
bool none_of(Range&& range, Is is) {
    return std::none_of(std::begin(range), std::end(range), asked(is));
}
template <class Range, class Is>
auto find_if(Range&& range, Is is) {
    return std::find_if(std::begin(range), std::end(range), asked(is));
}
template <class Range, class Is>
auto count_if(Range&& range, Is is) {
    return std::count_if(std::begin(range), std::end(range), asked(is));
}
template <class Range, class Other>
auto mismatch(Range&& range, Other&& other) {
    return std::mismatch(std::begin(range), std::end(range), std::begin(other), std::end(other));
}
template <class Range, class Compare = std::less<>, class Projection = std::identity>
void stable_sort(Range&& range, Compare compare = {}, Projection projection = {}) {
    std::stable_sort(std::begin(range), std::end(range), by(compare, projection));
}
template <class Range, class Is>
auto adjacent_find(Range&& range, Is is) {
    return std::adjacent_find(std::begin(range), std::end(range), is);
}
template <class Range, class Compare = std::less<>, class Projection = std::identity>
auto min_element(Range&& range, Compare compare = {}, Projection projection = {}) {
    return std::min_element(std::begin(range), std::end(range), by(compare, projection));
}
template <class Range, class Compare = std::less<>, class Projection = std::identity>
auto max_element(Range&& range, Compare compare = {}, Projection projection = {}) {
    return std::max_element(std::begin(range), std::end(range), by(compare, projection));
}
template <class Range, class Value>
void replace(Range&& range, const Value& before, const Value& after) {
    std::replace(std::begin(range), std::end(range), before, after);
}
template <class Range>
void rotate(Range&& range, decltype(std::begin(range)) first) {
    std::rotate(std::begin(range), first, std::end(range));
}
template <class Range, class Output>
void move(Range&& range, Output output) {
    std::move(std::begin(range), std::end(range), output);
}

}  // namespace ranges
}  // namespace std
