// SPDX-License-Identifier: Apache-2.0
// A device in a thread of its own: what shut_off() overtakes and how fast, losses, refusals, and the end.
#include <atomic>
#include <catch2/catch.hpp>
#include <optional>
#include <thread>

#include "../refusal.hpp"
#include "../virtual_clock.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device_thread.hpp"
#include "haptogram/link/stream.hpp"
#include "haptogram/link/transfer.hpp"
#include "timed_line.hpp"

using namespace haptogram;
using namespace haptogram::test;
using namespace std::chrono_literals;
using interface::Command;
using link::Connection;
using link::DeviceThread;

namespace {

DeviceThread::Settings on(FakeDevice& device, Clock& clock, const TimedLine::Settings& settings = {}) {
    return {.open = [&device, &clock, settings] { return std::make_unique<TimedLine>(device, settings, clock); },
            .reconnect_pause = 10ms,
            .clock = clock};
}

/// 100 records, of which no two with different numbers are equal.
Image image(std::uint16_t number) {
    Image made;
    made.channels = 100;
    made.clock_hz = 50'000'000;
    for (std::uint16_t i = 1; i <= 100; ++i) {
        made.records.push_back({1250, 1, 100, std::vector<std::uint16_t>(100, static_cast<std::uint16_t>(number + i))});
        made.sequence.push_back({i, 1});
    }
    return made;
}

class Endless final : public link::StreamSource {
public:
    std::optional<SequenceEntry> next(std::chrono::milliseconds) override { return SequenceEntry{1, 1}; }
    [[nodiscard]] bool ended() const override { return false; }
};

/// Does it again and again, in a thread, through a new channel each time, until it is told to end.
class Worker {
public:
    template <class Work>
    Worker(DeviceThread& device, Clock& clock, Work work)
        : device_(device), clock_(clock), thread_(clock.begin([this, &device, work] {
              while (!ended_) {
                  try {
                      const auto channel = device.channel(10s);
                      work(*channel);
                      ++finished;
                  } catch (const Error& error) {
                      ++(error.code() == ErrorCode::cancelled ? cancelled : failed);
                  }
              }
              left_ = true;
          })) {}
    void end() {
        ended_ = true;
        if (thread_.joinable()) clock_.join(thread_);
    }
    /// Of work that ends only when outputs are shut off. The worker may begin once more just after that, hence again.
    void shut_off() {
        ended_ = true;
        while (!left_) {
            device_.shut_off();
            clock_.rest(5ms);
        }
        end();
    }
    ~Worker() { shut_off(); }
    std::atomic<int> finished = 0, cancelled = 0, failed = 0;

private:
    DeviceThread& device_;
    Clock& clock_;
    std::atomic<bool> ended_ = false, left_ = false;
    std::thread thread_;
};

template <class Condition>
bool eventually(Clock& clock, Condition condition, std::chrono::milliseconds patience = 10s) {
    for (const Clock::Time deadline = clock.now() + patience; !condition(); clock.rest(1ms))
        if (clock.now() > deadline) return false;
    return true;
}

}  // namespace

TEST_CASE("device thread: disable is on the wire at once while an upload and a stream run", "[link][thread]") {
    const double baud = GENERATE(1e6, 115200.0);
    VirtualClock clock;
    FakeDevice device;
    const TimedLine::Settings line{.baud = baud};
    DeviceThread thread(on(device, clock, line));
    std::atomic<std::uint16_t> number = 0;
    Worker uploads(thread, clock, [&](link::Commands& channel) { link::upload(channel, image(number += 100)); });
    Worker streams(thread, clock, [&](link::Commands& channel) {
        Endless source;
        link::stream(channel, {}, source);
    });
    // What is read at the time, what the chip has taken already, and disable itself.
    const Clock::Time most = 5ms + Clock::time(static_cast<double>(line.chip + 10) * 10.0 / baud);
    for (int i = 0; i < 60; ++i) {
        REQUIRE(eventually(clock, [&] { return device.enabled(); }));
        clock.rest(30ms + i * 170us);  // both are in the middle of something
        const Clock::Time asked = clock.now();
        const std::uint64_t ticket = thread.shut_off();
        REQUIRE(thread.wait_off(ticket, 5s));
        const auto log = device.log();
        const auto disable = std::ranges::find_if(
            log, [&](const auto& taken) { return taken.command == Command::disable && taken.when > asked; });
        REQUIRE(disable != log.end());
        REQUIRE(disable->applied);
        INFO(Clock::seconds(disable->when - asked) << " s");
        REQUIRE(disable->when - asked <= most);
    }
    uploads.end();
    streams.shut_off();
    CHECK(uploads.cancelled > 0);
    CHECK(streams.cancelled > 0);
    CHECK(uploads.failed + streams.failed == 0);
    CHECK(device.trips() == 0);
}

TEST_CASE("device thread: nothing that was asked before shut_off() comes after it", "[link][thread]") {
    VirtualClock clock;
    FakeDevice device;
    DeviceThread thread(on(device, clock));
    const auto old = thread.channel();
    old->enable();
    for (int i = 0; i < 10'000; ++i) old->submit({Command::enable, {}});
    old->flush();
    const std::uint64_t ticket = thread.shut_off();
    REQUIRE_REFUSED(old->wait());
    REQUIRE_REFUSED(old->enable());
    REQUIRE(thread.wait_off(ticket, 5s));
    REQUIRE_FALSE(device.enabled());
    clock.rest(1h);
    REQUIRE_FALSE(device.enabled());
    const auto log = device.log();
    const auto disable = std::ranges::find(log, Command::disable, &FakeDevice::Taken::command);
    REQUIRE(std::ranges::find(disable, log.end(), Command::enable, &FakeDevice::Taken::command) == log.end());
    REQUIRE(std::ranges::count(log, Command::enable, &FakeDevice::Taken::command) < 500);
    thread.channel()->enable();  // new work may turn them on again
    REQUIRE(device.enabled());
}

TEST_CASE("device thread: outputs stay on without work, and are off when it ends", "[link][thread]") {
    VirtualClock clock;
    FakeDevice device;
    {
        DeviceThread thread(on(device, clock));
        const auto channel = thread.channel();
        channel->set_watchdog(300);
        channel->enable();
        clock.rest(1min);
        REQUIRE(device.enabled());
        for (int i = 0; i < 1000; ++i) channel->submit({Command::enable, {}});
        channel->flush();
    }
    REQUIRE_FALSE(device.enabled());
    REQUIRE(device.trips() == 0);
}

TEST_CASE("device thread: after an unplug it connects again with outputs off, and an upload goes on",
          "[link][thread]") {
    VirtualClock clock;
    FakeDevice device;
    const auto cut = std::make_shared<std::atomic<bool>>(false);
    std::mutex mutex;
    std::vector<Connection> told;
    auto settings = on(device, clock, {.cut = cut});
    settings.told = [&](const link::DeviceState& state) {
        const std::lock_guard lock(mutex);
        if (told.empty() || told.back() != state.connection) told.push_back(state.connection);
    };
    DeviceThread thread(std::move(settings));
    thread.channel()->set_watchdog(0);  // so that only the thread itself can turn the outputs off
    thread.channel()->enable();
    unsigned losses = 0;
    link::UploadReport report;
    std::thread uploading = clock.begin([&] {
        report =
            link::upload([&] { return thread.channel(); }, image(1),
                         {.image = "image", .port = "port", .verify = true, .lost = [&](const link::LinkLost&, double) {
                              ++losses;
                              *cut = false;
                          }});
    });
    REQUIRE(eventually(clock, [&] {
        const auto log = device.log();
        return std::ranges::count(log, Command::write, &FakeDevice::Taken::command) > 20;
    }));
    *cut = true;
    clock.join(uploading);
    REQUIRE(report.verified);
    REQUIRE(report.link_losses == 1);
    REQUIRE(losses == 1);
    REQUIRE(report.frames_written < report.frames);
    REQUIRE_FALSE(device.enabled());
    const std::lock_guard lock(mutex);
    REQUIRE(told == std::vector{Connection::connected, Connection::lost, Connection::connected});
}

TEST_CASE("device thread: a refused command is an error of its own channel alone", "[link][thread]") {
    VirtualClock clock;
    FakeDevice device;
    DeviceThread thread(on(device, clock));
    Worker good(thread, clock, [&](link::Commands& channel) { link::upload(channel, image(5)); });
    const auto bad = thread.channel();
    for (int i = 0; i < 50; ++i) REQUIRE_REFUSED(bad->select(999));
    bad->select(1);
    REQUIRE(eventually(clock, [&] { return good.finished > 0; }));
    good.end();
    REQUIRE(good.failed == 0);
    REQUIRE(thread.state().connection == Connection::connected);
}

TEST_CASE("device thread: a line that loses bytes changes nothing of this", "[link][thread]") {
    VirtualClock clock;
    FakeDevice device;
    DeviceThread thread(on(device, clock, {.lose_one_in = 2000}));
    const auto channel = thread.channel(10s);
    channel->enable();
    link::upload(*channel, image(9));
    REQUIRE(link::compare(*channel, image(9)).empty());
    REQUIRE(channel->retransmissions() > 0);
    REQUIRE(thread.wait_off(thread.shut_off(), 10s));
    REQUIRE_FALSE(device.enabled());
}

TEST_CASE("device thread: what keeps it from connecting is told", "[link][thread]") {
    VirtualClock clock;
    const auto open = []() -> std::unique_ptr<link::Transport> {
        throw Error(ErrorCode::device, "/dev/none", "cannot be opened");
    };
    DeviceThread thread({.open = open, .clock = clock});
    REQUIRE_REFUSED(thread.channel(100ms));
    REQUIRE(thread.state().connection == Connection::connecting);
    REQUIRE_FALSE(thread.wait_off(thread.shut_off(), 10ms));
}

TEST_CASE("device thread: it ends although the search for its port is interrupted each time", "[link][thread]") {
    VirtualClock clock;
    std::atomic<int> opened = 0;
    link::DeviceThread thread({.open = [&]() -> std::unique_ptr<link::Transport> {
                                   ++opened;
                                   throw link::Interrupted();
                               },
                               .clock = clock});
    clock.rest(1s);
    CHECK(opened == 5);  // each 200 ms
    thread.end();
    CHECK(opened <= 6);
}

TEST_CASE("device thread: a listener that throws shuts the outputs off", "[link][thread]") {
    VirtualClock clock;
    FakeDevice device;
    std::atomic<bool> fails = false;
    auto settings = on(device, clock);
    settings.told = [&](const link::DeviceState&) {
        if (fails.exchange(false)) throw std::runtime_error("no page");
    };
    DeviceThread thread(std::move(settings));
    const auto channel = thread.channel();
    channel->enable();
    REQUIRE(device.enabled());
    fails = true;
    REQUIRE(eventually(clock, [&] { return !device.enabled(); }));
    REQUIRE_THROWS_AS(channel->enable(), Error);
    REQUIRE_SAID(thread.state().trouble);
}

TEST_CASE("device thread: channels that come and go while the outputs are shut off race with nothing",
          "[link][thread]") {
    FakeDevice device;
    auto thread = std::make_unique<DeviceThread>(on(device, link::machine_clock(), {.baud = 12e6}));
    std::unique_ptr<link::Commands> survivor = thread->channel();
    {
        std::vector<std::unique_ptr<Worker>> workers;
        for (int i = 0; i < 4; ++i)
            workers.push_back(std::make_unique<Worker>(*thread, link::machine_clock(), [](link::Commands& channel) {
                channel.enable();
                for (int n = 0; n < 20; ++n) static_cast<void>(channel.status());
            }));
        for (int i = 0; i < 50; ++i) {
            std::this_thread::sleep_for(2ms);
            thread->shut_off();
            static_cast<void>(thread->state());
        }
        for (auto& worker : workers) worker->end();
        for (const auto& worker : workers) CHECK(worker->failed == 0);
    }
    thread.reset();
    REQUIRE_FALSE(device.enabled());
    REQUIRE_REFUSED(survivor->status());
}
