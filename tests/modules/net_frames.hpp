// SPDX-License-Identifier: Apache-2.0
// Ethernet frames as a host sends them, and what a board has to make of each, worked out on whole frames as RFC 768,
// 791, 792, 826 and 1071 describe them.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace net {

using Bytes = std::vector<std::uint8_t>;

inline Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}
inline Bytes cut(const Bytes& data, std::size_t from, std::size_t to) {
    using Offset = std::ptrdiff_t;
    return {data.begin() + static_cast<Offset>(from), data.begin() + static_cast<Offset>(to)};
}
inline Bytes big(unsigned value) {
    return {static_cast<std::uint8_t>(value >> 8 & 0xff), static_cast<std::uint8_t>(value & 0xff)};
}
inline Bytes little(unsigned value) { return {big(value)[1], big(value)[0]}; }
inline unsigned at(const Bytes& data, std::size_t place) { return data[place] * 256U + data[place + 1]; }
inline void put(Bytes& data, std::size_t place, unsigned value) {
    data[place] = big(value)[0];
    data[place + 1] = big(value)[1];
}

/// RFC 1071: the sum of 16-bit words with the carries added; all ones when a right checksum is among them.
inline unsigned sum(const Bytes& data) {
    std::uint64_t all = 0;
    for (std::size_t k = 0; k < data.size(); ++k) all += k % 2 == 0 ? data[k] * 256U : data[k];
    while (all > 0xffff) all = (all & 0xffff) + (all >> 16);
    return static_cast<unsigned>(all);
}

/// IEEE 802.3's CRC as division of a polynomial, a bit at a time, the register not reflected.
inline Bytes fcs(const Bytes& data) {
    std::uint32_t rest = 0xffffffff;
    for (const std::uint8_t byte : data)
        for (int bit = 0; bit < 8; ++bit) {
            const bool takes = ((rest >> 31) ^ (byte >> bit)) & 1U;
            rest = rest << 1 ^ (takes ? 0x04c11db7U : 0U);
        }
    Bytes sent(4);
    for (unsigned bit = 0; bit < 32; ++bit)
        if ((~rest >> (31 - bit) & 1U) != 0) sent[bit / 8] |= static_cast<std::uint8_t>(1U << bit % 8);
    return sent;
}

struct Address {
    Bytes mac, ip;
    unsigned port = 0;
    friend bool operator==(const Address&, const Address&) = default;
};
inline const Address board{{2, 0x48, 0x47, 0, 0, 1}, {169, 254, 0x48, 0x47}, 4807};
inline const Address host{{2, 0, 0x5e, 0x10, 0x20, 0x30}, {169, 254, 1, 2}, 51111};
inline const Address stranger{{2, 0, 0x5e, 9, 9, 9}, {169, 254, 9, 9}, 40000};
inline const Bytes everybody(6, 0xff);
constexpr unsigned open_port = 4808;
constexpr std::size_t shortest = 60, longest = 1514;  // without the FCS

inline Bytes padded(Bytes body) {
    if (body.size() < shortest) body.resize(shortest);
    return body;
}
/// As on the wire, without its preamble.
inline Bytes whole(const Bytes& body) { return padded(body) + fcs(padded(body)); }

/// A frame without padding and FCS. Fields that are asked for as wrong are put right or wrong by the caller, by put().
inline Bytes ip_frame(const Address& from, const Address& to, unsigned protocol, const Bytes& payload) {
    Bytes header = Bytes{0x45, 0} + big(20 + static_cast<unsigned>(payload.size())) + Bytes{0x12, 0x34, 0x40, 0, 64} +
                   Bytes{static_cast<std::uint8_t>(protocol), 0, 0} + from.ip + to.ip;
    put(header, 10, 0xffff ^ sum(header));
    return to.mac + from.mac + Bytes{8, 0} + header + payload;
}
inline unsigned udp_sum(const Bytes& ip) {
    return sum(cut(ip, 12, 20) + Bytes{0, 17} + cut(ip, 24, 26) + cut(ip, 20, ip.size()));
}
inline Bytes udp_frame(const Address& from, const Address& to, const Bytes& payload) {
    const Bytes datagram = big(from.port) + big(to.port) + big(8 + static_cast<unsigned>(payload.size())) + Bytes{0, 0};
    Bytes frame = ip_frame(from, to, 17, datagram + payload);
    const unsigned check = 0xffff ^ udp_sum(cut(frame, 14, frame.size()));
    put(frame, 40, check == 0 ? 0xffff : check);
    return frame;
}
inline Bytes ping(const Address& from, const Address& to, const Bytes& data) {
    Bytes message = Bytes{8, 0, 0, 0, 0, 5, 0, 1} + data;
    put(message, 2, 0xffff ^ sum(message));
    return ip_frame(from, to, 1, message);
}
inline Bytes arp(const Address& from, const Bytes& mac, const Bytes& ip, unsigned operation = 1) {
    return mac + from.mac + Bytes{8, 6, 0, 1, 8, 0, 6, 4} + big(operation) + from.mac + from.ip + Bytes(6) + ip;
}
inline Address with_port(Address address, unsigned port) {
    address.port = port;
    return address;
}
/// To the open port: what only anybody may ask.
inline Bytes question(const Address& from, std::uint8_t command, const Bytes& mac = board.mac,
                      const Bytes& ip = board.ip) {
    return udp_frame(from, {mac, ip, open_port}, {'H', 'G', command, 0});
}

/// What a board does with frames, each as it comes.
class Rules {
public:
    explicit Rules(Bytes identity, long peer_clocks) : identity_(std::move(identity)), peer_clocks_(peer_clocks) {}

    struct Outcome {
        std::optional<Bytes> core;    ///< bytes for the instrument
        std::optional<Bytes> answer;  ///< a frame that is sent back, with padding, without FCS
        bool disable = false, stop = false;
        bool changed = false;  ///< there is another peer than before
    };
    unsigned accepted = 0, refused = 0, damaged = 0;
    bool enabled = false;

    /// @param frame  from the destination to the FCS
    /// @param room   whether the instrument could take a datagram
    Outcome take(const Bytes& frame, long now, bool broken = false, bool room = true) {
        forget(now);
        if (broken || frame.size() < shortest + 4 || frame.size() > longest + 4 ||
            fcs(cut(frame, 0, frame.size() - 4)) != cut(frame, frame.size() - 4, frame.size())) {
            ++damaged;
            return {};
        }
        const Bytes body = cut(frame, 0, frame.size() - 4);
        const bool mine = cut(body, 0, 6) == board.mac, all = cut(body, 0, 6) == everybody;
        if (cut(body, 12, 22) == Bytes{8, 6, 0, 1, 8, 0, 6, 4, 0, 1})
            return cut(body, 38, 42) == board.ip && (mine || all) ? answer(arp_reply(body)) : Outcome{};
        const std::optional<Bytes> ip = datagram(body);
        if (!ip || (!mine && !all)) return {};
        const bool header_wrong = sum(cut(*ip, 0, 20)) != 0xffff;
        const bool to_us = mine && cut(*ip, 16, 20) == board.ip;
        if ((*ip)[9] == 1 && to_us && at(*ip, 20) == 0x0800) return header_wrong ? Outcome{} : answer(echo(body, *ip));
        if ((*ip)[9] != 17 || at(*ip, 24) != ip->size() - 20) return {};
        if (header_wrong || (at(*ip, 26) != 0 && udp_sum(*ip) != 0xffff)) {
            damaged += to_us && at(*ip, 22) == board.port;
            return {};
        }
        const Address from{cut(body, 6, 12), cut(*ip, 12, 16), at(*ip, 20)};
        const Bytes payload = cut(*ip, 28, ip->size());
        if (at(*ip, 22) == open_port) return asked(from, payload, mine, to_us, all);
        return to_us && at(*ip, 22) == board.port ? spoken(from, payload, now, room) : Outcome{};
    }
    void lose_link() { peer_.reset(); }
    [[nodiscard]] long silence(long now) const { return peer_ ? now - heard_ : 0; }

    /// Replies of the instrument, as they go to the peer.
    [[nodiscard]] Bytes to_peer(const Bytes& replies) const { return sent(*peer_, board.port, replies); }
    [[nodiscard]] bool held() const { return peer_.has_value(); }

private:
    void forget(long now) {
        if (peer_ && now - heard_ > peer_clocks_) peer_.reset();
    }
    static Outcome answer(const Bytes& frame) { return {{}, padded(frame)}; }

    /// The IP datagram in a frame, if it is one that we take, but for its sum: of version 4, without options, whole and
    /// no fragment.
    static std::optional<Bytes> datagram(const Bytes& body) {
        if (at(body, 12) != 0x0800 || body[14] != 0x45) return {};
        const unsigned length = at(body, 16);
        if (length < 28 || 14 + length > body.size()) return {};
        const Bytes ip = cut(body, 14, 14 + length);
        const bool fragment = (at(ip, 6) & 0xbfff) != 0;
        if (fragment) return {};
        return ip;
    }
    static Bytes arp_reply(const Bytes& body) {
        return cut(body, 6, 12) + board.mac + cut(body, 12, 20) + big(2) + board.mac + board.ip + cut(body, 22, 32);
    }
    static Bytes echo(const Bytes& body, const Bytes& ip) {
        const unsigned before = at(ip, 22) + 0x0800;  // RFC 1624: the type is less by 8
        return cut(body, 6, 12) + board.mac + Bytes{8, 0} + cut(ip, 0, 12) + board.ip + cut(ip, 12, 16) + Bytes{0, 0} +
               big((before & 0xffff) + (before >> 16)) + cut(ip, 24, ip.size());
    }
    static Bytes sent(const Address& to, unsigned port, const Bytes& payload) {
        Bytes frame = udp_frame(with_port(board, port), to, payload);
        put(frame, 18, 0);  // identification
        put(frame, 24, 0);
        put(frame, 24, 0xffff ^ sum(cut(frame, 14, 34)));
        put(frame, 40, 0);
        return padded(frame);
    }
    Outcome asked(const Address& from, const Bytes& payload, bool mine, bool to_us, bool all) {
        if (payload.size() != 4 || cut(payload, 0, 2) != Bytes{'H', 'G'} || payload[3] != 0 || !(to_us || all))
            return {};
        const std::uint8_t command = payload[2];
        if (command != 1 && !(mine && (command == 5 || command == 9))) return {};
        const auto flags = static_cast<std::uint8_t>((peer_ ? 1 : 0) + (enabled ? 2 : 0));
        Outcome outcome = answer(sent(from, open_port,
                                      Bytes{'H', 'G', static_cast<std::uint8_t>(command | 0x80), flags} + identity_ +
                                          little(accepted) + little(refused) + little(damaged)));
        outcome.disable = command == 5;
        outcome.stop = command == 9;
        return outcome;
    }
    Outcome spoken(const Address& from, const Bytes& payload, long now, bool room) {
        if (peer_ && *peer_ != from) {
            ++refused;
            return {};
        }
        const bool changed = last_ != from;
        last_ = peer_ = from;
        heard_ = now;
        ++(room ? accepted : damaged);
        Outcome outcome;
        outcome.changed = changed;
        if (room) outcome.core = payload.empty() || payload.back() == 0 ? payload : payload + Bytes{0};
        return outcome;
    }

    Bytes identity_;
    long peer_clocks_, heard_ = 0;
    std::optional<Address> peer_, last_;
};

}  // namespace net
