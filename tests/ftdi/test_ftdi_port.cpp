// SPDX-License-Identifier: Apache-2.0
// The host's own way to an FTDI chip, on chips that umockdev makes Linux seem to have.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <optional>

#include "../real_time.hpp"
#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/ftdi_port.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/transfer.hpp"
#include "usb_socket.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

constexpr std::string_view small16 = "small-16";  // its UART runs at 3 Mbaud
constexpr std::chrono::milliseconds patience{300};
constexpr std::chrono::seconds most_patience{10};

struct Bus {
    Reference<UMockdevTestbed> bed{umockdev_testbed_new()};
    std::deque<UsbSocket> sockets;
    UsbSocket& plug(FtdiChip& chip) {
        return sockets.emplace_back(bed.get(), static_cast<unsigned>(sockets.size() + 2), chip);
    }
};

Image small_image() {
    Image image;
    image.clock_hz = 50'000'000;
    image.channels = 16;
    image.timing_bits = 12;
    for (std::uint16_t n = 1; n <= 20; ++n) {
        image.records.push_back({1250, 1, 100, std::vector<std::uint16_t>(image.channels, n)});
        image.sequence.push_back({n, 1});
    }
    return image;
}

heard::Refusal refusal(const std::string& name, std::uint32_t baud = 3'000'000) {
    try {
        const link::FtdiPort port(name, baud);
    } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::device);
        return heard::Refusal(error);
    }
    return {};
}

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, decltype(&pclose)> pipe(popen((HAPTOGRAM_PROGRAM " " + command).c_str(), "r"), pclose);
    std::string output;
    for (int letter = std::getc(pipe.get()); letter != EOF; letter = std::getc(pipe.get()))
        output += static_cast<char>(letter);
    return output;
}

}  // namespace

TEST_CASE("an image goes to the board behind an FTDI chip and comes back", "[ftdi]") {
    const ChipType type = GENERATE(ft2232h, ft231x);
    sim::SimulatedBoard board(small16);
    FtdiChip chip(type, "HG01", &board);
    Bus bus;
    UsbSocket& socket = bus.plug(chip);
    {
        const auto port = link::open_port("ftdi:", board.parameters().baud);
        REQUIRE(socket.owner == "usbfs");
        REQUIRE(chip.baud() == board.parameters().baud);
        link::Client client(*port);
        client.set_patience(patience, most_patience);
        const link::Identity identity = client.identify();
        REQUIRE(identity.channels == 16);
        const Image image = small_image();
        link::require_fits(image, identity, "image");
        const link::Uploaded uploaded = link::upload(client, image);
        REQUIRE(uploaded.written > image.records.size());   // records and sequence
        REQUIRE(link::upload(client, image).written == 0);  // by the board's digests
        REQUIRE(link::compare(client, image).empty());
        REQUIRE(link::download(client, identity, 0, "board") == image);
        Image other = image;
        other.records[7].timings[3] ^= 1U;
        REQUIRE_SAID(link::compare(client, other));
        client.set_watchdog(0);
        client.enable();
        const link::Status status = client.status();
        REQUIRE(status.enabled);
        REQUIRE(status.frames_damaged == 0);
    }
    REQUIRE(socket.owner == "ftdi_sio");  // whose it was
}

TEST_CASE("a chip is set to 8N1 at the rate, without flow control and without holding bytes back", "[ftdi]") {
    const auto [type, baud] = GENERATE(table<ChipType, std::uint32_t>({{ft2232h, 12'000'000},
                                                                       {ft2232h, 8'000'000},
                                                                       {ft2232h, 3'000'000},
                                                                       {ft2232h, 115'200},
                                                                       {ft231x, 3'000'000},
                                                                       {ft231x, 2'000'000},
                                                                       {ft231x, 115'200}}));
    FtdiChip chip(type, "HG01");
    Bus bus;
    bus.plug(chip);
    const link::FtdiPort port("ftdi:", baud);
    REQUIRE(chip.baud() == Approx(baud).epsilon(0.002));
    REQUIRE(chip.settings.latency_ms == 1);
    REQUIRE(chip.settings.line == 8);
    REQUIRE(chip.settings.flow == 0);
    REQUIRE(chip.settings.bit_mode == 0);
    REQUIRE(chip.settings.flushes >= 2);  // both ways
}

TEST_CASE("a rate that the chip cannot make is refused and said", "[ftdi]") {
    FtdiChip chip(ft231x, "HG01");
    Bus bus;
    bus.plug(chip);
    REQUIRE_REFUSAL(refusal("ftdi:", 12'000'000));
    REQUIRE_REFUSAL(refusal("ftdi:", 1'455'000));  // 3 % off
}

TEST_CASE("nothing comes: read waits as long as it was told, and no longer", "[ftdi][real-time]") {
    FtdiChip chip(ft2232h, "HG01");
    Bus bus;
    bus.plug(chip);
    link::FtdiPort port("ftdi:", 3'000'000);
    const test::StopWatch watch;
    REQUIRE(port.read(std::chrono::milliseconds(50)).empty());
    const double waited = watch.seconds();
    REQUIRE(waited >= 0.05);
    test::compare("a read of an FTDI chip that waits for 50 ms", waited, 0.05, "s");
    REQUIRE(port.read(std::chrono::microseconds(0)).empty());
}

TEST_CASE("pulling the cable ends reading and writing with an error that says so", "[ftdi]") {
    sim::SimulatedBoard board(small16);
    FtdiChip chip(ft2232h, "HG01", &board);
    Bus bus;
    UsbSocket& socket = bus.plug(chip);
    link::FtdiPort port("ftdi:", board.parameters().baud);
    link::Client client(port);
    client.set_patience(patience, most_patience);
    client.identify();
    socket.unplug();
    REQUIRE_REFUSED(client.status());
    REQUIRE_THROWS_AS(static_cast<void>(port.read(patience)), link::LinkLost);
    REQUIRE_THROWS_AS(port.write(Bytes{0}), link::LinkLost);
}

TEST_CASE("a chip that another program uses is left to it", "[ftdi]") {
    FtdiChip chip(ft2232h, "HG01");
    Bus bus;
    UsbSocket& socket = bus.plug(chip);
    socket.owner = "usbfs";
    REQUIRE_REFUSAL(refusal("ftdi:"));
    REQUIRE(socket.owner == "usbfs");
    socket.owner.clear();
    const link::FtdiPort port("ftdi:", 3'000'000);
    REQUIRE_REFUSAL(refusal("ftdi:"));
}

TEST_CASE("a chip that one may not open: what to do", "[ftdi]") {
    FtdiChip chip(ft2232h, "HG01");
    Bus bus;
    UsbSocket& socket = bus.plug(chip);
    const std::unique_ptr<char, decltype(&g_free)> folder(umockdev_testbed_get_root_dir(bus.bed.get()), g_free);
    const std::string root = folder.get();
    REQUIRE(chmod((root + socket.node()).c_str(), 0) == 0);
    for (const std::string& used : {root, root + "/ioctl" + socket.node()})  // umockdev's own, by any user
        REQUIRE(chmod(used.c_str(), 0777) == 0);
    constexpr uid_t nobody = 65534;
    const bool is_root = geteuid() == 0;  // who may open everything
    if (is_root) REQUIRE(seteuid(nobody) == 0);
    const heard::Refusal any = refusal("ftdi:");
    const heard::Refusal by_serial = refusal("ftdi:0403:6010:HG01");
    const auto devices = link::ftdi_devices();
    if (is_root) REQUIRE(seteuid(0) == 0);
    REQUIRE_REFUSAL(any);
    REQUIRE_REFUSAL(by_serial);
    REQUIRE(devices.size() == 1);
    REQUIRE(devices[0].name == "ftdi:0403:6010");
}

TEST_CASE("names: as much as tells one chip from the others", "[ftdi]") {
    REQUIRE(link::ftdi_devices().empty());
    FtdiChip first(ft2232h, "HG01");
    FtdiChip second(ft2232h, "HG02");
    FtdiChip third(ft231x, "HG03");
    Bus bus;
    REQUIRE_REFUSAL(refusal("ftdi:"));
    for (FtdiChip* chip : {&first, &second, &third}) bus.plug(*chip);
    for (const char* name : {"ftdi:0403:6010:HG02", "ftdi:0403:6015", "ftdi:0403:6015:HG03"}) {
        const link::FtdiPort port(name, 1'000'000);
        REQUIRE((bus.sockets[0].owner == "usbfs") == false);
        REQUIRE((bus.sockets[1].owner == "usbfs") == (std::string(name) == "ftdi:0403:6010:HG02"));
    }
    for (const char* name : {"ftdi:", "ftdi:0403:6010"}) REQUIRE_REFUSAL(refusal(name));
    for (const char* name :
         {"ftdi:0403:6014", "ftdi:0403:6010:HG0", "ftdi:0403:6010:hg01", "ftdi:x", "ftdi:0403:6010:"})
        REQUIRE_REFUSAL(refusal(name));
}

TEST_CASE("names: a chip with numbers that are not FTDI's own is only found by them", "[ftdi]") {
    ChipType type = ft231x;
    type.product = 0xcff8;
    FtdiChip chip(type, "");
    Bus bus;
    bus.plug(chip);
    REQUIRE_REFUSAL(refusal("ftdi:"));
    for (const char* name : {"ftdi:0403:cff8", "ftdi:0403:CFF8"}) REQUIRE(refusal(name).identity == "no error");
}

TEST_CASE("the program lists FTDI chips and speaks to a board behind one", "[ftdi]") {
    sim::SimulatedBoard board(small16);
    FtdiChip chip(ft2232h, "HG01", &board);
    Bus bus;
    bus.plug(chip);
    REQUIRE_THAT(output_of("device list"), Catch::Contains("ftdi:0403:6010:HG01 Emulated board\n"));
    REQUIRE_THAT(output_of("device info --port ftdi: --baud 3000000 --json"), Catch::Contains("\"channels\": 16"));
}
