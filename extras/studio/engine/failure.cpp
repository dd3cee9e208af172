// SPDX-License-Identifier: Apache-2.0
#include "failure.hpp"

#include <exception>
#include <new>

namespace haptogram::studio {

using nlohmann::ordered_json;

std::optional<ordered_json> error_of(const std::function<void()>& work) {
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

void tell_failure(Recipient& page, std::uint32_t n, const std::function<void()>& work) {
    if (const auto error = error_of(work)) page.send(to_text({{"t", "failed"}, {"n", n}, {"error", *error}}));
}

}  // namespace haptogram::studio
