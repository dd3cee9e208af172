// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "haptogram/base/progress.hpp"
#include "haptogram/link/clock.hpp"

namespace haptogram::cli {

/// One line on stderr that says how far a long piece of work has come. Redrawn in place on a terminal at most ten times
/// a second; where stderr is no terminal nothing is written.
class ProgressLine {
public:
    explicit ProgressLine(std::string title);
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;
    ~ProgressLine();

    /// @param fraction  0…1
    void update(double fraction, const std::string& note = {});

    /// The callback for a function of a library. It must not outlive this object.
    [[nodiscard]] Progress callback();

    /// For work whose end is not known in advance.
    void note(const std::string& text);

private:
    void draw(const std::string& text);

    std::string title_;
    bool on_terminal_;
    bool drawn_ = false;
    link::Clock::Time last_{};
};

}  // namespace haptogram::cli
