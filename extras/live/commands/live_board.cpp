// SPDX-License-Identifier: Apache-2.0
#include "live_board.hpp"

#include "haptogram/link/rig_commands.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "reference_board.hpp"
#include "rig_simulation.hpp"
#include "simulated_transport.hpp"
#include "tiles.hpp"

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

/// Reference boards on one wire, whose crystals differ.
class ReferenceRig final : public LiveBoard {
public:
    ReferenceRig(const std::string& configuration, const Rig& rig, const link::RigSettings& settings)
        : oscillators_(sim::random_oscillators(rig.arrays.size(), drift_ppm, seed)),
          boards_(configuration, oscillators_, seed) {
        for (std::size_t i = 0; i < boards_.size(); ++i) {
            lines_.push_back(std::make_unique<sim::TileTransport>(boards_, i));
            clients_.push_back(std::make_unique<link::Client>(*lines_.back()));
            clients_.back()->identify();
            tiles_.push_back({*clients_.back(), no_image_,
                              link::name_of_tile(i, std::string(link::reference_prefix) + configuration)});
            elements_.push_back(rig.arrays[i].array.elements.size());
        }
        boards_.board(0).on_cycle_start([this](const sim::CycleStart& c) {
            if (c.enabled && (starts_.empty() || starts_.back().second != c.index))
                starts_.emplace_back(femtosecond * static_cast<double>(boards_.time_of(0, c.clock)), c.index);
        });
        rig_ = std::make_unique<link::RigCommands>(tiles_, settings);
    }

    link::Commands& client() override { return *rig_; }
    [[nodiscard]] std::vector<live::DevicePart> parts() override {
        std::vector<live::DevicePart> parts;
        for (std::size_t i = 0; i < tiles_.size(); ++i) parts.push_back({*clients_[i], elements_[i]});
        return parts;
    }
    [[nodiscard]] unsigned beginnings() const override { return rig_->beginnings(); }
    [[nodiscard]] std::vector<std::pair<double, std::uint16_t>> starts() const override { return starts_; }

private:
    static constexpr double femtosecond = 1e-15, drift_ppm = 50.0;
    static constexpr std::uint32_t seed = 1;

    std::vector<sim::Oscillator> oscillators_;
    sim::ReferenceTiles boards_;
    std::vector<std::unique_ptr<sim::TileTransport>> lines_;
    std::vector<std::unique_ptr<link::Client>> clients_;
    Image no_image_;
    std::vector<link::Tile> tiles_;
    std::vector<std::size_t> elements_;
    std::unique_ptr<link::RigCommands> rig_;
    std::vector<std::pair<double, std::uint16_t>> starts_;
};

}  // namespace

std::unique_ptr<LiveBoard> reference_rig(const std::string& configuration, const Rig& rig,
                                         const link::RigSettings& settings) {
    return std::make_unique<ReferenceRig>(configuration, rig, settings);
}

std::unique_ptr<LiveBoard> reference_board(const std::string& configuration) {
    return std::make_unique<ReferenceLiveBoard>(configuration);
}

}  // namespace haptogram::cli
