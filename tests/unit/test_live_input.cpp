// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <string>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/live_input.hpp"
#include "haptogram/base/process.hpp"

using namespace haptogram;
using namespace std::chrono_literals;

TEST_CASE("live input: a pipe's writers come and go, and what is no pipe is refused") {
    const TemporaryFolder folder;
    const std::string path = (folder.path() / "lines").string();
    CHECK_REFUSED(LiveText::of_pipe(path, "lines"));
    std::ofstream(folder.path() / "file") << "go\n";
    CHECK_REFUSED(LiveText::of_pipe((folder.path() / "file").string(), "lines"));
    REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    LiveText text = LiveText::of_pipe(path, "lines");
    CHECK_FALSE(text.next(0ms));  // nobody is there, and it has not ended
    CHECK_FALSE(text.ended());
    for (const char* word : {"one", "two"}) {
        std::ofstream(path) << word << std::endl;
        CHECK(text.next(1000ms) == word);
        CHECK_FALSE(text.ended());
    }
    CHECK(text.where() == path + ":2");
}

TEST_CASE("live input: a line without an end is an error, and not memory without one") {
    const TemporaryFolder folder;
    const std::string path = (folder.path() / "long").string();
    const std::string fits(LiveText::longest_line - 1, 'x');
    std::ofstream(path) << "first\n" << fits << '\n' << std::string(2 * LiveText::longest_line, 'y');
    LiveText text(path);
    CHECK(text.next(1000ms) == "first");
    CHECK(text.next(1000ms) == fits);
    CHECK_REFUSED(text.next(1000ms));
}
