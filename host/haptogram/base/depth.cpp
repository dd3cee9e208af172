// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/depth.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"

namespace haptogram {

bool is_shallow(std::string_view text) {
    std::size_t depth = 0, dots = 0;  // TOML's a.b.c is a table in a table, too
    char quote = 0;
    bool comment = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char each = text[i];
        if (quote != 0) {
            if (each == '\\' && quote == '"') ++i;
            if (each == quote) quote = 0;
            continue;
        }
        if (each == '\n') comment = false;
        if (comment) continue;
        switch (each) {
            case '"':
            case '\'': quote = each; break;
            case '#': comment = true; break;
            case '.':
                if (++dots > most_nested) return false;
                break;
            case '[':
            case '{':
                if (++depth > most_nested) return false;
                dots = 0;
                break;
            case ']':
            case '}': depth -= depth > 0 ? 1 : 0; [[fallthrough]];
            case ',':
            case '=':
            case '\n': dots = 0; break;
            default: break;
        }
    }
    return true;
}

void require_shallow(std::string_view text, const std::string& where) {
    if (!is_shallow(text))
        throw bad_input(where, fmt::format("its lists and objects are more than {} deep", most_nested));
}

}  // namespace haptogram
