// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "haptogram/base/error.hpp"
#include "haptogram/link/serial_port.hpp"

using namespace haptogram;
using Catch::Contains;

TEST_CASE("serial port: programs that are started meanwhile do not have it", "[link]") {
    const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    REQUIRE(master >= 0);
    REQUIRE(::grantpt(master) == 0);
    REQUIRE(::unlockpt(master) == 0);
    std::array<char, 64> name{};
    REQUIRE(::ptsname_r(master, name.data(), name.size()) == 0);
    auto port = std::make_unique<link::SerialPort>(name.data(), 1'000'000);
    SECTION("its descriptor is closed when another program begins") {
        int found = 0;
        for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
            std::error_code gone;
            if (std::filesystem::read_symlink(entry.path(), gone) != name.data()) continue;
            ++found;
            CHECK((::fcntl(std::stoi(entry.path().filename().string()), F_GETFD) & FD_CLOEXEC) != 0);
        }
        CHECK(found == 1);
    }
    SECTION("it is free as soon as it is closed") {
        REQUIRE_THROWS_WITH(link::SerialPort(name.data(), 1'000'000), Contains("another program is using it"));
        FILE* const other = ::popen("echo begun; sleep 0.5", "r");
        REQUIRE(other != nullptr);
        REQUIRE(std::fgetc(other) == 'b');  // from here on it runs, and has what it has
        port.reset();
        REQUIRE_NOTHROW(link::SerialPort(name.data(), 1'000'000));
        CHECK(::pclose(other) == 0);
    }
    ::close(master);
}
