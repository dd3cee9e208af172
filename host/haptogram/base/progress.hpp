// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <string>

namespace haptogram {

/// One line on stderr that says how far a long piece of work has come. Redrawn in place on a terminal at most ten times
/// a second; where stderr is no terminal nothing is written.
class Progress {
public:
    explicit Progress(std::string title);
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress();

    /// @param fraction  0…1
    void update(double fraction, const std::string& note = {});

    /// Of work whose end nobody knows.
    void note(const std::string& text);

private:
    void draw(const std::string& text);

    std::string title_;
    bool on_terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_{};
};

}  // namespace haptogram
