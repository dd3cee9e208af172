// SPDX-License-Identifier: Apache-2.0
#include "haptogram/formats/xml.hpp"

#include <fmt/format.h>

#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram::formats {
namespace {

/// The tree of so many bytes takes at most 1 GB.
constexpr std::size_t most_bytes = 48UL * 1024 * 1024;

struct Depth : pugi::xml_tree_walker {
    int most = 0;
    bool for_each(pugi::xml_node&) override {
        most = std::max(most, depth());
        return most < static_cast<int>(most_nested);
    }
};

}  // namespace

void parse_xml(pugi::xml_document& document, std::string_view text, const std::string& name) {
    if (text.size() > most_bytes)
        throw bad_input(name,
                        fmt::format("it has {} bytes of XML, expected at most {}; simplify the shape, or export it "
                                    "as .ply or .stl",
                                    text.size(), most_bytes));
    const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
    if (!result)
        throw bad_input(name, fmt::format("it is no XML from byte {} on ({}); export it again", result.offset,
                                          result.description()));
    Depth depth;
    document.traverse(depth);
    if (depth.most >= static_cast<int>(most_nested))
        throw bad_input(name, fmt::format("its elements are nested more than {} deep; ungroup it", most_nested));
}

}  // namespace haptogram::formats
