// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host_line.hpp"

namespace haptogram::sim {

/// Our end of a pseudo-terminal. Any program can open the other end as a serial port.
class PseudoTerminal final : public HostLine {
public:
    /// @param baud  of the board; bytes at another rate are lost, as they are noise on a wire
    /// @param link  where to make a symbolic link to the other end, which is removed again at the end; empty for none
    /// @throws Error{device} when there are no pseudo-terminals, Error{bad_input} when `link` cannot be made
    explicit PseudoTerminal(std::uint32_t baud, const std::filesystem::path& link = {});
    ~PseudoTerminal() override;

    /// The name under which others open it: the link if there is one.
    [[nodiscard]] std::string name() const override { return link_.empty() ? device_ : link_.string(); }
    /// What others have written; waits at most this long for it.
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::milliseconds patience) override;
    /// Bytes that nobody takes are kept, and are lost when no program has the other end open, as on a wire.
    void write(std::span<const std::uint8_t> bytes) override;

private:
    [[nodiscard]] bool same_rate() const;

    std::uint32_t baud_;
    int descriptor_ = -1;
    std::string device_;
    std::filesystem::path link_;
    std::vector<std::uint8_t> waiting_;
};

}  // namespace haptogram::sim
