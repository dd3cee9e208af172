// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <catch2/catch.hpp>
#include <deque>
#include <memory>

#include "../refusal.hpp"
#include "haptogram/live/hand_source.hpp"
#include "haptogram/live/source.hpp"

using namespace haptogram;

namespace {

Hand hand_at(Vec3 palm, bool right = true, std::int64_t id = 1) {
    Hand hand;
    hand.id = id;
    hand.right = right;
    hand.palm = palm;
    return hand;
}

/// Frames that are there from the beginning, of a recording or as they come.
class Listed final : public live::FrameSource {
public:
    Listed(std::deque<live::Frame> frames, bool live) : frames_(std::move(frames)), live_(live) {}
    [[nodiscard]] double rate_hz() const override { return 30.0; }
    [[nodiscard]] bool live() const override { return live_; }
    [[nodiscard]] bool ready() override { return true; }
    [[nodiscard]] std::optional<live::Frame> next() override {
        if (frames_.empty()) return {};
        live::Frame frame = std::move(frames_.front());
        frames_.pop_front();
        return frame;
    }

private:
    std::deque<live::Frame> frames_;
    bool live_;
};

live::Frame hands_frame(std::uint64_t number, double time_s, std::vector<Hand> hands) {
    return {number, time_s, {}, HandFrame{time_s, std::move(hands)}};
}

live::Frame depth_frame(std::uint64_t number, double time_s, std::uint16_t count) {
    return {number, time_s, {}, DepthShot{number, time_s, {DepthPicture{count}}}};
}

live::CombinedSource::Part part(std::deque<live::Frame> frames, std::size_t cameras = 0, bool live = false) {
    return {std::make_unique<Listed>(std::move(frames), live), cameras};
}

template <class... Parts>
live::CombinedSource combined(Parts&&... parts) {
    std::vector<live::CombinedSource::Part> list;
    (list.push_back(std::move(parts)), ...);
    return live::CombinedSource(std::move(list), link::machine_clock());
}

}  // namespace

TEST_CASE("several sources: recordings come in rounds of what is new, in the order of their times", "[live]") {
    auto all =
        combined(part({depth_frame(0, 0.00, 10), depth_frame(1, 0.04, 11)}, 1), part({depth_frame(0, 0.02, 20)}, 1),
                 part({hands_frame(0, 0.03, {hand_at({0, 0, 0.2})}), hands_frame(1, 0.30, {})}));
    std::vector<double> times;
    std::vector<std::pair<int, int>> counts;
    std::vector<std::size_t> hands;
    while (const auto frame = all.next()) {
        const auto& seen = std::get<live::Together>(frame->seen);
        REQUIRE(seen.shot.pictures.size() == 2);
        const auto count = [&](std::size_t i) {
            return seen.shot.pictures[i] ? static_cast<int>((*seen.shot.pictures[i])[0]) : -1;
        };
        times.push_back(frame->time_s);
        counts.emplace_back(count(0), count(1));
        hands.push_back(seen.hands.hands.size());
        CHECK(frame->number + 1 == times.size());
    }
    // Those that have not begun, and those that have ended, are not waited for.
    CHECK(times == std::vector<double>{0.00, 0.04, 0.30});
    CHECK(counts == std::vector<std::pair<int, int>>{{10, -1}, {11, 20}, {-1, -1}});
    CHECK(hands == std::vector<std::size_t>{0, 1, 0});
}

TEST_CASE("several sources: a hand that two trackers see is one, of the tracker that was named first", "[live]") {
    auto all = combined(part({hands_frame(0, 0.0, {hand_at({0, 0, 0.2})})}),
                        part({hands_frame(0, 0.0, {hand_at({0.02, 0, 0.21}), hand_at({0.02, 0, 0.21}, false, 2)})}));
    const auto frame = all.next();
    REQUIRE(frame);
    const auto& hands = std::get<HandFrame>(frame->seen).hands;
    REQUIRE(hands.size() == 2);
    CHECK(hands[0].palm.x == 0.0);
    CHECK_FALSE(hands[1].right);
    CHECK(hands[0].id != hands[1].id);
}

TEST_CASE("several sources: lost frames of one are lost ones of all", "[live]") {
    auto all = combined(part({hands_frame(4, 0.0, {}), hands_frame(7, 0.1, {})}), part({hands_frame(0, 0.05, {})}));
    std::vector<std::uint64_t> numbers;
    while (const auto frame = all.next()) numbers.push_back(frame->number);
    CHECK(numbers == std::vector<std::uint64_t>{0, 3});  // 5 and 6 of the first one
}

TEST_CASE("several sources: each frame has new places of all, whose times are their own", "[live]") {
    const double shift_s = GENERATE(0.0, 0.003, 0.017, 0.030);
    constexpr double apart_s = 1.0 / 30.0;
    std::deque<live::Frame> one, other;
    for (std::uint64_t i = 0; i < 30; ++i) {
        const double time_s = static_cast<double>(i) * apart_s;
        one.push_back(hands_frame(i, time_s, {hand_at({0.2 * time_s, 0, 0.2})}));
        const double later_s = time_s + shift_s;
        if (i < 10 || i > 12) other.push_back(hands_frame(i, later_s, {hand_at({0.2 * later_s, 0, 0.2}, false)}));
    }
    auto all = combined(part(std::move(one)), part(std::move(other)));
    std::size_t frames = 0, again = 0;
    std::array<double, 2> last_s{-1.0, -1.0};
    double last_frame_s = -1.0;
    while (const auto frame = all.next()) {
        ++frames;
        CHECK(frame->time_s > last_frame_s + 0.3 * apart_s * (frames > 2 ? 1.0 : 0.0));
        last_frame_s = frame->time_s;
        for (const Hand& hand : std::get<HandFrame>(frame->seen).hands) {
            REQUIRE(hand.seen_s);
            CHECK(hand.palm.x == Approx(0.2 * *hand.seen_s).margin(1e-12));
            CHECK(*hand.seen_s <= frame->time_s);
            double& before_s = last_s.at(hand.right ? 0 : 1);
            again += *hand.seen_s == before_s ? 1 : 0;
            if (*hand.seen_s != before_s) CHECK(frame->time_s - *hand.seen_s <= 0.61 * apart_s);
            before_s = *hand.seen_s;
        }
    }
    INFO("shifted by " << shift_s << " s: " << frames << " frames");
    CHECK(frames >= 29);
    CHECK(frames <= 31);
    CHECK(again >= 1);  // while one lost three frames, its hand stayed for a tenth of a second
    CHECK(again <= 3);
}

TEST_CASE("several sources: as they happen, by one clock, and no recordings among them", "[live]") {
    struct Ticking final : link::Clock {
        mutable Time time = std::chrono::seconds(5);
        [[nodiscard]] Time now() const override { return time += std::chrono::milliseconds(10); }
        void rest_until(Time until) override { time = until; }
    } clock;
    std::vector<live::CombinedSource::Part> parts;
    parts.push_back(part({hands_frame(0, 900.0, {}), hands_frame(1, 900.1, {})}, 0, true));
    parts.push_back(part({hands_frame(0, 3.0, {})}, 0, true));
    live::CombinedSource all(std::move(parts), clock);
    std::vector<double> times;
    while (const auto frame = all.next()) times.push_back(frame->time_s);
    REQUIRE(times.size() == 2);
    CHECK(times[1] > times[0]);
    CHECK(times[1] < 0.1);
    CHECK(all.ready());
    CHECK_REFUSED(combined(part({}, 0, true), part({})));
}
