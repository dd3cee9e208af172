// SPDX-License-Identifier: Apache-2.0
#include "live_board.hpp"

#include "reference_board.hpp"
#include "simulated_transport.hpp"

namespace haptogram::cli {
namespace {

class ReferenceLiveBoard final : public LiveBoard {
public:
    explicit ReferenceLiveBoard(const std::string& configuration)
        : board_(configuration), line_(board_), client_(line_) {
        board_.on_cycle_start([this](const sim::CycleStart& c) {
            if (c.enabled && (starts_.empty() || starts_.back().second != c.index))
                starts_.emplace_back(seconds(c.clock), c.index);
        });
        client_.identify();
    }

    link::Client& client() override { return client_; }
    link::HostClock clock() override {
        return {[this] { return seconds(board_.now()); },
                [this](double until_s) {
                    const double clocks = until_s * board_.parameters().clock_hz - static_cast<double>(board_.now());
                    if (clocks > 0.0) board_.run(static_cast<std::uint64_t>(clocks) + 1);
                }};
    }
    [[nodiscard]] std::vector<std::pair<double, std::uint16_t>> starts() const override { return starts_; }

private:
    [[nodiscard]] double seconds(std::uint64_t clocks) const {
        return static_cast<double>(clocks) / board_.parameters().clock_hz;
    }

    sim::ReferenceBoard board_;
    sim::SimulatedTransport line_;
    link::Client client_;
    std::vector<std::pair<double, std::uint16_t>> starts_;
};

}  // namespace

std::unique_ptr<LiveBoard> reference_board(const std::string& configuration) {
    return std::make_unique<ReferenceLiveBoard>(configuration);
}

}  // namespace haptogram::cli
