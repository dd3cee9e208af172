// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include "base/error.hpp"
#include "command.hpp"
#include "link/client.hpp"

namespace haptogram::cli {

/// Outputs are on while this lives, and off when it goes, whatever ended the playing.
class Outputs {
public:
    explicit Outputs(link::Client& client) : client_(client) { client_.enable(); }
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;
    ~Outputs() {
        try {
            client_.stop();
            client_.disable();
        } catch (const Error& error) {
            complain(fmt::format("{}; the watchdog turns the outputs off", error.what()));
        }
    }

private:
    link::Client& client_;
};

}  // namespace haptogram::cli
