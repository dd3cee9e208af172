// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "haptogram/format/schedule.hpp"
#include "haptogram/solve/solver.hpp"

namespace haptogram {

/// Method::gauss_newton of solver.hpp for foci that change many times a second: phases only, in single precision with
/// the processor's vector instructions, and without allocating memory once constructed. Drives of different instruction
/// sets differ by rounding, so images are made by solve() instead.
///
/// Arrays whose elements all face +z are fast. For others the propagation is computed in double precision, which takes
/// most of the time.
class FastSolver {
public:
    struct Options {
        unsigned rounds = 10;            ///< of weighted GS in solve()
        unsigned rounds_to_follow = 1;   ///< and in follow()
        Level level = Level::reachable;  ///< what amplitudes are fractions of
    };

    /// @param most_foci  that are ever to be made at the same time
    /// @throws Error{bad_argument} for an array without elements, or most_foci that is 0 or more than the elements
    FastSolver(const Array& array, std::size_t most_foci, const Options& options);
    FastSolver(const Array& array, std::size_t most_foci) : FastSolver(array, most_foci, Options{}) {}
    ~FastSolver();
    FastSolver(FastSolver&&) noexcept;
    FastSolver& operator=(FastSolver&&) noexcept;

    /// Finds drives for the foci, beginning from nothing.
    /// @param foci  positions in metres, array frame; amplitudes above 0, up to 1
    /// @throws Error{bad_input} naming the focus, when one is not finite, coincides with an element or with another
    /// focus, or has another amplitude; Error{bad_argument} when there is none, or more than most_foci
    void solve(std::span<const Focus> foci);
    /// The same, beginning from the last drives and weights: for foci that have moved by a small part of a wavelength.
    /// @throws Error{bad_argument} also when the number of foci is another than last time
    void follow(std::span<const Focus> foci);

    /// The drives that were found, one an element, of amplitude 1.
    [[nodiscard]] std::vector<std::complex<double>> drives() const;
    /// The tick at which each element's pulse begins: the drive's phase, rounded to the nearest of timer.cycle_ticks.
    /// @param ticks  room for one an element
    /// @throws Error{bad_argument} for another room
    void ticks(const Timer& timer, std::span<std::uint16_t> ticks) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Name of the instruction set that FastSolver is dispatched to, for reports.
[[nodiscard]] const char* fast_solver_target();

}  // namespace haptogram
