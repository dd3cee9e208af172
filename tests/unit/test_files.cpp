// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "../refusal.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/live_input.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/pulses.hpp"

using namespace haptogram;
namespace fs = std::filesystem;

namespace {

struct Folder : TemporaryFolder {
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path()), fs::directory_iterator()));
    }
};

std::string array_text(const std::string& body) { return "[array]\nrows = 2\ncolumns = 2\npitch_mm = 10.0\n" + body; }

}  // namespace

TEST_CASE("files: sha256 against the standard's test vectors", "[files]") {
    REQUIRE(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    REQUIRE(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    REQUIRE(sha256(std::string(1'000'000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    // Every length about the ends of blocks: python3 -c 'from hashlib import sha256 as h
    // print(h("".join(h(b"a" * n).hexdigest() for n in range(201)).encode()).hexdigest())'
    std::string all;
    for (std::size_t n = 0; n <= 200; ++n) all += sha256(std::string(n, 'a'));
    REQUIRE(sha256(all) == "eb555248bd20c7831e511d4461b42c9b084e3a64b44d57b00051172f8afe03ff");
}

TEST_CASE("files: a failed write leaves what was there and nothing beside it", "[files]") {
    Folder folder;
    const fs::path a = folder.path() / "a";
    const fs::path b = folder.path() / "b";
    write_file(a, "old");
    REQUIRE_REFUSED(write_files({{a, "new"}, {folder.path() / "no/such/folder", "x"}}));
    REQUIRE(read_file(a) == "old");
    // A full disk, as the kernel tells of it.
    const rlimit limited = {1000, RLIM_INFINITY};
    rlimit before{};
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
    std::signal(SIGXFSZ, SIG_IGN);
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &limited) == 0);
    const heard::Refusal refused = heard::refusal_of([&] { write_files({{b, "small"}, {a, std::string(5000, 'x')}}); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    REQUIRE_REFUSAL(refused);
    REQUIRE(read_file(a) == "old");
    REQUIRE_FALSE(fs::exists(b));
    REQUIRE(folder.files() == 1);
}

TEST_CASE("files: what is not whole has no name, so nothing stays of it when the program is killed", "[files]") {
    Folder folder;
    const int nameless = ::open(folder.path().c_str(), O_TMPFILE | O_RDWR, 0600);
    if (nameless < 0) {
        WARN("not tested: this file system knows no files without a name");
        return;
    }
    ::close(nameless);
    {
        StagedFile given_up(folder.path() / "a");
        given_up.fill("x");
        CHECK(folder.files() == 0);
    }
    StagedFile file(folder.path() / "a");
    file.fill("whole");
    CHECK(folder.files() == 0);
    // A library that writes by name may put another file in its place.
    fs::remove(file.beside());
    write_file(file.beside(), "written by name");
    file.commit();
    CHECK(folder.files() == 1);
    CHECK(read_file(folder.path() / "a") == "written by name");
}

TEST_CASE("files: a device that has no end is refused", "[files]") { REQUIRE_REFUSED(read_file("/dev/zero")); }

TEST_CASE("files: a named pipe is read whole, and nobody waits for ever for who writes into it", "[files]") {
    using namespace std::chrono_literals;
    const Folder folder;
    const fs::path pipe = folder.path() / "pipe";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    std::string nothing;
    CHECK_FALSE(LiveInput(pipe).read(nothing, 1ms));
    const std::string content(100'000, 'x');  // more than a pipe holds
    std::thread writer([&] {
        std::ofstream out(pipe);
        out << content.substr(0, 10) << std::flush;
        std::this_thread::sleep_for(20ms);
        out << content.substr(10);
    });
    CHECK(read_file(pipe) == content);
    writer.join();
}

TEST_CASE("files: permissions and symbolic links survive a rewrite", "[files]") {
    Folder folder;
    const fs::path file = folder.path() / "file";
    const fs::path link = folder.path() / "link";
    write_file(file, "1");
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink(file, link);
    write_file(link, "2");
    REQUIRE(fs::is_symlink(link));
    REQUIRE(read_file(file) == "2");
    REQUIRE(fs::status(file).permissions() == (fs::perms::owner_read | fs::perms::owner_write));
    REQUIRE_REFUSED(read_file(folder.path() / "none"));
    REQUIRE_REFUSED(read_file(folder.path()));
    REQUIRE_REFUSED(write_file(folder.path(), "x"));
}

TEST_CASE("array files: the shipped ones", "[array]") {
    const Array tile = find_array("tile-10x10");
    REQUIRE(tile.elements.size() == 100);
    REQUIRE(tile.elements[0].position.x == Approx(-0.045));
    REQUIRE(tile.elements[0].position.y == Approx(-0.045));
    REQUIRE(tile.elements[1].position.x == Approx(-0.035));  // channel = row · columns + column
    REQUIRE(tile.elements[10].position.y == Approx(-0.035));
    REQUIRE(tile.medium.speed_m_s == Approx(343.2).margin(0.05));
    REQUIRE(find_array("hoshi-18x18").elements.size() == 324);
    REQUIRE_REFUSED(find_array("nonesuch"));
}

TEST_CASE("array files: speed of sound", "[array]") {
    REQUIRE(speed_of_sound(15) == Approx(340.3).margin(0.06));
    REQUIRE(speed_of_sound(20) == Approx(343.2).margin(0.06));
    REQUIRE(speed_of_sound(30) == Approx(349.0).margin(0.1));
}

TEST_CASE("array files: explicit elements, and every mistake named with its line", "[array]") {
    Folder folder;
    const fs::path file = folder.path() / "a.toml";
    write_file(file, "[array]\nelements_mm = [[0, 0], [1.5, -2]]\n");
    const Array array = load_array(file);
    REQUIRE(array.elements.size() == 2);
    REQUIRE(array.elements[1] == Element{from_mm(1.5, -2, 0)});
    REQUIRE(array.nearest_m == Approx(10.0 * 81e-6 / (4.0 * array.wavelength_m())));
    const std::string text = GENERATE(
        as<std::string>{}, "", "[array\n", "[array]\nrows = 2\n", array_text("elements_mm = [[1,2]]\n"),
        array_text("colour = 3\n"), array_text("carrier_hz = \"fast\"\n"), array_text("carrier_hz = nan\n"),
        array_text("duty = 0.7\n"), array_text("[medium]\nspeed_m_s = 340\ntemperature_c = 20\n"),
        array_text("[board]\nchannels = 3\n"), array_text("[board]\nclock_hz = 50.5\n"), array_text("[boards]\n"),
        "array = 3\n", "[array]\nelements_mm = [[0, 0], [1]]\n", "[array]\nelements_mm = []\n",
        "[array]\nelements_mm = [[5, 5, 1], [0, 0],\n [1, 0], [5, 5],\n [1, 1], [0, 0, -0.0]]\n");
    CAPTURE(text);
    write_file(file, text);
    const auto load = [&] {
        const Array read = load_array(file);
        require_channels(read, core_of_array(file.string()));
    };
    REQUIRE_REFUSED(load());
}

TEST_CASE("array files: the largest grid is read at once", "[array]") {
    Folder folder;
    const fs::path file = folder.path() / "large.toml";
    write_file(file, "[array]\nrows = 1000\ncolumns = 1000\npitch_mm = 10\n");
    REQUIRE(load_array(file).elements.size() == 1'000'000);
    // A list is looked through for elements at the same place, which must not take a comparison of each with each.
    std::string list = "[array]\nelements_mm = [";
    for (int i = 0; i < 100'000; ++i) list += fmt::format("[{}, {}],\n", i % 317, i / 317);
    write_file(file, list + "]\n");
    REQUIRE(load_array(file).elements.size() == 100'000);
}

TEST_CASE("array: reach", "[array]") {
    const Array array = find_array("tile-10x10");
    REQUIRE(array.unreachable(from_mm(0, 0, 130)).empty());
    REQUIRE_SAID(array.unreachable(from_mm(0, 0, 0)));
    REQUIRE_SAID(array.unreachable(from_mm(0, 0, -10)));
    REQUIRE_SAID(array.unreachable(from_mm(5, 5, 20)));
    REQUIRE_SAID(array.unreachable(from_mm(200, 0, 100)));
}

TEST_CASE("manifest: what is written is read back, what is missing is named", "[manifest]") {
    Manifest m;
    m.array = find_array("hoshi-18x18");
    m.timer = {50e6, 5, 250, 125};
    m.core = find_configuration("hoshi-324");
    m.records = {{{{from_mm(1, 2, 130)}}, 1.0, 20},
                 {{{from_mm(-1.25, 0, 140), 0.5}, {from_mm(0, 3, 140)}}, 0.25, 21},
                 {{{from_mm(2, 0, 140)}}, 0.5, 1}};
    m.array.elements[5].normal = {0.6, 0.0, 0.8};
    m.rate_hz = 10;
    m.formation = {1e-4, 4, 1.1e-4, 3.6e-4};
    m.input_sha256 = "aa";
    m.image_sha256 = "bb";
    const std::string text = to_json(m).dump(1);
    const Manifest back = manifest_from_json(text, "m");
    REQUIRE(to_json(back).dump(1) == text);
    REQUIRE(back.points() == m.points());
    REQUIRE(back.records[1].foci == m.records[1].foci);
    REQUIRE(back.records[1].amplitude == 0.25);
    REQUIRE(back.array.elements[5] == m.array.elements[5]);
    REQUIRE_REFUSED(manifest_from_json("{", "m.json"));
    REQUIRE_REFUSED(manifest_from_json("[]", "m"));
    for (const char* key : {"format", "timer", "array", "records", "image_sha256", "board"}) {
        auto json = to_json(m);
        json.erase(key);
        REQUIRE_REFUSED(manifest_from_json(json.dump(), "m"));
    }
    auto json = to_json(m);
    json["records"][0]["focus_mm"] = {1, 2};
    REQUIRE_THROWS_AS(manifest_from_json(json.dump(), "m"), Error);
    m.array.elements[3].weight = 0.25;
    json = to_json(m);
    REQUIRE(manifest_from_json(json.dump(), "m").array.elements[3].weight == 0.25);
    for (const double weight : {0.0, -0.5, 1.001, 1e300}) {
        json["array"]["responses"][3][2] = weight;
        REQUIRE_REFUSED(manifest_from_json(json.dump(), "m"));
    }
}

TEST_CASE("pulse files: round trip, and damage named with its line", "[pulses]") {
    const std::vector<Pulse> pulses = {{10, 20, 3, 1}, {123456789012, 123456789013, 99, 65535}};
    const std::string text = to_csv(pulses);
    REQUIRE(text == "channel,rise_clk,fall_clk,index\n3,10,20,1\n99,123456789012,123456789013,65535\n");
    REQUIRE(pulses_from_csv(text, "p") == pulses);
    const std::string header = "channel,rise_clk,fall_clk,index\n";
    for (const char* line :
         {"1,2,3\n", "1,2,3,4,5\n", "1,5,5,1\n", "a,1,2,3\n", "1,2,3,70000\n", "1, 2,3,4\n", "-1,2,3,4\n", "\n"})
        REQUIRE_REFUSED(pulses_from_csv(header + "0,1,2,1\n" + line, "p"));
    REQUIRE_REFUSED(pulses_from_csv(header + "0,1,2,1", "p"));
    REQUIRE_REFUSED(pulses_from_csv("x\n", "p"));
}
