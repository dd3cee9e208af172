// SPDX-License-Identifier: Apache-2.0
#include "reference_port.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include "haptogram/base/file.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/transfer.hpp"
#include "pace.hpp"
#include "reference_board.hpp"
#include "simulated_transport.hpp"

namespace haptogram::sim {
namespace {

class ReferencePort final : public link::Transport {
public:
    ReferencePort(const std::string& configuration, std::function<void(const Edge&)> on_edge) : board_(configuration) {
        if (on_edge) board_.on_edge(std::move(on_edge));
    }

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
    /// The host's own silence counts in full, as a real board's watchdog would count it; what this computing takes
    /// does not.
    void catch_up() {
        const double behind_s = -pace_.ahead_s(simulated_s());
        if (behind_s > 0.0) board_.run(static_cast<std::uint64_t>(behind_s * board_.parameters().clock_hz));
        pace_.give_up(simulated_s());
    }

    [[nodiscard]] double simulated_s() const {
        return static_cast<double>(board_.now()) / board_.parameters().clock_hz;
    }

    ReferenceBoard board_;
    Pace pace_{0.01};
};

struct OwnBoard {
    ReferenceBoard board;
};

class ReferenceLine final : private OwnBoard, public SimulatedTransport {
public:
    explicit ReferenceLine(const std::string& configuration)
        : OwnBoard{ReferenceBoard(configuration)}, SimulatedTransport(board) {}
};

}  // namespace

std::unique_ptr<link::Transport> reference_line(const std::string& name) {
    const std::size_t equals = name.find('=');
    auto line = std::make_unique<ReferenceLine>(name.substr(0, equals));
    if (equals == std::string::npos) return line;
    const std::string path = name.substr(equals + 1);
    const Image image = from_intel_hex(read_file(path), path);
    link::Client client(*line);
    link::require_fits(image, client.identify(), path);
    link::upload(client, image);
    return line;
}

std::function<std::unique_ptr<link::Transport>()> opener_of(const link::PortSettings& settings) {
    if (!settings.port.starts_with(link::reference_prefix)) return [settings] { return link::open_port(settings); };
    const std::string configuration = settings.port.substr(link::reference_prefix.size());
    static_cast<void>(ReferenceBoard(configuration));  // a wrong name is said here
    return [configuration] { return reference_port(configuration); };
}

std::unique_ptr<link::Transport> reference_port(const std::string& configuration,
                                                std::function<void(const Edge&)> on_edge) {
    return std::make_unique<ReferencePort>(configuration, std::move(on_edge));
}

}  // namespace haptogram::sim
