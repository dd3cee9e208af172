// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

/// A part of the self-test, in the order of the chain from the host to the hand.
enum class Check : std::uint8_t { link, memories, clock, sync, outputs, watchdog, stop_switch, channels, point };
inline constexpr std::array all_checks = {Check::link,        Check::memories, Check::clock,
                                          Check::sync,        Check::outputs,  Check::watchdog,
                                          Check::stop_switch, Check::channels, Check::point};
[[nodiscard]] std::string_view to_string(Check check);
/// Empty when no check has this name.
[[nodiscard]] std::optional<Check> check_named(std::string_view name);

/// A check's result. Unjudged: only a person can judge it, and none was asked, or the board has no such part.
enum class Outcome : std::uint8_t { passed, failed, unjudged };
[[nodiscard]] std::string_view to_string(Outcome outcome);

/// What a check found, in words for the user; of a failed one, where to look, too.
struct Finding {
    Check check = Check::link;
    Outcome outcome = Outcome::passed;
    std::string found;
    std::string advice{};
};

struct SelfTestSettings {
    Array array;  ///< that the device drives; it says carrier, duty, and how to focus
    std::vector<Check> checks{all_checks.begin(), all_checks.end()};
    std::uint32_t first_channel = 0;              ///< of the channels that play one after the other
    std::optional<std::uint32_t> last_channel{};  ///< without: the device's last
    double channel_s = 0.3;                       ///< for how long each of them plays
    Vec3 point{0.0, 0.0, 0.15};                   ///< that a hand should feel, m, in the array's frame
    double point_s = 5.0;                         ///< for how long it plays
    /// Shows a question to a person and returns the line that was answered; empty when there is no one to ask.
    std::function<std::string(const std::string& question)> ask{};
    std::function<void(const Finding&)> tell{};  ///< told each finding as soon as there is one
    Progress progress{};                         ///< its stages are the checks' names
    Warning warn{};
};

/// Walks the chain from the host to the hand, one check after the other. What played before is ended; what was in the
/// memories is there again afterwards. Outputs are off in the end, whatever ends it.
/// @throws LinkLost, Error{bad_argument} naming the setting that does not suit the device, Error{cancelled}
std::vector<Finding> self_test(Commands& device, const SelfTestSettings& settings);

[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<Finding>& findings);

}  // namespace haptogram::link
