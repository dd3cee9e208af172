// SPDX-License-Identifier: Apache-2.0
// What the sources of the C interface share: how arguments are taken, and how what is thrown becomes a code and words.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <span>
#include <string>

#include "haptogram.h"
#include "haptogram/base/error.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/verbs/path_makers.hpp"

struct haptogram_image {
    haptogram::Bundle bundle;
    std::string manifest, warnings;
};

namespace haptogram::c {

inline thread_local std::string last_error, last_place, last_remedies;

[[nodiscard]] haptogram_code code_of(ErrorCode code);

/// Does some work, and keeps what it throws for haptogram_error().
template <class Work>
haptogram_code guarded(const Work& work) noexcept {
    try {
        last_error.clear();
        last_place.clear();
        last_remedies.clear();
        work();
        return HAPTOGRAM_OK;
    } catch (const Error& error) {
        last_error = error.what();
        last_place = error.where();
        last_remedies = fmt::format("{}", fmt::join(error.remedies(), ","));
        return code_of(error.code());
    } catch (const std::exception& error) {
        last_error = error.what();
    } catch (...) {
        last_error = "an unknown exception";
    }
    return HAPTOGRAM_FAILED;
}

template <class T>
T& required(T* given, const char* name) {
    if (given == nullptr) throw bad_argument(name, "is NULL");
    return *given;
}

inline const char* required_text(const char* given, const char* name) { return &required(given, name); }

/// A struct as its caller knows it: what a later version appended is zero.
template <class Struct>
Struct known_part(const Struct* given, const char* name) {
    Struct known{};
    const std::uint32_t size = required(given, name).size;
    if (size < sizeof size)
        throw bad_argument(name, fmt::format("its size is {}; set it to sizeof of the struct", size));
    std::memcpy(&known, given, std::min<std::size_t>(size, sizeof known));
    return known;
}

inline std::size_t copy(const std::string& text, char* to, std::size_t room) {
    if (to != nullptr) std::memcpy(to, text.data(), std::min(room, text.size()));
    return text.size();
}

/// Points of three coordinates each, in place. @param name  of the numbers, for messages
inline std::span<const Vec3> points_of(const double* numbers, std::size_t count, const char* name) {
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    return {reinterpret_cast<const Vec3*>(&required(numbers, name)), count};
}

inline Focus focus_of(const haptogram_focus& given) { return {{given.x_m, given.y_m, given.z_m}, given.amplitude}; }

/// With what each extra of this build makes.
[[nodiscard]] PathMakers makers();

/// Ends the work when the caller's number is no longer 0.
[[nodiscard]] Progress until(const std::int32_t* cancel);

}  // namespace haptogram::c
