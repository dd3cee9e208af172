// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/link/background_thread.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/rig.hpp"

namespace haptogram::link {

/// The boards of a rig, for callers that do not wait: BackgroundPlayer for several that play as one.
class BackgroundRig {
public:
    /// @param manifest  a rig manifest's file
    /// @param ports     as ports_of()
    /// @throws Error{bad_input} for the manifest, Error{device} naming the tile that does not answer
    BackgroundRig(const std::string& manifest, const std::vector<std::string>& ports,
                  std::optional<std::uint32_t> baud);
    BackgroundRig(const BackgroundRig&) = delete;
    BackgroundRig& operator=(const BackgroundRig&) = delete;
    ~BackgroundRig();
    /// Turns the outputs off. After it, nothing is to be asked for.
    void end();

    /// Of each tile, as it said when this began.
    [[nodiscard]] const std::vector<Identity>& identities() const { return identities_; }
    /// Of each tile, as it said last; empty for a lost one.
    [[nodiscard]] std::vector<std::optional<Status>> statuses() const;
    [[nodiscard]] bool busy() const { return thread_.busy(); }

    /// Writes each tile's image into its board.
    void upload();
    void play(const RigSettings& settings);
    bool wait(std::chrono::milliseconds patience) { return thread_.wait(patience); }
    void stop();
    void shut_off();

private:
    RigBundle bundle_;
    std::vector<PortSettings> ports_;
    std::atomic<bool> off_ = false;  ///< all that waits for a board is interrupted
    std::vector<Identity> identities_;
    mutable std::mutex mutex_;
    std::vector<std::optional<Status>> statuses_;
    BackgroundThread thread_{machine_clock()};
};

}  // namespace haptogram::link
