// SPDX-License-Identifier: Apache-2.0
// Contracts 9 and 10 together: two banks, each with samples, a rate and records of its own. What MODULATE asked for
// begins in the carrier period that it waits for, or where the present pass of the samples ends; START behind the same
// gate begins with it.
#include <array>
#include <optional>

#include "wide_bench.hpp"

using namespace haptogram;
using namespace haptogram::test;
using namespace haptogram::test::wide;

namespace {

using link::When;

constexpr std::uint32_t least_cycle = 800;

/// A stretch of sequence memory and a stretch of the samples.
struct Bank {
    std::uint16_t first_entry = 1;
    std::vector<SequenceEntry> entries;
    std::uint32_t first_sample = 0;
    std::vector<std::uint8_t> samples;
    std::uint16_t divider = 1;
    bool loop = true;
    std::uint64_t begins = 0;  ///< number of the carrier period of its first sample

    [[nodiscard]] std::uint64_t pass() const { return divider * samples.size(); }
    [[nodiscard]] std::uint8_t sample_in(std::uint64_t period) const {
        const std::uint64_t n = (period - begins) / divider;
        return samples[loop ? n % samples.size() : std::min<std::uint64_t>(n, samples.size() - 1)];
    }
    [[nodiscard]] bool has(std::uint16_t index) const {
        return std::ranges::any_of(entries, [index](const SequenceEntry& e) { return e.index == index; });
    }
};

/// Two banks. Every sample of the first one is well below those of the second one, and neighbours differ, so that a
/// sample in a wrong carrier period is another width at the pins.
struct SampleBanks : Wide {
    explicit SampleBanks(std::mt19937& generator) : g(generator) {
        open();
        for (std::uint16_t b = 0; b < 2; ++b) {
            banks[b].first_entry = static_cast<std::uint16_t>(1 + 100 * b);
            Words words;
            for (std::uint16_t i = 0; i < 4; ++i) {
                const auto index = static_cast<std::uint16_t>(1 + 4 * b + i);
                const std::uint32_t cycle = random(g, least_cycle, 1400);
                // Records of timings count as many periods as they have cycles. No bank begins with one, because the
                // samples do not show there.
                if (i > 0 && random(g, 0, 2) == 0)
                    raw_record(g, index, cycle, static_cast<std::uint8_t>(random(g, 1, 255)));
                else
                    random_record(g, index, cycle);
                banks[b].entries.push_back({index, static_cast<std::uint16_t>(random(g, 1, 3))});
                words.insert(words.end(), {index, banks[b].entries.back().dwell});
            }
            write(interface::sequence_base + 4U * banks[b].first_entry, words);
        }
    }

    /// Gives a bank that does not play other samples and another rate.
    void renew(std::size_t b) {
        Bank& bank = banks[b];
        bank.first_sample = static_cast<std::uint32_t>(32 * b) + 2 * random(g, 0, 8);
        bank.samples.resize(random(g, 2, static_cast<std::uint32_t>(32 * b) + 32 - bank.first_sample));
        for (std::size_t i = 0; i < bank.samples.size(); ++i)
            bank.samples[i] = static_cast<std::uint8_t>(60 + 100 * b + 40 * (i % 2) + random(g, 0, 25));
        bank.divider = static_cast<std::uint16_t>(random(g, 1, 4));
        bank.loop = random(g, 0, 3) != 0;
        Words words;
        for (std::size_t i = 0; i < bank.samples.size(); i += 2)
            words.push_back(static_cast<std::uint16_t>(bank.samples[i] |
                                                       (i + 1 < bank.samples.size() ? bank.samples[i + 1] << 8 : 0)));
        write(interface::modulation_base + bank.first_sample, words);
    }
    /// A carrier period that the commands behind its gate come in time for.
    std::uint64_t soon() { return client.status().period.value() + 50'000 / least_cycle + random(g, 0, 30); }
    void modulate(const Bank& bank, When when) {
        client.modulate(bank.divider, static_cast<std::uint16_t>(bank.samples.size()), bank.loop, bank.first_sample,
                        when);
    }
    void start(const Bank& bank, When when) {
        client.start(bank.first_entry, static_cast<std::uint16_t>(bank.entries.size()), 0, when);
    }
    void run_to(std::uint64_t period) {
        REQUIRE(board.run_until([&] { return recorder.cycles().size() > period; }, 2'000'000));
    }
    /// The pins from some periods before `period` on, when `after` begins there instead of `before`.
    Comparison compare_change(std::uint64_t period, const std::optional<Bank>& before,
                              const std::optional<Bank>& after) {
        const auto setting = [&](std::size_t i) {
            const std::uint64_t number = i + 1;  // the first cycle is period 1
            const std::optional<Bank>& bank = number < period ? before : after;
            return Setting{.modulation = bank ? bank->sample_in(number) : std::uint8_t{255}};
        };
        EmissionModel model(channel_count);
        return compare(period - 20, recorder.cycles().size() - 2, setting, model);
    }

    std::mt19937& g;
    std::array<Bank, 2> banks;
};

}  // namespace

TEST_CASE("contract 10: samples and records of one bank begin in the carrier period that both wait for",
          "[second][wide][contract9][contract10][samples]") {
    auto g = generator();
    SampleBanks bench(g);
    std::optional<Bank> present;
    for (std::size_t round = 0; round < 10; ++round) {
        bench.renew(round % 2);
        Bank& next = bench.banks[round % 2];
        const std::uint64_t period = next.begins = bench.soon();
        INFO("round " << round << ", period " << period);
        const bool samples_first = random(g, 0, 1) == 0;
        if (samples_first) bench.modulate(next, When::at_period(period));
        bench.start(next, When::at_period(period));
        if (!samples_first) bench.modulate(next, When::at_period(period));
        REQUIRE(bench.client.status().waiting);
        bench.run_to(period + random(g, 20, 100));
        require_right(bench.compare_change(period, present, next), 100);
        for (std::size_t i = period - 20; i + 1 < bench.recorder.cycles().size(); ++i) {
            const std::uint16_t index = bench.recorder.cycles()[i].index;
            REQUIRE((i + 1 < period ? (present ? present->has(index) : index == 0) : next.has(index)));
        }
        // A period too late would be seen.
        REQUIRE(bench.compare_change(period + 1, present, next).wrong > 0);
        present = next;
    }
    // The end of the modulation can wait, too.
    const std::uint64_t period = bench.soon();
    bench.client.modulate(0, 0, false, 0, When::at_period(period));
    bench.run_to(period + 20);
    require_right(bench.compare_change(period, present, {}), 100);
    const link::Status status = bench.client.status();
    REQUIRE_FALSE(status.modulated);
    REQUIRE_FALSE(status.waiting);
    REQUIRE(status.late_changes == 0);
    REQUIRE(status.underruns == 0);
}

TEST_CASE("contract 10: samples follow others where their pass ends, with no period between",
          "[second][wide][contract9][contract10][samples]") {
    auto g = generator();
    SampleBanks bench(g);
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.renew(0);
    bench.banks[0].loop = true;
    Bank present = bench.banks[0];
    present.begins = bench.soon();
    bench.modulate(present, When::at_period(present.begins));
    bench.run_to(present.begins + 20);
    for (std::size_t round = 1; round < 10; ++round) {
        bench.renew(round % 2);
        Bank next = bench.banks[round % 2];
        next.loop = true;
        bench.board.run(random(g, 0, 20'000));
        const std::uint64_t sent = bench.recorder.cycles().size();
        bench.modulate(next, When::at_end());
        const std::uint64_t told = bench.recorder.cycles().size();
        bench.run_to(told + present.pass() + 40);
        // The command was carried out in one of these periods; the pass that it fell into has ended once.
        std::size_t found = 0;
        Bank began = next;
        for (std::uint64_t end = present.begins + present.pass(); end <= told + present.pass() + 2;
             end += present.pass()) {
            if (end <= sent) continue;
            next.begins = end;
            const Comparison comparison = bench.compare_change(end, present, next);
            if (comparison.wrong != 0) continue;
            REQUIRE(comparison.pulses > 100);
            ++found;
            began = next;
        }
        INFO("round " << round << ", sent in period " << sent << ", answered in " << told);
        REQUIRE(found == 1);
        present = began;
    }
    const link::Status status = bench.client.status();
    REQUIRE(status.modulated);
    REQUIRE(status.late_changes == 0);
    REQUIRE(status.underruns == 0);
}
