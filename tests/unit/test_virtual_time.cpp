// SPDX-License-Identifier: Apache-2.0
// What is promised of time, exactly, in a time that is stepped; and that a device that breaks it by a millisecond is
// noticed.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "../refusal.hpp"
#include "../virtual_clock.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device_thread.hpp"
#include "late_network.hpp"
#include "timed_line.hpp"

using namespace haptogram;
using namespace haptogram::test;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds most_stop{100}, watchdog{500};

/// What is wrong with a time; empty when nothing is.
std::string beyond(const char* what, Clock::Time found, Clock::Time most) {
    return found <= most ? "" : fmt::format("{} {} us late", what, (found - most) / 1us);
}

/// From shut_off() until the outputs are off, while a channel asks for as much as goes over the line.
Clock::Time stop_takes(FakeDevice::Faults faults, Clock::Time after) {
    VirtualClock clock;
    FakeDevice device(faults);
    const auto open = [&] { return std::make_unique<TimedLine>(device, TimedLine::Settings{.baud = 115200}, clock); };
    link::DeviceThread thread({.open = open, .clock = clock});
    const auto channel = thread.channel();
    channel->enable();
    for (int i = 0; i < 1000; ++i) channel->submit(link::write_request(0, link::Bytes(200, 1)));
    channel->flush();
    clock.rest(after);
    const Clock::Time asked = clock.now();
    REQUIRE(thread.wait_off(thread.shut_off(), 2s));
    return device.off_at(clock.now()) - asked;
}

/// From the last that the device has heard of a host that dies until the outputs are off.
Clock::Time stays_on(FakeDevice::Faults faults) {
    VirtualClock clock;
    FakeDevice device(faults);
    link::Client client(std::make_unique<TimedLine>(device, TimedLine::Settings{}, clock));
    client.identify();
    client.set_watchdog(static_cast<std::uint16_t>(watchdog.count()));
    client.enable();
    clock.rest(10s);
    return device.off_at(clock.now()) - device.heard_at();
}

}  // namespace

TEST_CASE("virtual time: who waits for the least runs next, and none takes any of the machine's") {
    VirtualClock clock;
    std::vector<std::pair<int, Clock::Time>> ran;
    std::mutex mutex;
    std::condition_variable news;
    bool told = false;
    std::thread other = clock.begin([&] {
        for (int i = 0; i < 3; ++i) {
            clock.rest(10min);
            ran.emplace_back(1, clock.now());
        }
        const std::lock_guard lock(mutex);
        told = true;
        news.notify_all();
    });
    clock.at(15min, [&] { ran.emplace_back(2, clock.now()); });
    clock.rest(12min);
    ran.emplace_back(0, clock.now());
    std::unique_lock lock(mutex);
    CHECK_FALSE(clock.wait_for(lock, news, 1min, [&] { return told; }));
    CHECK(clock.now() == 13min);
    CHECK(clock.wait_for(lock, news, 1h, [&] { return told; }));
    lock.unlock();
    CHECK(clock.now() == 30min);
    clock.join(other);
    CHECK(ran == std::vector<std::pair<int, Clock::Time>>{{1, 10min}, {0, 12min}, {2, 15min}, {1, 20min}, {1, 30min}});
}

TEST_CASE("virtual time: a full line is overtaken by STOP within 100 ms, and one that takes 101 is noticed") {
    for (Clock::Time after = 0ms; after < 300ms; after += 7100us) {
        const Clock::Time takes = stop_takes({}, after);
        CHECK(beyond("STOP", takes, most_stop).empty());
        CHECK(takes == stop_takes({}, after));  // always the same
        CHECK(beyond("STOP", stop_takes({.stop = 100ms - takes}, after), most_stop).empty());
        CHECK(beyond("STOP", stop_takes({.stop = 101ms - takes}, after), most_stop) == "STOP 1000 us late");
    }
}

TEST_CASE("virtual time: outputs are off when the watchdog's time is over, and a millisecond more is noticed") {
    CHECK(stays_on({}) == watchdog);
    CHECK(beyond("watchdog", stays_on({}), watchdog).empty());
    CHECK(beyond("watchdog", stays_on({.watchdog = 1ms}), watchdog) == "watchdog 1000 us late");
}

TEST_CASE("virtual time: outputs stay on for an hour, also on a line that loses one byte of a thousand") {
    const bool loses = GENERATE(false, true);
    VirtualClock clock;
    FakeDevice device;
    const TimedLine::Settings settings{.lose_one_in = loses ? 1000U : 0U};  // about 1 % of frames
    const auto open = [&] { return std::make_unique<TimedLine>(device, settings, clock); };
    link::DeviceThread thread({.open = open, .clock = clock});
    const auto channel = thread.channel();
    channel->set_watchdog(static_cast<std::uint16_t>(watchdog.count()));
    channel->enable();
    clock.rest(1h);
    CHECK(device.enabled());
    CHECK(device.trips() == 0);
    INFO("longest silence " << device.longest_silence() / 1us << " us");
    // Where nothing is lost the device hears from its host every so often, and a frame's time later at most.
    CHECK(device.longest_silence() <
          (loses ? watchdog : link::keep_alive_pause(static_cast<std::uint16_t>(watchdog.count())) + 2ms));
    CHECK((channel->retransmissions() > 0) == loses);
}

TEST_CASE("virtual time: one late copy of IDENTIFY leaves the session as it is", "[link]") {
    const std::chrono::milliseconds late = GENERATE(as<std::chrono::milliseconds>{}, 30, 100, 600);
    VirtualClock clock;
    FakeDevice device;
    const auto copies = [late](std::span<const std::uint8_t> frame) -> std::optional<std::chrono::milliseconds> {
        const auto bytes = link::cobs_decode(frame);
        if (bytes && (*bytes)[1] == static_cast<std::uint8_t>(interface::Command::identify)) return late;
        return {};
    };
    link::Client client(
        std::make_unique<LateNetwork>(device, LateNetwork::Settings{.most_late = 1ms, .copies = copies}, clock));
    client.identify();
    client.enable();
    for (int i = 0; i < 400; ++i) client.request({interface::Command::keep_alive, {}});  // its numbers come again
    CHECK(clock.now() > 600us);
    while (clock.now() < 1s) client.request({interface::Command::keep_alive, {}});
    CHECK(device.enabled());
}

TEST_CASE("virtual time: on a network that delays by up to 50 ms a device that forgets the session is noticed",
          "[link]") {
    const auto seed = GENERATE(range(1U, 9U));
    VirtualClock clock;
    FakeDevice device;
    link::Client client(
        std::make_unique<LateNetwork>(device, LateNetwork::Settings{.most_late = 50ms, .seed = seed}, clock));
    client.identify();
    for (int i = 0; i < 20; ++i) client.request({interface::Command::keep_alive, {}});
    device.reset();
    const Clock::Time then = clock.now();
    for (int i = 0; i < 7; ++i) client.submit({interface::Command::keep_alive, {}});
    REQUIRE_REFUSED(client.wait());
    CHECK(clock.now() - then < 3s);
}

TEST_CASE("virtual time: a number that began somebody else's session is not taken twice", "[link]") {
    VirtualClock clock;
    FakeDevice device;
    link::Client first(std::make_unique<LateNetwork>(device, LateNetwork::Settings{}, clock));
    first.begin_at(7);
    first.identify();
    first.request({interface::Command::keep_alive, {}});
    link::Client second(std::make_unique<LateNetwork>(device, LateNetwork::Settings{}, clock));
    second.begin_at(7);
    second.identify();
    second.enable();
    CHECK(device.enabled());
}

TEST_CASE("virtual time: however many devices are silent, they are given up within two seconds of a signal", "[link]") {
    VirtualClock clock;
    FakeDevice devices[6];
    std::vector<std::unique_ptr<link::Client>> clients;
    std::vector<link::Client*> all;
    for (FakeDevice& device : devices) {
        clients.push_back(std::make_unique<link::Client>(
            std::make_unique<TimedLine>(device, TimedLine::Settings{.lose_one_in = 1}, clock)));
        clients.back()->set_interrupt([] { return 1U; });
        all.push_back(clients.back().get());
    }
    CHECK(link::shut_off(all) == std::vector<bool>(6, false));
    CHECK(clock.now() < 2s);
}

TEST_CASE("virtual time: a device is driven in steps, without a thread") {
    VirtualClock clock;
    FakeDevice device;
    const auto open = [&] { return std::make_unique<TimedLine>(device, TimedLine::Settings{}, clock); };
    const auto steps = std::make_shared<link::DeviceSteps>(link::DeviceSettings{.open = open, .clock = clock});
    const auto until = [&](const std::function<bool()>& so) {
        for (const Clock::Time end = clock.now() + 10s; !so();) {
            REQUIRE(clock.now() < end);
            const auto next = steps->step();
            REQUIRE(next);
            clock.rest_until(*next);
        }
    };
    until([&] { return steps->state().connection == link::Connection::connected; });
    const auto channel = steps->channel(0ms);
    channel->submit({interface::Command::enable, {}});
    until([&] { return device.enabled(); });
    const Clock::Time asked = clock.now();
    const std::uint64_t stop = steps->shut_off();
    until([&] { return steps->state().confirmed == stop; });
    CHECK_FALSE(device.enabled());
    CHECK(clock.now() - asked < 1ms);
    REQUIRE_THROWS_AS(channel->enable(), Error);
    steps->end();
    for (auto next = steps->step(); next; next = steps->step()) clock.rest_until(*next);
    CHECK(clock.now() - asked < 3ms);
}

TEST_CASE("virtual time: who rests until a time finds that it has come, whatever digits it has", "[link]") {
    VirtualClock clock;
    for (double s = 0.1; s < 1e7; s *= 1.37)
        for (const double until_s : {s, std::nextafter(s, 0.0), std::nextafter(s, 1e9), std::round(s * 1e9) * 1e-9}) {
            clock.rest_until_s(until_s);
            REQUIRE(clock.now_s() >= until_s);
            CHECK(clock.now_s() < until_s + 2e-9 + 4e-16 * until_s);
        }
}
