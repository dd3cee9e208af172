// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// One serial line that several tiles share, each of which passes it on to the next (rtl/INTERFACE.md, A chain of
/// tiles). Each tile is a Transport of its own; they may be used in different threads.
class Chain : public std::enable_shared_from_this<Chain> {
public:
    /// @param port  leads to the first tile
    explicit Chain(std::unique_ptr<Transport> port) : port_(std::move(port)) {}

    /// The line to one tile. Makes it and all before it pass frames on, if they do not yet.
    /// @param number  its place in the chain, from 1 to interface::chain::most_tiles
    /// @throws LinkLost when the port is gone
    /// @throws Error{device} when somebody has this tile already
    [[nodiscard]] std::unique_ptr<Transport> tile(unsigned number);
    /// Whether the port is gone; then every tile is lost, and the chain is to be opened anew.
    [[nodiscard]] bool lost() const;

private:
    class Tile;

    void leave(unsigned number);
    void write(std::span<const std::uint8_t> bytes);
    [[nodiscard]] std::vector<std::uint8_t> read(unsigned number, std::chrono::microseconds patience);
    void sort(std::span<const std::uint8_t> bytes);
    [[nodiscard]] Transport& port();
    template <class Work>
    auto with_port(Work&& work);

    mutable std::mutex mutex_;
    std::unique_ptr<Transport> port_;                        // empty when it is gone
    std::vector<std::uint8_t> frame_;                        // that arrives, as far as it is here
    std::map<unsigned, std::vector<std::uint8_t>> arrived_;  // of each tile
};

/// The name of a port and, behind the last '#', the number of a tile in the chain there: "/dev/ttyUSB0#2".
struct ChainedPort {
    std::string port;
    unsigned tile = 0;
};

/// @return nothing for a port without a number
/// @throws Error{bad_argument} naming the port when the number is none of a tile
[[nodiscard]] std::optional<ChainedPort> chained_port(const std::string& name);
/// The other way round.
[[nodiscard]] std::string name_of(const ChainedPort& port);

}  // namespace haptogram::link
