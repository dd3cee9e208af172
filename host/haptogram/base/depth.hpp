// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace haptogram {

/// How deep lists, objects and tables may lie within each other in any text that is read. Parsers, and what copies or
/// frees their results, take some of the stack for each, and whoever runs out of that dies with outputs on.
constexpr std::size_t most_nested = 64;

/// Of JSON or TOML, before it is parsed. A text that is neither may pass; its parser refuses it.
[[nodiscard]] bool is_shallow(std::string_view text);
/// @throws Error{bad_input}, with `where` the text is from
void require_shallow(std::string_view text, const std::string& where);

}  // namespace haptogram
