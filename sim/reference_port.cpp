// SPDX-License-Identifier: Apache-2.0
#include "reference_port.hpp"

#include "real_time_transport.hpp"
#include "reference_board.hpp"

namespace haptogram::sim {
namespace {

class ReferencePort final : public link::Transport {
public:
    explicit ReferencePort(const std::string& configuration) : board_(configuration), line_(board_) {}
    void write(std::span<const std::uint8_t> bytes) override { line_.write(bytes); }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        return line_.read(patience);
    }
    [[nodiscard]] std::chrono::nanoseconds now() const override { return line_.now(); }

private:
    ReferenceBoard board_;
    RealTimeTransport line_;
};

}  // namespace

std::unique_ptr<link::Transport> open_reference(const std::string& configuration) {
    return std::make_unique<ReferencePort>(configuration);
}

std::function<std::unique_ptr<link::Transport>()> opener_of(const link::PortSettings& settings) {
    constexpr std::string_view simulated = "reference:";
    if (!settings.port.starts_with(simulated)) return [settings] { return link::open_port(settings); };
    const std::string configuration = settings.port.substr(simulated.size());
    static_cast<void>(ReferenceBoard(configuration));  // a wrong name is said here
    return [configuration] { return open_reference(configuration); };
}

}  // namespace haptogram::sim
