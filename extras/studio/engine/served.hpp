// SPDX-License-Identifier: Apache-2.0
// Whatever serves the page, a server or the page itself, speaks with these names of the local server.
#pragma once
#include "recipient.hpp"
#include "request.hpp"

namespace haptogram::studio {

using serve::Answer, serve::error_answer, serve::query_value, serve::Recipient, serve::Request;

}  // namespace haptogram::studio
