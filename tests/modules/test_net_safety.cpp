// SPDX-License-Identifier: Apache-2.0
// What is on its way over Ethernet when outputs go off, at a STOP, or at the end of a session, counts as old, wherever
// it is.
#include <algorithm>
#include <cstdlib>
#include <optional>
#include <ranges>

#include "net_core.hpp"

using namespace haptogram;
using namespace net;
using interface::Status;

namespace {

constexpr std::size_t waiting_bytes = 1200;  // which take 24 us out of the port
const Bytes disable_all = {'H', 'G', 5, 0}, stop_all = {'H', 'G', 9, 0};

/// Bytes that are no frame: they keep the instrument from what comes behind them, and start no watchdog's time anew.
Bytes noise(std::size_t count = waiting_bytes) { return Bytes(count, 0x55) + Bytes{0}; }

void begin(Network& network) {
    if (has_sdram) network.run(300'000);
    network.send(host, network.frames({Command::identify, Command::enable}));
    REQUIRE(network.answered(2));
    REQUIRE(network.bench->o_enabled);
}
void until_sent(Network& network) {
    while (network.frames_left() > 0) network.run(8);
}
/// A record that is heard.
Bytes record_written(Network& network) {
    std::vector<std::uint16_t> record(record_words, 0xff00);
    std::fill_n(record.begin(), interface::record_header_words, 0);
    interface::record_field::cycle_length.set(record, 1250);
    interface::record_field::prescaler.set(record, 1);
    interface::record_field::kind.set(record, 1);
    return network.frame(Command::write, Bytes(4) + words(record));
}
void press(Network& network, double ns) {
    network.bench->i_stop = 1;
    network.run(ns);
    network.bench->i_stop = 0;
}

}  // namespace

TEST_CASE("net safety: an ENABLE that waits in the port at a switch-off enables nothing") {
    const int how = GENERATE(0, 1, 2);
    Network network;
    begin(network);
    unsigned while_it_waits = 0;
    for (double wait = 0; wait < 30'000; wait += 1'470) {
        CAPTURE(how, wait);
        const std::size_t before = network.replies.size();
        if (how == 2) network.send(host, network.frame(Command::watchdog, {1, 0}));
        network.send(host, network.frame(Command::enable));
        REQUIRE(network.answered(before + (how == 2 ? 2 : 1)));
        REQUIRE(network.bench->o_enabled);
        if (how == 2) network.run(938'000 - wait);  // the watchdog's time, which began 50 us ago, is over soon
        network.send(host, noise() + network.frame(Command::enable));
        until_sent(network);
        const double arrived = network.now_ns;
        network.run(wait);
        if (how == 0) press(network, 200);
        if (how == 1) network.send(host, network.frame(Command::disable));
        while (network.bench->o_enabled && network.now_ns < arrived + 40'000) network.run(20);
        if (network.bench->o_enabled || network.now_ns > arrived + 23'500) {
            network.run(200'000);
            continue;  // it was done before
        }
        ++while_it_waits;
        network.run(how == 2 ? 500'000 : 100'000);
        CHECK(!network.bench->o_enabled);
    }
    CHECK(while_it_waits >= 8);
}

TEST_CASE("net safety: what waits in the port at a STOP of anybody or of the peer does not play") {
    const bool of_peer = GENERATE(false, true);
    Network network;
    begin(network);
    network.send(host, record_written(network));
    REQUIRE(network.answered(3));
    for (double wait = 0; wait < 22'000; wait += 1'470) {
        CAPTURE(of_peer, wait);
        const std::size_t before = network.replies.size();
        network.send(host, noise() + network.frame(Command::select, {1, 0, 0, 0}));
        until_sent(network);
        network.run(wait);
        if (of_peer)
            network.send(host, network.frame(Command::stop));
        else
            network.send(stranger, stop_all, open_port);
        REQUIRE(network.answered(before + (of_peer ? 2 : 1)));
        for (std::size_t k = before; k < network.replies.size(); ++k) CHECK(network.replies[k].status == Status::ok);
        network.run(120'000);
        CHECK(network.bench->o_index == 0);
        CHECK(network.bench->o_enabled);
    }
    // And what is sent afterwards does.
    network.send(host, network.frame(Command::select, {1, 0, 0, 0}));
    network.run(120'000);
    CHECK(network.bench->o_index == 1);
}

TEST_CASE(
    "net safety: DISABLE acts within 20 clocks of its datagram's end, however full the port is, and without room") {
    const int filling = GENERATE(0, 2, 3, 4, 8);
    Network network;
    begin(network);
    for (int k = 0; k < filling; ++k) network.send(host, noise(1400));
    const bool behind_others = GENERATE(false, true);
    CAPTURE(filling, behind_others);
    network.send(host, (behind_others ? noise(1400) : Bytes{0}) + network.frame(Command::disable));
    while (network.frames_left() > 0) network.run(8);
    network.run(20 * 20);
    CHECK(!network.bench->o_enabled);
    network.run(300'000);
    CHECK(!network.bench->o_enabled);
}

TEST_CASE("net safety: a DISABLE is seen without the zero behind it, and nothing else is taken for one") {
    Network network;
    begin(network);
    Bytes frame = network.frame(Command::disable);
    frame.pop_back();
    bool turns_off = true;
    switch (GENERATE(0, 1, 2, 3, 4)) {
        case 0: break;
        case 1: frame = Bytes{7, 9, 0} + frame; break;
        case 2: frame = Bytes{7, 9} + frame, turns_off = false; break;
        case 3: frame = link::encode_request(3, Command::disable, Bytes{0, 0}), turns_off = false; break;
        default: frame[1] ^= 1, turns_off = false;
    }
    network.send(host, frame);
    network.run(20'000);
    CHECK(network.bench->o_enabled == !turns_off);
}

TEST_CASE("net safety: half a frame of the former datagram does not swallow the next one's DISABLE") {
    Network network;
    begin(network);
    network.send(host, {9, 1, 2, 3});
    network.send(host, network.frame(Command::disable));
    REQUIRE(network.answered(3));
    CHECK(network.replies.back().status == Status::ok);
    CHECK(!network.bench->o_enabled);
}

TEST_CASE("net safety: a stranger's DISABLE, or a lost link, ends the session, and the host's tries undo nothing") {
    const int how = GENERATE(0, 1, 2);
    Network network;
    begin(network);
    const std::size_t before = network.replies.size();
    const unsigned number = network.next_number();
    network.send(host, noise() + network.frames({Command::keep_alive, Command::enable}));
    until_sent(network);
    network.run(GENERATE(100, 5'000, 23'000, 24'500, 25'000));
    if (how == 0) network.send(stranger, disable_all, open_port);
    if (how == 1) network.phy_status = 0xcc;
    if (how == 2) network.clock_runs = false;
    network.run(20'000);
    CHECK(!network.bench->o_enabled);
    network.phy_status = 0xdd;
    network.clock_runs = true;
    network.run(100'000);
    CHECK(!network.bench->o_enabled);
    for (int tries = 0; tries < 3; ++tries) {
        network.send(host, Network::again(number, Command::keep_alive) + Network::again(number + 1, Command::enable));
        network.run(200'000);
        CHECK(!network.bench->o_enabled);
    }
    REQUIRE(network.replies.size() >= before + 6);
    for (std::size_t k = network.replies.size() - 6; k < network.replies.size(); ++k)
        CHECK(network.replies[k].status == Status::session_ended);
    const std::size_t now = network.replies.size();
    network.send(host, network.frames({Command::identify, Command::enable}));
    REQUIRE(network.answered(now + 2));
    CHECK(network.bench->o_enabled);
}

TEST_CASE("net safety: an IDENTIFY that was under way when the session ended begins none") {
    Network network;
    begin(network);
    network.send(host, noise() + network.frame(Command::identify));
    until_sent(network);
    network.send(stranger, disable_all, open_port);
    network.run(100'000);
    CHECK(network.replies.back().status == Status::session_ended);
    network.send(host, network.frame(Command::enable));
    network.run(100'000);
    CHECK(network.replies.back().status == Status::session_ended);
    CHECK(!network.bench->o_enabled);
}

TEST_CASE("net safety: a late copy of the IDENTIFY that began a session begins none when that has ended") {
    Network network;
    begin(network);
    const unsigned first = network.next_number();
    network.send(host, network.frames({Command::identify, Command::enable}));
    network.run(100'000);
    CHECK(network.bench->o_enabled);
    network.send(stranger, disable_all, open_port);
    network.run(50'000);
    network.send(host, Network::again(first, Command::identify) + Network::again(first + 1, Command::enable));
    network.run(100'000);
    CHECK(network.replies.back().status == Status::session_ended);
    CHECK(!network.bench->o_enabled);
    const std::size_t now = network.replies.size();
    network.send(host, network.frames({Command::identify, Command::enable}));
    REQUIRE(network.answered(now + 2));
    CHECK(network.bench->o_enabled);
}

TEST_CASE("net safety: of a datagram in which the PHY's clock stops for long, nothing is left") {
    Network network;
    begin(network);
    for (int byte = -12; byte <= 12; ++byte)
        for (const double ns : {2'000, 3'000, 5'000, 40'000}) {
            CAPTURE(byte, ns);
            const Bytes datagram = Bytes{0} + network.frame(Command::enable);
            const std::size_t length = 8 + whole(udp_frame(host, board, datagram)).size();
            network.send(host, datagram);
            network.run(8.0 * (static_cast<double>(length) + byte) + 4);
            network.clock_runs = false;
            network.run(ns);
            const bool was_off = !network.bench->o_enabled;
            network.clock_runs = true;
            network.run(60'000);
            CHECK(network.bench->o_enabled == !was_off);
            CHECK((was_off || ns < 2'600));
            const std::size_t before = network.replies.size();
            network.send(host, network.frames({Command::identify, Command::enable}));
            REQUIRE(network.answered(before + 2));
            REQUIRE(network.bench->o_enabled);
        }
}

namespace {

/// A host, a stranger, a switch and a cable that do anything at any time, and what may then be on.
class Anything {
public:
    Network network;
    unsigned rises = 0, plays = 0, offs = 0, sessions = 0, identified = 0;
    std::string wrong;

    Anything() {
        if (has_sdram) network.run(300'000);
        network.before_clock = [this] { look(); };
        identify();
        const unsigned number = network.next_number();
        send(record_written(network), {{{number, Command::write}}});
        network.run(100'000);
    }
    void act() {
        auto& bench = network.bench;
        switch (bench.number(0, 15)) {
            case 0: identify(); break;
            case 1:
            case 2:
            case 3: say({Command::enable}); break;
            case 4: say({Command::disable}); break;
            case 5: say({Command::select}); break;
            case 6: say({Command::stop}); break;
            case 7: say({Command::keep_alive, Command::enable, Command::select}); break;
            case 8: say({Command::disable, Command::stop}); break;
            case 9: say({Command::enable, Command::keep_alive}, bench.number(0, 1400)); break;
            case 10: say({Command::select}, bench.number(0, 1400)); break;
            case 11: say_again(); break;
            case 12:
                if (bench.chance(0.5)) anybody(bench.chance(0.5));
                break;
            case 13:
                if (bench.chance(0.5)) press_stop();
                break;
            case 14:
                if (bench.chance(0.4)) stop_clock();
                break;
            default: half();
        }
        network.run(bench.chance(0.5) ? bench.number(8, 3'000) : bench.number(8, 60'000));
        hear();
    }
    /// What a host that has been told that its session has ended does, in quiet, is done.
    void work() {
        network.run(400'000);
        hear();
        const std::size_t before = network.replies.size();
        identify();
        if (network.answered(before + 1)) say({Command::enable});
        network.run(300'000);
        if (!network.bench->o_enabled) wrong = "an ENABLE in quiet does not enable";
        hear();
    }

private:
    struct Sent {
        unsigned number;
        Command command;
        double begun;    ///< of its datagram
        double session;  ///< when the IDENTIFY before it began
    };
    struct Datagram {
        std::vector<std::pair<unsigned, Command>> frames;
        bool anybodys = false, peers = true;
        double begun = 0;
    };

    void identify() {
        const unsigned number = network.next_number();
        send(network.frame(Command::identify), {{{number, Command::identify}}});
        unanswered_.clear();
        ++identified;
    }
    void say(const std::vector<Command>& commands, int before = -1) {
        Bytes bytes = before >= 0 ? noise(static_cast<std::size_t>(before)) : Bytes{};
        Datagram datagram;
        for (const Command command : commands) {
            datagram.frames.emplace_back(network.next_number(), command);
            unanswered_.emplace_back(network.next_number(), command);
            bytes = bytes + network.frame(command, payload(command));
        }
        send(bytes, datagram);
    }
    void say_again() {
        Bytes bytes;
        Datagram datagram;
        for (const auto& [number, command] : unanswered_) {
            if (bytes.size() > 1200) break;
            datagram.frames.emplace_back(number, command);
            bytes = bytes + Network::again(number, command, payload(command));
        }
        if (!bytes.empty()) send(bytes, datagram);
    }
    void half() { send({9, 1, 2, 3}, {}); }
    void anybody(bool disables) {
        Datagram datagram;
        datagram.anybodys = true;
        datagram.peers = false;
        datagram.frames.emplace_back(0, disables ? Command::disable : Command::stop);
        datagrams_.push_back(datagram);
        network.send(stranger, disables ? disable_all : stop_all, open_port);
    }
    void press_stop() {
        happens_off(network.now_ns);
        if (!acts_by_) acts_by_ = network.now_ns + 100;  // it is sampled twice
        press(network, network.bench.number(100, 3'000));
        happens_off(network.now_ns - 25);
    }
    void stop_clock() {
        const double ns =
            network.bench.chance(0.5) ? network.bench.number(8, 2'000) : network.bench.number(3'000, 30'000);
        network.clock_runs = false;
        const double from = network.now_ns;
        network.run(ns);
        if (ns >= 3'000) {
            happens_off(from);
            session_over_ = std::max(session_over_, from);
        }
        network.clock_runs = true;
        if (ns >= 3'000) deaf_to_ = network.now_ns + 2'000;  // the port is in reset, and what comes then is nothing
    }
    void send(const Bytes& bytes, const Datagram& datagram) {
        datagrams_.push_back(datagram);
        network.send(host, bytes);
    }
    static Bytes payload(Command command) { return command == Command::select ? Bytes{1, 0, 0, 0} : Bytes{}; }

    void happens_off(double ns) { off_ = std::max(off_, ns), ++offs; }

    /// Before each rising edge of the core's clock.
    void look() {
        follow_line();
        const bool on = network.bench->o_enabled, played = network.bench->o_index != 0;
        // DISABLE has acted 20 clocks behind the end of its datagram, the switch 5 clocks behind its edge.
        if (acts_by_ && network.now_ns > *acts_by_) {
            if (on && !any(Command::enable, off_))
                wrong = "a DISABLE has not acted at " + std::to_string(network.now_ns);
            acts_by_.reset();
        }
        if (was_on_ && !on) off_ = std::max(off_, network.now_ns - 50);
        if (!was_on_ && on) {
            ++rises;
            if (!acts_by_ && !any(Command::enable, off_))
                wrong = "outputs went on by an old ENABLE at " + std::to_string(network.now_ns) + ", off since " +
                        std::to_string(off_) + told();
        }
        if (!was_playing_ && played) ++plays;
        // What was on its way to the pins at a STOP plays for a cycle.
        if (played && stopped_ > selected_ && network.now_ns > stopped_ + 120'000)
            wrong = "an old SELECT plays at " + std::to_string(network.now_ns);
        was_on_ = on;
        was_playing_ = played;
    }
    [[nodiscard]] std::string told() const {
        std::string text = ", session over at " + std::to_string(session_over_);
        for (const Sent& sent : sent_ | std::views::reverse | std::views::take(8))
            text += "; " + std::to_string(static_cast<int>(sent.command)) + " began at " + std::to_string(sent.begun) +
                    " in that of " + std::to_string(sent.session);
        return text;
    }
    [[nodiscard]] bool any(Command command, double since) const {
        return std::ranges::any_of(sent_, [&](const Sent& sent) {
            const bool ended = sent.session < session_over_ && sent.begun >= session_over_;
            return sent.command == command && sent.begun >= since && !ended;
        });
    }
    /// What has begun to arrive, and what has ended.
    void follow_line() {
        for (; !network.begun.empty(); network.begun.pop_front()) {
            const double ns = network.begun.front();
            Datagram& datagram = datagrams_[begun_++];
            datagram.begun = ns;
            if (!datagram.peers) continue;
            for (const auto& [number, command] : datagram.frames) {
                if (command == Command::identify) session_ = ns;
                if (command == Command::select && (session_ >= session_over_ || ns < session_over_)) selected_ = ns;
                sent_.push_back({number, command, ns, session_});
            }
            while (sent_.size() > 400) sent_.pop_front();
        }
        for (; !network.ended.empty(); network.ended.pop_front()) {
            const double ns = network.ended.front();
            if (datagrams_[ended_].begun < deaf_to_) {
                ++ended_;
                continue;
            }
            for (const auto& [number, command] : datagrams_[ended_++].frames) {
                if (command == Command::stop) stopped_ = std::max(stopped_, ns);
                if (command != Command::disable) continue;
                happens_off(ns);
                if (datagrams_[ended_ - 1].anybodys) session_over_ = std::max(session_over_, ns), ++sessions;
                acts_by_ = ns + 400;
            }
        }
    }
    void hear() {
        for (; heard_ < network.replies.size(); ++heard_) {
            const unsigned number = network.replies[heard_].sequence;
            std::erase_if(unanswered_, [&](const auto& one) { return (one.first & 0xff) == number; });
        }
    }

    std::vector<Datagram> datagrams_;
    std::size_t begun_ = 0, ended_ = 0, heard_ = 0;
    std::deque<Sent> sent_;
    std::vector<std::pair<unsigned, Command>> unanswered_;
    std::optional<double> acts_by_;
    double off_ = 0, deaf_to_ = 0, stopped_ = 0, selected_ = 0, session_over_ = 0, session_ = -1;
    bool was_on_ = false, was_playing_ = false;
};

}  // namespace

// HAPTOGRAM_NET_ACTIONS: how many instead, such as ten million for a night.
TEST_CASE("net safety: whatever comes at any time, nothing old enables or plays", "[random]") {
    const char* const asked = std::getenv("HAPTOGRAM_NET_ACTIONS");
    const long count = asked != nullptr ? std::atol(asked) : 3'000;
    REQUIRE(count > 0);
    Anything anything;
    std::size_t before = 0;
    for (long k = 0; k < count && anything.wrong.empty(); ++k) {
        if (k % 50 == 0) anything.work();
        anything.act();
        before = anything.network.replies.size();
    }
    CAPTURE(anything.rises, anything.plays, anything.offs, anything.sessions, before);
    CHECK(anything.wrong == "");
    CHECK(anything.rises > count / 100);
    CHECK(anything.plays > count / 1000);
}
