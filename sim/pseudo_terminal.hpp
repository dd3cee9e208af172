// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace haptogram::sim {

/// The end that stays with us of a pseudo-terminal, which any program can open as a serial port.
class PseudoTerminal {
public:
    /// @param link  a name of its own for it: a symbolic link, removed again at the end; empty for none
    /// @throws Error{device} when there are no pseudo-terminals, Error{bad_input} when `link` cannot be made
    explicit PseudoTerminal(const std::filesystem::path& link = {});
    PseudoTerminal(const PseudoTerminal&) = delete;
    PseudoTerminal& operator=(const PseudoTerminal&) = delete;
    ~PseudoTerminal();

    /// Where others open it: the link if there is one.
    [[nodiscard]] std::string name() const { return link_.empty() ? device_ : link_.string(); }
    /// What others have written; waits at most this long for it.
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::milliseconds patience);
    /// What nobody takes is kept, and lost when the others have closed it, as on a wire.
    void write(std::span<const std::uint8_t> bytes);

private:
    int descriptor_ = -1;
    std::string device_;
    std::filesystem::path link_;
    std::vector<std::uint8_t> waiting_;
};

}  // namespace haptogram::sim
