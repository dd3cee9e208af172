// SPDX-License-Identifier: Apache-2.0
// What a board with an SDRAM reads out of its flash at power-up: a whole image plays, and nothing else does.
#include "../refusal.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;
using interface::Command;
using interface::Flash;

namespace {

constexpr std::uint32_t first = interface::flash_image::first;

/// Records of pulses that end before their cycle does, so that none merges with one from before the check.
Image three() {
    auto g = generator();
    const auto one = [&g](std::uint32_t cycle, std::uint32_t prescaler, std::uint8_t pulse) {
        Record r{cycle, prescaler, pulse, {}};
        for (int k = 0; k < 16; ++k) r.timings.push_back(static_cast<std::uint16_t>(random(g, 0, cycle - pulse - 1)));
        return r;
    };
    return image_of(16, {one(250, 5, 100), one(250, 5, 60), one(400, 3, 90)});
}

/// Powers up with these bytes in the flash, and runs until they must have been read.
void power_up(Bench& bench, const Bytes& flash) {
    bench.board.write_flash(first, flash);
    bench.board.reset();
    bench.board.run(40'000 + 32 * flash.size());
}

/// Whether outputs were on, or a pin high, in any of so many clocks.
bool ever_on(Bench& bench, std::uint64_t clocks) {
    return bench.board.run_until([&] { return bench.board.outputs().enabled || bench.board.any_pin(); }, clocks);
}

Flash said(Bench& bench) {
    bench.client.identify();
    return bench.client.status().flash;
}

}  // namespace

TEST_CASE("flash: a whole image plays at power-up, with no host and no watchdog, and each pulse is right", "[flash]") {
    Bench bench;
    const Image image = three();
    power_up(bench, link::flash_image(image, true, "image"));
    REQUIRE(bench.board.outputs().enabled);
    bench.board.run(500'000);  // the watchdog's 5 ms are over
    REQUIRE(bench.board.outputs().enabled);
    require_equal(bench.check(image), 1000);
    REQUIRE(said(bench) == Flash::whole);
    const link::Status status = bench.client.status();
    REQUIRE((status.mode == link::Mode::sequence && status.watchdog_ms == 0 && status.frames_damaged == 0));
    bench.client.stop();
    REQUIRE(bench.client.status().flash == Flash::whole);
}

TEST_CASE("flash: an image that is not to start lies in the memories", "[flash]") {
    Bench bench;
    const Image image = three();
    bench.board.write_flash(first, link::flash_image(image, false, "image"));
    bench.board.reset();
    REQUIRE_FALSE(ever_on(bench, 80'000));
    REQUIRE(said(bench) == Flash::whole);
    REQUIRE(link::holds(bench.client, image));
    bench.client.enable();
    bench.client.start(0, 0, 0);
    bench.wait_for_index(2);
}

TEST_CASE("flash: an image with a damaged byte does not play, and the board says so", "[flash]") {
    Bench bench;
    const Bytes whole = link::flash_image(three(), true, "image");
    auto g = generator();
    for (int i = 0; i < 60; ++i) {
        Bytes flash = whole;
        const std::size_t place =
            i == 0 ? flash.size() - 3 : random(g, 1, static_cast<std::uint32_t>(flash.size() - 1));
        flash[place] =
            static_cast<std::uint8_t>(flash[place] ^ (i % 3 == 0 ? 1U << random(g, 0, 7) : random(g, 1, 255)));
        CAPTURE(i, place, static_cast<int>(whole[place]), static_cast<int>(flash[place]));
        bench.board.write_flash(first, flash);
        bench.board.reset();
        REQUIRE_FALSE(ever_on(bench, 60'000 + 32 * flash.size()));
        // A zero in the place of the first frame's first byte makes an image of no frame.
        REQUIRE(said(bench) == (place == 1 && flash[place] == 0 ? Flash::none : Flash::broken));
    }
}

TEST_CASE("flash: a frame whose first byte is damaged to a zero is not the image's end", "[flash]") {
    Bench bench;
    const Bytes whole = link::flash_image(three(), true, "image");
    for (std::size_t place = 2; place + 2 < whole.size(); ++place) {
        if (whole[place - 1] != 0) continue;
        CAPTURE(place);
        Bytes flash = whole;
        flash[place] = 0;
        bench.board.write_flash(first, flash);
        bench.board.reset();
        REQUIRE_FALSE(ever_on(bench, 60'000 + 32 * flash.size()));
        REQUIRE(said(bench) == Flash::broken);
    }
}

TEST_CASE("flash: an image that ends early does not play", "[flash]") {
    Bench bench;
    const Bytes whole = link::flash_image(three(), true, "image");
    for (const std::size_t left : {whole.size() - 1, whole.size() - 2, whole.size() - 3, whole.size() / 2}) {
        CAPTURE(left);
        bench.board.write_flash(first, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(left)));
        bench.board.reset();
        REQUIRE_FALSE(ever_on(bench, 60'000 + 32 * (left + 4200)));
        REQUIRE(said(bench) == Flash::broken);
    }
}

TEST_CASE("flash: a frame less among more than there are numbers is noticed", "[flash]") {
    const Image image = three();
    const Bytes whole = link::flash_image(image, true, "image");
    for (const bool lost : {false, true}) {
        Bench bench;
        // IDENTIFY and two writes of the same, one of which may be missing; 257 frames later their numbers come again.
        Bytes flash(whole.begin(), whole.begin() + 1);
        std::uint8_t number = 0;
        const auto add = [&](Command command, std::span<const std::uint8_t> payload, bool missing = false) {
            const Bytes frame = link::encode_request(number++, command, payload);
            if (!missing) flash.insert(flash.end(), frame.begin(), frame.end());
        };
        add(Command::identify, {});
        const Bytes a_word = words({0, 0, 1});
        for (int i = 0; i < 300; ++i) add(Command::write, a_word, lost && i == 20);
        std::vector<link::Piece> pieces;
        cut(pieces, interface::primary_base, primary_words(image), 40);
        auto sequence = sequence_words(image);
        interface::sequence_header_field::autostart.set(sequence, 1);
        cut(pieces, interface::sequence_base, sequence, 40);
        for (const link::Piece& piece : pieces) add(Command::write, link::writing(piece).payload);
        flash.insert(flash.end(), 2, 0);
        power_up(bench, flash);
        REQUIRE(bench.board.outputs().enabled != lost);
        REQUIRE(said(bench) == (lost ? Flash::broken : Flash::whole));
    }
}

TEST_CASE("flash: who speaks while an image is read ends that, and is understood", "[flash]") {
    const Bytes flash = link::flash_image(three(), true, "image");
    for (const std::uint64_t clocks : {20'000U, 23'017U, 26'000U}) {
        CAPTURE(clocks);
        Bench bench;
        bench.board.write_flash(first, flash);
        bench.board.reset();
        bench.board.run(clocks);
        REQUIRE(said(bench) == Flash::broken);
        REQUIRE_FALSE(ever_on(bench, 100'000));
        bench.client.enable();
        REQUIRE(bench.board.outputs().enabled);
    }
    Bench early;
    early.board.write_flash(first, flash);
    early.board.reset();
    early.board.run(1000);
    REQUIRE(said(early) == Flash::none);
    REQUIRE_FALSE(ever_on(early, 100'000));
    Bench broken;  // by a break of the line
    broken.board.write_flash(first, flash);
    broken.board.reset();
    broken.board.run(22'000);
    broken.board.force_line(false);
    broken.board.run(2000);
    broken.board.force_line({});
    REQUIRE_FALSE(ever_on(broken, 100'000));
    REQUIRE(said(broken) == Flash::broken);
}

TEST_CASE("flash: the first frame of who speaks while an image is read needs no zero before it", "[flash]") {
    const Bytes flash = link::flash_image(three(), true, "image");
    for (std::uint64_t clocks = 20'000; clocks < 20'064; clocks += 5) {
        CAPTURE(clocks);
        Bench bench;
        bench.board.write_flash(first, flash);
        bench.board.reset();
        bench.board.run(clocks);
        bench.board.send(link::encode_request(9, Command::identify, {}));
        bench.board.run(40'000);
        std::vector<link::Reply> replies;
        link::ReplyDecoder decoder;
        decoder.feed(bench.board.receive(), replies);
        REQUIRE(replies.size() == 1);
        REQUIRE(replies[0].sequence == 9);
        REQUIRE(said(bench) == Flash::broken);
    }
}

TEST_CASE("flash: without an image nothing plays, whatever the sequence memory holds", "[flash]") {
    Bench bench;
    bench.load(three());
    interface::sequence_header_field::autostart.set(bench.board.sequence_memory(), 1);
    for (const Bytes& flash : {Bytes{}, Bytes(1000, 0), Bytes(1000, 0xff), Bytes{0x48, 0, 0}}) {
        bench.board.write_flash(first, flash);
        bench.board.reset();
        REQUIRE_FALSE(ever_on(bench, 120'000));
        REQUIRE(said(bench) == Flash::none);
    }
}

TEST_CASE("flash: an image that is larger than the flash is refused", "[flash]") {
    Image image = image_of(16, std::vector<Record>(70'000, record(16, 250, 5, 100, 0)));
    image.sequence = {{1, 1}};
    REQUIRE_REFUSED(link::flash_image(image, true, "an image"));
}
