// SPDX-License-Identifier: Apache-2.0
#include "reference_port.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

#include "reference_board.hpp"

namespace haptogram::sim {
namespace {

class ReferencePort final : public link::Transport {
public:
    explicit ReferencePort(const std::string& configuration) : board_(configuration) {}

    void write(std::span<const std::uint8_t> bytes) override {
        catch_up();
        board_.send(bytes);
    }

    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        const auto end = std::chrono::steady_clock::now() + patience;
        for (catch_up(); board_.received() == 0 && std::chrono::steady_clock::now() < end; catch_up())
            std::this_thread::sleep_for(std::min(patience, std::chrono::microseconds(100)));
        return board_.receive();
    }

private:
    void catch_up() {
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begun_;
        const auto due = static_cast<std::uint64_t>(passed.count() * board_.parameters().clock_hz);
        if (due > board_.now()) board_.run(due - board_.now());
    }

    ReferenceBoard board_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace

std::function<std::unique_ptr<link::Transport>()> opener_of(const link::PortSettings& settings) {
    constexpr std::string_view simulated = "reference:";
    if (!settings.port.starts_with(simulated)) return [settings] { return link::open_port(settings); };
    const std::string configuration = settings.port.substr(simulated.size());
    static_cast<void>(ReferenceBoard(configuration));  // a wrong name is said here
    return [configuration] { return std::make_unique<ReferencePort>(configuration); };
}

}  // namespace haptogram::sim
