// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/client.hpp"

namespace haptogram::cli {

/// Outputs are on while this lives, and off when it goes, whatever ended the playing.
class Outputs {
public:
    explicit Outputs(link::Client& client) : client_(client) {
        try {
            client_.enable();
        } catch (const Error&) {
            end();  // they may be on: perhaps only the answer was lost
            throw;
        }
    }
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;
    ~Outputs() { end(); }

private:
    void end() {
        try {
            client_.disable();
            client_.stop();
        } catch (const Error& error) {
            complain(fmt::format("{}; the watchdog turns the outputs off", error.what()));
        }
    }

    link::Client& client_;
};

/// @throws Error{device} when the board has turned its outputs off by itself
inline void require_on(const link::BoardStatus& status) {
    if (!status.enabled)
        throw Error(ErrorCode::device, "board", "it has turned its outputs off: its watchdog or guard tripped");
}

}  // namespace haptogram::cli
