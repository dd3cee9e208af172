// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace haptogram {

/// How drives are found that make several foci at the same time. docs/references.md names the sources.
enum class Method {
    gauss_newton,       ///< weighted GS, and one Gauss-Newton step that makes the foci equal
    weighted_gs,        ///< GS whose weights grow for foci that are too weak (Di Leonardo et al. 2007)
    gs,                 ///< Gerchberg and Saxton 1972: phases of the foci and of the elements in turn
    gs_pat,             ///< the same between foci alone (Plasencia et al. 2020)
    superposition,      ///< sum of the drives for each focus alone
    distance_weighted,  ///< the same, each element's share times its distance (Fingers, III-C)
    inverse_transform,  ///< Fourier transform of the foci, on the drives for one focus in their middle (Hoshi eq. 9)
};

struct MethodName {
    Method method;
    const char* name;   ///< on command lines and in files
    const char* about;  ///< for help
};
inline constexpr MethodName method_names[] = {
    {Method::gauss_newton, "gauss-newton", "weighted GS and a Gauss-Newton step"},
    {Method::weighted_gs, "weighted-gs", "weighted Gerchberg-Saxton"},
    {Method::gs, "gs", "Gerchberg-Saxton"},
    {Method::gs_pat, "gs-pat", "Gerchberg-Saxton between foci alone"},
    {Method::superposition, "superposition", "sum of the drives for each focus"},
    {Method::distance_weighted, "distance-weighted", "the same, times the distance"},
    {Method::inverse_transform, "inverse-transform", "Fourier transform of the foci"},
};
[[nodiscard]] const char* name_of(Method method);
/// @throws Error{bad_argument} with `setting` in it, naming the methods that there are
[[nodiscard]] Method method_of(const std::string& name, const std::string& setting = "solver");

}  // namespace haptogram
