// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// What a focus' amplitude is a fraction of.
enum class Level {
    reachable,  ///< the most that the array could make there, as format/path.hpp says: equal amplitudes are equal
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

/// What the transducers' bandwidth and the waves' different ways leave of the pressure of each step of a path that
/// repeats: the largest pressure at the step's foci while its waves arrive, over that of the step alone for ever. A
/// transducer's carrier follows its drive as a resonance of bandwidth B does, with the time constant 1/(πB), and an
/// element's wave arrives R/c later. Near foci leave more than far ones, because the drives differ less.
/// For two foci in turn, the resonators of acoustics/transient.hpp give the same within 0.03 when each lasts 12 carrier
/// periods, 0.04 for 8 and 0.07 for 4.
/// @return a fraction a step; 1 for silence. It exceeds 1 when the step before was stronger, or helps
/// @throws Error{bad_argument} for an unsound path
[[nodiscard]] std::vector<double> pressure_left(const Array& array, const Path& path);

/// The least of the fractions over the steps that are not silence, and their mean over time.
struct PressureLeft {
    double least = 1.0, mean = 1.0;
};
[[nodiscard]] PressureLeft summary_of(const Path& path, const std::vector<double>& left);

}  // namespace haptogram
