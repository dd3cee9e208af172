// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/staircase.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "haptogram/base/error.hpp"

namespace haptogram::perception {

Staircase::Staircase(double start_db, const StaircaseRule& rule) : rule_(rule), level_(start_db) {
    if (!std::isfinite(start_db))
        throw bad_argument("start", "a staircase starts at a finite level in dB; an amplitude of 0 has none");
    if (!(rule.first_step_db > 0.0 && rule.step_db > 0.0))
        throw bad_argument(
            "step", fmt::format("steps must be positive, found {:g} and {:g} dB", rule.first_step_db, rule.step_db));
    if (rule.reversals <= rule.first_reversals)
        throw bad_argument("reversals", fmt::format("{} reversals are too few: the first {} do not count",
                                                    rule.reversals, rule.first_reversals));
}

void Staircase::answer(bool felt) {
    if (finished()) throw bad_argument("staircase", "it is finished; start another one");
    if (last_ && *last_ != felt) reversals_.push_back(level_);
    last_ = felt;
    const double step = reversals_.size() < rule_.first_reversals ? rule_.first_step_db : rule_.step_db;
    level_ += felt ? -step : step;
}

double Staircase::threshold_db() const {
    if (!finished())
        throw bad_argument(
            "staircase", fmt::format("it has {} of {} reversals; go on answering", reversals_.size(), rule_.reversals));
    const auto from = reversals_.begin() + static_cast<std::ptrdiff_t>(rule_.first_reversals);
    return std::accumulate(from, reversals_.end(), 0.0) / static_cast<double>(reversals_.end() - from);
}

}  // namespace haptogram::perception
