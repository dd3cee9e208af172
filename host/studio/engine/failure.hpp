// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>

#include "haptogram/base/error.hpp"
#include "messages.hpp"
#include "recipient.hpp"

namespace haptogram::studio {

/// What may be wrong is told to the page; what cannot be told ends the program.
template <class Work>
std::optional<nlohmann::ordered_json> error_of(Work work) {
    using nlohmann::ordered_json;
    try {
        work();
        return {};
    } catch (const Error& error) {
        return to_json(error);
    } catch (const std::bad_alloc&) {
        return ordered_json{{"where", ""}, {"message", "out of memory; take fewer points"}};
    } catch (const std::exception& error) {
        return ordered_json{{"where", ""}, {"message", error.what()}};
    }
}

/// Work whose failure is told as the answer to message `n`.
template <class Work>
void tell_failure(Recipient& page, std::uint32_t n, Work work) {
    if (const auto error = error_of(work)) page.send(to_text({{"t", "failed"}, {"n", n}, {"error", *error}}));
}

}  // namespace haptogram::studio
