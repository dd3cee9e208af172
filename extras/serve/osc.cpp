// SPDX-License-Identifier: Apache-2.0
#include "osc.hpp"

#include <bit>
#include <cstring>
#include <string_view>

#include "haptogram/base/error.hpp"

namespace haptogram::serve {
namespace {

constexpr unsigned most_nested = 8;  // bundles in bundles

/// Takes parts from the front of a datagram; everything in OSC fills up to whole words of four bytes.
class Parts {
public:
    explicit Parts(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

    [[nodiscard]] bool empty() const { return rest_.empty(); }

    std::span<const std::uint8_t> take(std::size_t count) {
        if (count > rest_.size()) throw bad_input("OSC", "the datagram is cut short");
        const auto taken = rest_.first(count);
        rest_ = rest_.subspan(count);
        return taken;
    }

    std::string text() {
        const void* const end = rest_.empty() ? nullptr : std::memchr(rest_.data(), 0, rest_.size());
        if (end == nullptr) throw bad_input("OSC", "a text has no end");
        const auto length = static_cast<std::size_t>(static_cast<const std::uint8_t*>(end) - rest_.data());
        const auto taken = take((length + 4) / 4 * 4);
        return {reinterpret_cast<const char*>(taken.data()), length};
    }

    std::uint64_t big_endian(std::size_t bytes) {
        std::uint64_t value = 0;
        for (const std::uint8_t byte : take(bytes)) value = value << 8 | byte;
        return value;
    }

    std::uint32_t word() { return static_cast<std::uint32_t>(big_endian(4)); }

private:
    std::span<const std::uint8_t> rest_;
};

void take_argument(char type, Parts& parts, std::vector<double>& numbers) {
    switch (type) {
        case 'f': numbers.push_back(static_cast<double>(std::bit_cast<float>(parts.word()))); return;
        case 'i': numbers.push_back(static_cast<std::int32_t>(parts.word())); return;
        case 'd': numbers.push_back(std::bit_cast<double>(parts.big_endian(8))); return;
        case 'h': numbers.push_back(static_cast<double>(static_cast<std::int64_t>(parts.big_endian(8)))); return;
        case 'T': numbers.push_back(1.0); return;
        case 'F': numbers.push_back(0.0); return;
        case 't': static_cast<void>(parts.take(8)); return;
        case 's': static_cast<void>(parts.text()); return;
        case 'b': static_cast<void>(parts.take((parts.word() + std::size_t{3}) / 4 * 4)); return;
        default:
            throw bad_input("OSC",
                            std::string("an argument of the type '") + type + "'; expected numbers: f, i, d, h, T, F");
    }
}

void parse(std::span<const std::uint8_t> bytes, unsigned nested, bool timed, std::vector<OscMessage>& found) {
    if (bytes.size() % 4 != 0) throw bad_input("OSC", "the datagram is no whole number of words of four bytes");
    Parts parts(bytes);
    OscMessage message{parts.text(), {}, timed};
    if (message.address == "#bundle") {
        if (nested == most_nested) throw bad_input("OSC", "bundles in bundles without an end");
        constexpr std::uint64_t at_once = 1;
        if (parts.big_endian(8) != at_once) timed = true;
        while (!parts.empty()) {
            const std::uint32_t size = parts.word();
            parse(parts.take(size), nested + 1, timed, found);
        }
        return;
    }
    if (!message.address.starts_with('/')) throw bad_input("OSC", "an address begins with '/'");
    const std::string types = parts.empty() ? "," : parts.text();
    if (!types.starts_with(',')) throw bad_input("OSC", "the types of the arguments begin with ','");
    for (const char type : std::string_view(types).substr(1)) take_argument(type, parts, message.numbers);
    found.push_back(std::move(message));
}

}  // namespace

std::vector<OscMessage> parse_osc(std::span<const std::uint8_t> datagram) {
    std::vector<OscMessage> found;
    parse(datagram, 0, false, found);
    return found;
}

}  // namespace haptogram::serve
