// SPDX-License-Identifier: Apache-2.0
// The link and the host treated badly, on the Verilated core with its proofs' assertions on. Every case prints what it
// did. `make test` runs them at a size of seconds; HAPTOGRAM_SOAK=1, as in `make soak`, at full size.
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <deque>
#include <functional>
#include <map>

#include "../soak.hpp"
#include "bad_line.hpp"
#include "cosim/bench.hpp"
#include "haptogram/link/live_feed.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

/// The size of a case: `full` in a soak, a part of it otherwise.
std::size_t size(std::size_t full, std::size_t quick) {
    const std::size_t count = soaked(full, quick);
    fmt::print("torture: seed {}, ", Catch::rngSeed());
    return count;
}

template <class... Values>
void figures(fmt::format_string<Values...> format, Values&&... values) {
    fmt::print("{}\n", fmt::format(format, std::forward<Values>(values)...));
    std::fflush(stdout);
}

/// Records whose pulses neither cross a cycle's end nor reach into the next cycle: what rises in a cycle is its
/// record's.
Record inner_record(std::mt19937& g) {
    Record r{250, 1, 20, {}};
    for (int k = 0; k < 16; ++k) r.timings.push_back(static_cast<std::uint16_t>(random(g, 2, 220)));
    return r;
}

Image inner_image(std::mt19937& g, std::uint16_t points) {
    std::vector<Record> records;
    for (std::uint16_t i = 0; i < points; ++i) records.push_back(inner_record(g));
    return image_of(16, std::move(records));
}

/// Looks at every cycle at the pins: which of a record's known contents did it show? Told of each write's contents
/// before they are sent, it knows what may be seen.
class Watcher {
public:
    explicit Watcher(sim::SimulatedBoard& board) {
        board.on_edge([this](const sim::Edge& e) {
            if (!e.rises) return;
            if (e.channel < seen_.size()) seen_[e.channel] = static_cast<std::int32_t>(e.clock - start_);
        });
        board.on_cycle_start([this](const sim::CycleStart& c) {
            judge();
            start_ = c.clock;
            index_ = c.index;
            judged_ = !c.enabled;  // a cycle in which outputs came on or went off is nobody's
            seen_.fill(-1);
        });
    }

    void may_be(std::uint16_t index, const Record& record) {
        auto& known = known_[index];
        if (known.size() == 2) known.pop_front();  // old and new
        known.push_back(record);
    }
    void outputs_changed() { judged_ = true; }

    std::uint64_t cycles = 0, torn = 0;
    std::map<std::uint16_t, std::uint64_t> newest;  ///< cycles in which a record's newest contents were seen

private:
    void judge() {
        if (judged_ || index_ == 0) return;
        ++cycles;
        const auto& known = known_[index_];
        for (const Record& record : known) {
            bool equal = true;
            for (std::size_t k = 0; k < seen_.size(); ++k) equal = equal && seen_[k] == record.timings[k];
            if (!equal) continue;
            newest[index_] += record.timings == known.back().timings ? 1 : 0;
            return;
        }
        ++torn;
    }

    std::map<std::uint16_t, std::deque<Record>> known_;
    std::array<std::int32_t, 16> seen_{};
    std::uint64_t start_ = 0;
    std::uint16_t index_ = 0;
    bool judged_ = true;
};

}  // namespace

TEST_CASE("torture: random bytes break no contract, and the next good frame is understood") {
    const std::size_t bytes = size(10'000'000, 60'000);
    constexpr std::size_t burst = 500;
    constexpr std::size_t bursts_a_board = 40;
    auto g = generator();
    std::uint64_t pulses = 0;
    std::uint64_t by_chance = 0;
    std::uint64_t damaged = 0;
    for (std::size_t sent = 0; sent < bytes;) {
        Bench bench;
        bench.open();
        const Image image = image_of(16, {record(16, 250, 1, 100, 9)});
        bench.load(image);
        bench.client.select(1);
        bench.wait_for_index(1);
        for (std::size_t i = 0; i < bursts_a_board && sent < bytes; ++i, sent += burst) {
            Bytes noise(burst);
            const unsigned values = i % 3 == 0 ? 256 : i % 3 == 1 ? 6 : 40;
            for (auto& byte : noise) byte = static_cast<std::uint8_t>(g() % values);
            bench.board.send(noise);
            REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 10'000'000));
        }
        bench.board.run(50'000);
        static_cast<void>(bench.board.receive());
        link::Client fresh(bench.line);
        fresh.begin_at(0);  // so that a seed gives the same bytes
        fresh.identify();
        const link::Status status = fresh.status();
        damaged += status.frames_damaged;
        // identify, watchdog, enable, select; and identify, status of this client. Any more fitted its CRC by chance.
        if (status.frames_good != 6) {
            ++by_chance;
            continue;
        }
        REQUIRE(status.present_index == 1);
        REQUIRE(status.enabled);
        REQUIRE(status.underruns == 0);
        const auto report = bench.check(image);
        require_equal(report, 16'000);
        pulses += report.checked;
    }
    figures(
        "{} random bytes, {} damaged frames counted, {} pulses as they should be; {} boards met a good frame by chance",
        bytes, damaged, pulses, by_chance);
}

TEST_CASE("torture: images over a line that damages, loses, doubles and delays bytes arrive whole, none torn") {
    const std::size_t images = size(200, 4);
    constexpr std::uint16_t points = 12;
    auto g = generator();
    Bench bench;
    Watcher watcher(bench.board);
    BadLine line(bench.line, g, {.bit_errors = 1e-4, .lost = 1e-4, .doubled = 1e-4, .delayed = 1e-3});
    link::Client client(line);
    client.begin_at(0);  // so that a seed gives the same bytes
    // Of simulated time; the policy's ten seconds would take the simulation minutes.
    client.set_patience(line.patience(), std::chrono::milliseconds(100));
    Image image = inner_image(g, points);
    for (std::uint16_t i = 0; i < points; ++i) watcher.may_be(static_cast<std::uint16_t>(i + 1), image.records[i]);
    bench.load(image);
    client.identify();
    client.set_watchdog(0);
    client.enable();
    client.start(1, points, 0);
    std::uint64_t written = 0;
    for (std::size_t i = 0; i < images; ++i) {
        const Image next = inner_image(g, points);
        for (std::uint16_t r = 0; r < points; ++r) watcher.may_be(static_cast<std::uint16_t>(r + 1), next.records[r]);
        written += link::upload(client, next).written;
        image = next;
        Bytes expected;
        for (const std::uint16_t word : primary_words(image))
            for (const unsigned shift : {0U, 8U}) expected.push_back(static_cast<std::uint8_t>(word >> shift));
        REQUIRE(bench.memory(interface::primary_base, expected.size()) == expected);
        bench.board.run(500ULL * points);
    }
    REQUIRE(watcher.torn == 0);
    REQUIRE(watcher.cycles > images * points);
    REQUIRE(client.status().underruns == 0);
    figures(
        "{} images of {} frames arrived whole, {} frames written, {} sent again; {} of {} bytes spoilt; {} cycles "
        "played, none torn",
        images, points + 2, written, client.retransmissions(), line.spoilt(), line.carried(), watcher.cycles);
}

TEST_CASE("torture: a record written while it plays is old or new") {
    const std::size_t writes = size(10'000, 250);
    auto g = generator();
    Bench bench;
    Watcher watcher(bench.board);
    Image image = image_of(16, {inner_record(g)});
    image.sequence = {{1, 1}, {1, 1}};  // read again in every cycle
    watcher.may_be(1, image.records[0]);
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, 0);
    bench.wait_for_index(1);
    std::uint64_t shown = 0;
    for (std::size_t i = 0; i < writes; ++i) {
        bench.board.run(random(g, 0, 249));
        const Record next = inner_record(g);
        watcher.may_be(1, next);
        watcher.newest[1] = 0;
        Bytes bytes;
        for (const std::uint16_t word : primary_words(image_of(16, {next})))
            for (const unsigned shift : {0U, 8U}) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
        bench.client.write(interface::primary_base, bytes);
        bench.board.run(750);
        shown += watcher.newest[1] > 0 ? 1 : 0;
    }
    REQUIRE(watcher.torn == 0);
    REQUIRE(shown == writes);
    figures("{} writes to the playing record, each seen at the pins; {} cycles, none a mixture", writes,
            watcher.cycles);
}

TEST_CASE("torture: a host killed at any moment leaves the outputs low in time, and the next session works") {
    const std::size_t kills = size(200, 12);
    constexpr std::uint64_t timeout = 250'000;  // small-16's watchdog: 5 ms
    constexpr std::uint64_t last_frame = 300;   // a frame whose last byte had arrived is still carried out
    auto g = generator();
    std::uint64_t latest = 0;
    std::uint64_t were_on = 0;
    Bench bench;
    const Image image = inner_image(g, 8);
    for (std::size_t i = 0; i < kills; ++i) {
        std::uint64_t last_high = 0;
        CuttableLine line(bench.line, random(g, 20, 4000));
        try {
            link::Client host(line);
            host.begin_at(0);  // so that a seed gives the same bytes
            const link::Identity identity = host.identify();
            link::upload(host, image);
            host.enable();
            host.start(1, 8, 0);
            for (;;) {
                if (i % 2 == 0) {
                    static_cast<void>(host.status());
                    bench.board.run(random(g, 0, 20'000));
                } else {
                    link::LiveFeed feed(host, identity);
                    feed.push({1, 2}, 5);
                    host.wait();
                }
            }
        } catch (const link::LinkLost&) {
        }
        bench.board.unplug();
        const std::uint64_t killed = bench.board.now();
        were_on += bench.board.outputs().enabled ? 1 : 0;
        while (bench.board.now() < killed + timeout + last_frame + 2 || bench.board.outputs().enabled) {
            bench.board.run(1);
            if (bench.board.any_pin()) last_high = bench.board.now();
            REQUIRE(bench.board.now() < killed + 2 * timeout);
        }
        if (last_high > killed) latest = std::max(latest, last_high - killed);
        REQUIRE(last_high <= killed + timeout + last_frame + 2);
        REQUIRE_FALSE(bench.board.any_pin());
        static_cast<void>(bench.board.receive());
    }
    bench.client.identify();
    REQUIRE_NOTHROW(link::upload(bench.client, image));
    REQUIRE(link::compare(bench.client, image).empty());
    figures("{} hosts killed, {} of them with outputs on; the last pin was low {} clocks after its kill, time-out {}",
            kills, were_on, latest, timeout);
}

TEST_CASE("torture: an upload that is unplugged again and again ends, verified") {
    const std::size_t unplugs = size(50, 6);
    auto g = generator();
    std::size_t done = 0;
    std::size_t images = 0;
    std::uint64_t written = 0;
    std::uint64_t pieces = 0;
    while (done < unplugs) {
        Bench bench;
        const Image image = inner_image(g, 38);
        for (bool whole = false; !whole;) {
            const bool last = done >= unplugs;
            CuttableLine line(bench.line, last ? ~0ULL : random(g, 30, 2500));
            link::Client client(line);
            client.begin_at(0);  // so that a seed gives the same bytes
            try {
                client.identify();
                const auto uploaded = link::upload(client, image);
                pieces += uploaded.pieces;
                whole = true;
            } catch (const link::LinkLost&) {
                ++done;
                bench.board.unplug();
                bench.board.run(random(g, 0, 100'000));
                static_cast<void>(bench.board.receive());
            }
            written += client.retransmissions();
        }
        link::Client fresh(bench.line);
        fresh.begin_at(0);  // so that a seed gives the same bytes
        fresh.identify();
        REQUIRE(link::upload(fresh, image).written == 0);
        REQUIRE(link::compare(fresh, image).empty());
        ++images;
    }
    figures("{} unplugs in uploads of {} images of {} frames, all verified in the end; {} frames sent again", done,
            images, pieces / images, written);
}
