// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>

#include "haptogram/base/notice.hpp"
#include "haptogram/live/scene_output.hpp"

using namespace haptogram;

namespace {

/// A pipe that nobody reads, as standard output of what is tested.
class Unread {
public:
    Unread() {
        REQUIRE(::pipe(ends_.data()) == 0);
        before_ = ::dup(STDOUT_FILENO);
        ::dup2(ends_[1], STDOUT_FILENO);
    }
    Unread(const Unread&) = delete;
    Unread& operator=(const Unread&) = delete;
    ~Unread() {
        ::dup2(before_, STDOUT_FILENO);
        for (const int end : {ends_[0], ends_[1], before_}) ::close(end);
    }
    [[nodiscard]] std::string read() const {
        std::string all(1 << 21, '\0');
        all.resize(static_cast<std::size_t>(::read(ends_[0], all.data(), all.size())));
        return all;
    }

private:
    std::array<int, 2> ends_{};
    int before_ = -1;
};

}  // namespace

TEST_CASE("notices: what a terminal would obey is written as what it is, and no more than fits") {
    CHECK(printable("a foc\u00fcs at 3\u00b5m\n\tok") == "a foc\u00fcs at 3\u00b5m\n\tok");
    CHECK(printable("\x1b]0;x\x07\r\x7f") == "\\x1b]0;x\\x07\\x0d\\x7f");
    CHECK(printable("\x9b"
                    "31m") == "\\x9b31m");  // no UTF-8
    CHECK(printable("\xc2\x9b"
                    "31m") == "\\xc2\\x9b31m");  // U+009B
    CHECK(printable("\xe2\x82") == "\\xe2\\x82");
    CHECK(printable(std::string(100, 'x'), 10) == "xxxxxxxxxx\u2026");
    CHECK(printable("12345678\x1b", 10) == "12345678\u2026");
}

TEST_CASE("notices: a pipe that nobody reads holds nobody up, and lines through it stay whole") {
    std::uint64_t dropped = 0;
    std::string read;
    {
        const Unread pipe;
        LineOutput output("-");
        for (int i = 0; i < 3000; ++i) output.write(std::string(99, static_cast<char>('a' + i % 26)));
        dropped = output.dropped();
        read = pipe.read();
        output.write("last");
        read += pipe.read();
    }
    CHECK(dropped > 0);
    CHECK(read.size() <= 100 * (3000 - dropped) + 5);
    CHECK(read.ends_with("\nlast\n"));
    for (std::size_t at = 0, end = 0; (end = read.find('\n', at)) != std::string::npos; at = end + 1) {
        const std::string line = read.substr(at, end - at);
        CHECK((line == "last" || line == std::string(99, line.front())));
    }
}
