// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

namespace haptogram::perception {

/// How a staircase steps (Multimodal task T3).
struct StaircaseRule {
    double first_step_db = 3.0;       ///< until `first_reversals` have happened
    double step_db = 1.0;             ///< afterwards
    std::size_t first_reversals = 3;  ///< these do not count for the result
    std::size_t reversals = 8;        ///< at which it ends
};

/// Finds the level that a person just feels: down by a step after each yes, up after each no. A reversal is a level at
/// which the direction changes. Levels are in dB, so a start at an amplitude of 0, as the paper says, cannot be.
class Staircase {
public:
    /// @throws Error{bad_argument} when a step is not positive, or no reversal would be left to average
    explicit Staircase(double start_db, const StaircaseRule& rule = {});

    /// The level to present next.
    [[nodiscard]] double level_db() const { return level_; }
    [[nodiscard]] bool finished() const { return reversals_.size() >= rule_.reversals; }
    /// The person's answer at level_db(). @throws Error{bad_argument} when it is finished
    void answer(bool felt);
    [[nodiscard]] const std::vector<double>& reversals_db() const { return reversals_; }
    /// The mean of the reversals that count. @throws Error{bad_argument} before it is finished
    [[nodiscard]] double threshold_db() const;

private:
    StaircaseRule rule_;
    double level_;
    std::optional<bool> last_;
    std::vector<double> reversals_;
};

}  // namespace haptogram::perception
