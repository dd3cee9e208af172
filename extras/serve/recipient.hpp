// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace haptogram::serve {

/// Whom answers are sent to.
class Recipient {
public:
    Recipient() = default;
    Recipient(const Recipient&) = delete;
    Recipient& operator=(const Recipient&) = delete;
    virtual ~Recipient() = default;

    virtual void send(std::string text) = 0;
    virtual void send(std::vector<std::uint8_t> bulk) = 0;
};

}  // namespace haptogram::serve
