// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "haptogram/live/loop.hpp"
#include "haptogram/live/tasks.hpp"

namespace haptogram {

/// Lines for another program, each as soon as it is there. Nobody who reads them slowly is waited for: what does not go
/// through at once is dropped as a whole line, and counted.
class LineOutput {
public:
    /// @param place  a file or a named pipe; "-", standard output; or udp:ADDRESS:PORT, a line a datagram
    /// @throws Error{bad_input} when it cannot be opened, Error{bad_argument} for an address that is none
    explicit LineOutput(const std::string& place);
    LineOutput(const LineOutput&) = delete;
    LineOutput& operator=(const LineOutput&) = delete;
    ~LineOutput();

    /// @param line  without its end
    void write(const std::string& line);
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    bool send(const std::string& text);

    int descriptor_ = -1;
    bool datagrams_ = false, keep_open_ = false;
    std::string rest_;  ///< of a line that has begun to go
    std::uint64_t dropped_ = 0;
};

}  // namespace haptogram

namespace haptogram::live {

/// What happened in a frame, lengths in mm, as the table in extras/live/README.md has it.
/// @param path  that plays since then, if any
[[nodiscard]] nlohmann::ordered_json to_json(const ShotReport& shot, const Frame& frame,
                                             const std::optional<Path>& path);
/// What became of a run. The latency stands in it when rings were seen at the pins, and as stamped_latency_ms when the
/// device counts carrier periods.
[[nodiscard]] nlohmann::ordered_json to_json(const LoopReport& report, const Latency& latency);
/// The same, with every ring that went to the device and when it began.
[[nodiscard]] nlohmann::ordered_json run_to_json(const LoopReport& report, const Latency& latency);

/// A trial of a task: what was asked, and what came of it.
[[nodiscard]] nlohmann::ordered_json to_json(const LiftOptions& asked, const LiftReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const SurfaceOptions& asked, const SurfaceReport& report);

}  // namespace haptogram::live
