// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "../real_time.hpp"
#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/serial_port.hpp"

using namespace haptogram;

namespace {

/// A pseudo-terminal.
struct Terminal {
    Terminal() : master(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
        REQUIRE(master >= 0);
        REQUIRE(::grantpt(master) == 0);
        REQUIRE(::unlockpt(master) == 0);
        REQUIRE(::ptsname_r(master, name.data(), name.size()) == 0);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;
    ~Terminal() { ::close(master); }

    int master;
    std::array<char, 64> name{};
};

}  // namespace

TEST_CASE("serial port: programs that are started meanwhile do not have it", "[link]") {
    const Terminal terminal;
    const auto& [master, name] = terminal;
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
        REQUIRE_REFUSED(link::SerialPort(name.data(), 1'000'000));
        FILE* const other = ::popen("echo begun; sleep 0.5", "r");
        REQUIRE(other != nullptr);
        REQUIRE(std::fgetc(other) == 'b');  // from here on it runs, and has what it has
        port.reset();
        REQUIRE_NOTHROW(link::SerialPort(name.data(), 1'000'000));
        CHECK(::pclose(other) == 0);
    }
    SECTION("a signal while it takes no bytes does not end it") {
        struct sigaction quiet {};
        quiet.sa_handler = [](int) {};  // without SA_RESTART
        struct sigaction before {};
        REQUIRE(::sigaction(SIGUSR1, &quiet, &before) == 0);
        const std::vector<std::uint8_t> sent(1 << 16, 'x');  // more than a pseudo-terminal holds
        std::size_t arrived = 0;
        std::thread other([&, writer = ::pthread_self()] {
            for (int signals = 0; signals < 100; ++signals) {
                ::pthread_kill(writer, SIGUSR1);
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            std::array<char, 4096> bytes{};
            for (ssize_t count = 1; arrived < sent.size() && count > 0; arrived += static_cast<std::size_t>(count))
                count = ::read(master, bytes.data(), bytes.size());
        });
        CHECK_NOTHROW(port->write(sent));
        port.reset();  // so that the other's read ends, whatever was written
        other.join();
        CHECK(arrived == sent.size());
        ::sigaction(SIGUSR1, &before, nullptr);
    }
}

TEST_CASE("serial port: one that takes no bytes is given up, after a signal soon", "[link][real-time]") {
    const Terminal terminal;
    link::SerialPort port(terminal.name.data(), 1'000'000);
    unsigned signals = 0;
    port.set_interrupt([&] { return signals; });
    const std::vector<std::uint8_t> more(1 << 16, 'x');  // than a pseudo-terminal holds
    for (const auto& [asked, seconds] : {std::pair(1U, 1.0), {2U, 0.1}, {0U, 10.0}}) {
        signals = asked;
        const test::StopWatch watch;
        CHECK_REFUSED(port.write(more));
        test::compare(fmt::format("a port that takes no bytes, after {} signals", asked), watch.seconds(), seconds,
                      "s");
    }
}
