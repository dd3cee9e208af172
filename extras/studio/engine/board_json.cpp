// SPDX-License-Identifier: Apache-2.0
#include "board_json.hpp"

#include "haptogram/link/to_json.hpp"

namespace haptogram::studio {

nlohmann::ordered_json device_json(const link::DeviceState& state, const std::string& port, std::uint32_t baud,
                                   double intensity) {
    nlohmann::ordered_json json{
        {"t", "device"}, {"connection", to_string(state.connection)}, {"port", port}, {"intensity", intensity}};
    if (state.connection != link::Connection::connecting) {
        json["identity"] = link::to_json(state.identity);
        json["status"] = link::to_json(state.status);
        // Its watchdog turns them off, and nobody says so.
        if (state.connection == link::Connection::lost && state.status.enabled) json["status"]["outputs"] = "unknown";
        if (baud != 0) json["baud"] = baud;
    }
    if (!state.trouble.empty()) json["trouble"] = state.trouble;
    return json;
}

}  // namespace haptogram::studio
