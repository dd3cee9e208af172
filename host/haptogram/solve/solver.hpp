// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/model/array.hpp"
#include "haptogram/render/path.hpp"

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

/// What a focus' amplitude is a fraction of.
enum class Level {
    reachable,  ///< the most that the array could make there, as render/path.hpp says: equal amplitudes are equal
                ///< shares
    pressure,   ///< the same pressure everywhere: equal amplitudes are equal pressures
};

struct SolveOptions {
    Method method = Method::gauss_newton;
    bool amplitudes = false;         ///< drives may differ in amplitude, too; otherwise only in phase
    Level level = Level::reachable;  ///< of the iterating methods; the others do not know it
    std::optional<unsigned> rounds;  ///< of the iterating methods; by default 10 for gauss_newton, and 100
    friend bool operator==(const SolveOptions&, const SolveOptions&) = default;
};

/// Drives that make several foci at the same time, one an element. The strongest has the largest of the foci's
/// amplitudes; without options.amplitudes all have it. Computed in double precision and in one order, so that the same
/// foci give the same bytes on every machine.
///
/// With the propagation A (propagation.hpp), pressures p = A·x of drives x, target amplitudes t, and drives that are
/// the phases of Aᴴ·c, the iterating methods differ in c. GS: t·p/|p|. Weighted GS: t·w·p/|p|, where each round
/// multiplies w by the mean of |p|/t over |p|/t. GS-PAT: the phases y of A·Aᴴ·y, without elements. The Gauss-Newton
/// step is the smallest change of phases that makes all |p|/t equal to first order; for two or three foci there are
/// three such steps. It also holds the pressure down at nulls, which are foci of amplitude 0.
/// @param foci   positions in metres, array frame; those of amplitude 0 are nulls, which only gauss_newton knows
/// @param start  drives to begin with, of the last of a row of similar sets of foci, say; empty: none. Iterating
/// methods
///               then need a round or two
/// @throws Error{bad_input} naming the focus, when one is not finite, coincides with an element or with another focus,
/// or has an amplitude outside 0…1, or when there are more foci than elements; Error{bad_argument} when there is none,
/// when there are nulls and the method is not gauss_newton, when `start` is not one drive an element, or when
/// inverse_transform meets elements that are not in one plane z; Error{failed} when the drives make no pressure at a
/// focus
[[nodiscard]] std::vector<std::complex<double>> solve(const Array& array, std::span<const Focus> foci,
                                                      const SolveOptions& options = {},
                                                      std::span<const std::complex<double>> start = {});

/// How good the foci are that some drives make, by direct sums of propagation (propagation.hpp).
struct Quality {
    std::vector<double> pressure_pa;  ///< amplitude at each focus
    double spread = 0.0;              ///< standard deviation of pressure over target, over its mean (CV)
    double least_over_mean = 0.0;     ///< of the same ratio
    double efficiency = 0.0;  ///< √Σ (|p|/p₁)², where p₁ is what all elements at full strength make at one focus
                              ///< alone: for K equal foci, their pressure over p₁/√K
    std::optional<double> null_share;  ///< the largest pressure at a focus of amplitude 0, over p₁ there; without any
                                       ///< such focus, none. The other ratios are of the others
};

/// @param drives  one an element, 1 at full strength
/// @throws Error as solve()
[[nodiscard]] Quality quality_of(const Array& array, std::span<const Focus> foci,
                                 std::span<const std::complex<double>> drives, Level level = Level::reachable);

}  // namespace haptogram
