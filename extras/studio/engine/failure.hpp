// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "haptogram/base/error.hpp"
#include "messages.hpp"
#include "served.hpp"

namespace haptogram::studio {

/// What may be wrong is told to the page; what cannot be told ends the program.
[[nodiscard]] std::optional<nlohmann::ordered_json> error_of(const std::function<void()>& work);

/// Work whose failure is told as the answer to message `n`.
void tell_failure(Recipient& page, std::uint32_t n, const std::function<void()>& work);

}  // namespace haptogram::studio
