// SPDX-License-Identifier: Apache-2.0
// Playing in steps, for who may not wait: what is sent is what the waiting client sends, and whatever ends it, outputs
// go off.
#include <catch2/catch.hpp>
#include <map>

#include "../refusal.hpp"
#include "../virtual_clock.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/step_player.hpp"
#include "timed_line.hpp"

using namespace haptogram;
using namespace haptogram::test;
using namespace std::chrono_literals;
using interface::Command;
using link::Connection;
using Stage = link::StepWork::Stage;

namespace {

/// What a line has carried to its device: commands with their payloads, without numbers and checks.
struct Carried {
    std::vector<std::pair<Command, Bytes>> requests;
    Bytes frame;
    void take(std::span<const std::uint8_t> bytes) {
        for (const std::uint8_t byte : bytes) {
            if (byte != 0) {
                frame.push_back(byte);
                continue;
            }
            if (const auto decoded = link::cobs_decode(std::exchange(frame, {})); decoded && decoded->size() >= 4)
                requests.emplace_back(static_cast<Command>((*decoded)[1]),
                                      Bytes(decoded->begin() + 2, decoded->end() - 2));
        }
    }
    /// Of these commands.
    [[nodiscard]] std::vector<std::pair<Command, Bytes>> of(std::initializer_list<Command> commands) const {
        std::vector<std::pair<Command, Bytes>> found;
        for (const auto& each : requests)
            if (std::ranges::find(commands, each.first) != commands.end()) found.push_back(each);
        return found;
    }
};

/// A line that remembers what it carried. It may be one that is never waited for.
class Watched final : public link::Transport {
public:
    Watched(FakeDevice& device, const TimedLine::Settings& settings, Clock& clock, Carried& carried, bool waits)
        : line_(device, settings, clock), carried_(carried), waits_(waits) {}
    [[nodiscard]] Clock& clock() override { return line_.clock(); }
    void write(std::span<const std::uint8_t> bytes) override {
        carried_.take(bytes);
        line_.write(bytes);
    }
    std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        return line_.read(waits_ ? patience : 0us);
    }
    void discard_output() override { line_.discard_output(); }

private:
    TimedLine line_;
    Carried& carried_;
    bool waits_;
};

/// Small records, so that a pass over the line is short.
std::shared_ptr<const Image> image(std::uint16_t number, std::uint16_t records = 30) {
    Image made;
    made.channels = 100;
    made.clock_hz = 50'000'000;
    for (std::uint16_t i = 1; i <= records; ++i) {
        made.records.push_back({250, 5, 100, std::vector<std::uint16_t>(100, static_cast<std::uint16_t>(number + i))});
        made.sequence.push_back({i, 1});
    }
    return std::make_shared<const Image>(made);
}

/// A player with its device, which is stepped until something is so.
struct Bench {
    explicit Bench(const TimedLine::Settings& settings = {})
        : player(std::make_unique<Watched>(device, settings, clock, carried, false),
                 {.told = [this](const link::DeviceState& state) { states.push_back(state); },
                  .work = [this](const link::StepWork& one) { works.push_back(one); }}) {}

    template <class IsSo>
    void step_until(IsSo is_so, std::chrono::milliseconds at_most = 20s) {
        for (const Clock::Time end = clock.now() + at_most; !is_so();) {
            constexpr std::chrono::milliseconds each{1};
            clock.rest(each);
            REQUIRE(clock.now() < end);
            const Clock::Time before = clock.now();
            player.step(each);
            longest = std::max(longest, clock.now() - before);
        }
    }
    void connect() {
        step_until([&] { return player.state().connection == Connection::connected; });
    }
    [[nodiscard]] bool told(Stage stage) const {
        return std::ranges::any_of(works, [&](const auto& one) { return one.stage == stage; });
    }

    VirtualClock clock;
    FakeDevice device;
    Carried carried;
    std::vector<link::DeviceState> states;
    std::vector<link::StepWork> works;
    Clock::Time longest{0};
    link::StepPlayer player;
};

}  // namespace

TEST_CASE("step player: an upload is request by request the waiting client's, also a second one and one of a change") {
    Bench bench;
    bench.connect();
    FakeDevice other;
    Carried expected;
    link::Client client(std::make_unique<Watched>(other, TimedLine::Settings{}, bench.clock, expected, true));
    client.identify();
    const std::initializer_list<Command> of_uploads = {Command::digest, Command::write, Command::modulate};
    for (const std::uint16_t number : {std::uint16_t{10}, std::uint16_t{10}, std::uint16_t{11}}) {
        bench.works.clear();
        const std::uint64_t work = bench.player.upload(image(number));
        bench.step_until([&] { return bench.told(Stage::done); });
        const link::Uploaded uploaded = link::upload(client, *image(number));
        REQUIRE(bench.works.back().number == work);
        REQUIRE(bench.works.back().uploaded->pieces == uploaded.pieces);
        REQUIRE(bench.works.back().uploaded->written == uploaded.written);
        REQUIRE(bench.carried.of(of_uploads) == expected.of(of_uploads));
    }
    REQUIRE(bench.told(Stage::uploads));
    REQUIRE_FALSE(bench.device.enabled());
    REQUIRE(bench.longest == 0ms);  // a step never waits
}

TEST_CASE("step player: a sequence plays with the outputs on until its end, and then they are off") {
    Bench bench;
    bench.connect();
    bench.player.play(image(20));
    bench.step_until([&] { return bench.told(Stage::done); });  // the device plays everything at once
    REQUIRE(bench.carried.of({Command::watchdog, Command::enable, Command::start, Command::disable, Command::stop}) ==
            std::vector<std::pair<Command, Bytes>>{{Command::watchdog, {0xf4, 0x01}},
                                                   {Command::enable, {}},
                                                   {Command::start, {1, 0, 0, 0, 0, 0}},
                                                   {Command::disable, {}},
                                                   {Command::stop, {}}});
    REQUIRE_FALSE(bench.device.enabled());
    REQUIRE(bench.works.back().played.has_value());
    REQUIRE_FALSE(bench.player.drives());
}

TEST_CASE("step player: a record plays, becomes weaker, gives way to another, and STOP ends it at once") {
    Bench bench;
    bench.connect();
    const auto shown = image(30);
    bench.player.stream(shown, 3);
    REQUIRE(bench.player.drives());
    bench.step_until([&] { return bench.told(Stage::plays); });
    REQUIRE(bench.device.enabled());
    REQUIRE(bench.carried.of({Command::select}).back().second == Bytes{3, 0, 0, 0});
    bench.player.stream(shown, 7);
    bench.step_until([&] { return bench.carried.of({Command::select}).back().second == Bytes{7, 0, 0, 0}; });
    const std::size_t written = bench.carried.of({Command::write}).size();
    bench.player.set_intensity(0.5);
    // A carrier half as strong takes pulses of 39 ticks instead of 100: sin(π · 39.4 / 250) is half of sin(π · 100 /
    // 250).
    bench.step_until([&] { return bench.carried.of({Command::write}).size() == written + 30; });
    const Bytes weaker = bench.carried.of({Command::write}).back().second;
    REQUIRE(weaker.size() == 6);
    REQUIRE(weaker[4] < 50);
    REQUIRE_REFUSED(bench.player.stream(image(31), 1));
    REQUIRE_REFUSED(bench.player.stream(shown, 31));
    REQUIRE_REFUSED(bench.player.set_intensity(1.5));
    REQUIRE_REFUSED(bench.player.modulate(*shown));
    const auto asked = bench.clock.now();
    const std::uint64_t stop = bench.player.stop();
    bench.step_until([&] { return !bench.device.enabled(); });
    REQUIRE(bench.clock.now() - asked <= 2ms);
    bench.step_until([&] { return bench.player.state().confirmed == stop; });
    REQUIRE(bench.works.back().stage == Stage::stopped);
    // Nothing of before turns them on again, and what comes after it plays.
    bench.step_until([&] { return bench.player.state().status.frames_good == 0 && bench.clock.now() - asked > 400ms; });
    REQUIRE_FALSE(bench.device.enabled());
    bench.player.play(shown);
    bench.step_until([&] { return bench.told(Stage::done); });
}

TEST_CASE("step player: STOP during an upload ends it, and what waits behind it") {
    Bench bench;
    bench.connect();
    bench.player.play(image(40, 300));
    bench.player.play(image(41));
    bench.step_until([&] { return bench.works.size() > 5; });
    const auto asked = bench.clock.now();
    const std::uint64_t stop = bench.player.stop();
    bench.step_until([&] { return bench.player.state().confirmed == stop; });
    REQUIRE(bench.clock.now() - asked <= 4ms);
    REQUIRE(std::ranges::count_if(bench.works, [](const auto& one) { return one.stage == Stage::stopped; }) == 2);
    const auto taken = bench.device.log();
    REQUIRE(std::ranges::none_of(taken, [](const auto& one) { return one.command == Command::enable; }));
}

TEST_CASE("step player: a line that loses bytes is no obstacle") {
    Bench bench({.lose_one_in = 3000});
    bench.connect();
    bench.player.upload(image(50));
    bench.step_until([&] { return bench.told(Stage::done); }, 60s);
    bench.works.clear();
    bench.player.upload(image(50));
    bench.step_until([&] { return bench.told(Stage::done); }, 60s);
    REQUIRE(bench.works.back().uploaded->written == 0);
}

TEST_CASE("step player: who does not step has the watchdog turn the outputs off, and is told why") {
    Bench bench;
    bench.connect();
    bench.player.stream(image(60), 1);
    bench.step_until([&] { return bench.told(Stage::plays); });
    for (int i = 0; i < 12; ++i) {  // alive for longer than the watchdog's time
        const auto until = bench.clock.now() + 100ms;
        bench.step_until([&] { return bench.clock.now() > until; });
        REQUIRE(bench.device.enabled());
    }
    bench.clock.rest(501ms);
    bench.step_until([&] { return bench.told(Stage::failed); });
    REQUIRE(bench.device.trips() == 1);
    REQUIRE_REFUSAL(heard::Refusal(*bench.works.back().error));
}

TEST_CASE("step player: after a loss the outputs are turned off first, and a device that was reset is known again") {
    const auto cut = std::make_shared<std::atomic<bool>>(false);
    Bench bench({.cut = cut});
    bench.connect();
    bench.player.stream(image(70), 1);
    bench.step_until([&] { return bench.told(Stage::plays); });
    *cut = true;
    bench.step_until([&] { return bench.player.state().connection == Connection::lost; });
    REQUIRE(bench.works.back().stage == Stage::failed);
    REQUIRE_REFUSED(bench.player.play(image(70)));
    *cut = false;
    bench.connect();
    REQUIRE_FALSE(bench.device.enabled());
    bench.works.clear();
    bench.device.reset();
    bench.player.play(image(71));
    bench.step_until([&] { return bench.told(Stage::failed); });  // by the session that it forgot
    bench.connect();
    bench.player.play(image(71));
    bench.step_until([&] { return bench.told(Stage::done); });
    bench.player.lose("it was unplugged");
    REQUIRE(bench.player.state().connection == Connection::lost);
    REQUIRE(bench.player.state().trouble == "it was unplugged");
}

TEST_CASE("step player: an image that does not fit, and a record that the device refuses") {
    Bench bench;
    REQUIRE_REFUSED(bench.player.upload(image(80)));
    bench.connect();
    Image wide = *image(80);
    wide.channels = 90;
    REQUIRE_THROWS_AS(bench.player.upload(std::make_shared<const Image>(wide)), Error);
    REQUIRE_FALSE(bench.device.enabled());
}

TEST_CASE("step player: what waits for triggers starts its part at once, and ends at STOP alone") {
    Bench bench;
    bench.connect();
    REQUIRE_REFUSED(bench.player.trigger(0));
    REQUIRE_REFUSED(bench.player.play(image(50), {{1, 31, 1, false}}));
    bench.player.play(image(50), {{1, 30, 1, false}, {5, 3, 2, false}});
    bench.step_until([&] { return bench.told(Stage::plays); });
    REQUIRE(bench.device.enabled());
    const auto begun = bench.clock.now();
    bench.step_until([&] { return bench.clock.now() - begun > 1s; });
    REQUIRE(bench.carried.of({Command::start}).empty());
    REQUIRE(bench.device.enabled());
    const auto asked = bench.clock.now();
    bench.player.trigger(1);
    bench.step_until([&] { return !bench.carried.of({Command::start}).empty(); });
    REQUIRE(bench.clock.now() - asked <= 2ms);
    REQUIRE(bench.carried.of({Command::start}).back().second == Bytes{5, 0, 3, 0, 2, 0});
    REQUIRE_REFUSED(bench.player.trigger(2));
    bench.step_until([&] { return bench.clock.now() - asked > 1s; });
    REQUIRE(bench.device.enabled());
    const std::uint64_t stop = bench.player.stop();
    bench.step_until([&] { return bench.player.state().confirmed == stop; });
    REQUIRE_FALSE(bench.device.enabled());
}
