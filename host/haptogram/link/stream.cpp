// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <system_error>
#include <thread>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/live_feed.hpp"

namespace haptogram::link {

StreamLines::StreamLines(const std::string& path, std::uint16_t dwell, std::uint32_t records)
    : name_(path == "-" ? "standard input" : path),
      descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)),
      dwell_(dwell),
      records_(records) {
    if (descriptor_ < 0)
        throw bad_input(path,
                        fmt::format("cannot be opened: {}; check the path", std::generic_category().message(errno)));
}

StreamLines::~StreamLines() {
    if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
}

std::optional<SequenceEntry> StreamLines::next(std::chrono::milliseconds patience) {
    std::size_t newline = text_.find('\n');
    while (newline == std::string::npos && !ended_ && fill(patience)) newline = text_.find('\n');
    if (newline == std::string::npos && !(ended_ && !text_.empty())) return {};
    const std::string line = text_.substr(0, newline);
    text_.erase(0, newline == std::string::npos ? newline : newline + 1);
    ++number_;
    return parse(line);
}

bool StreamLines::fill(std::chrono::milliseconds patience) {
    pollfd wait{descriptor_, POLLIN, 0};
    if (::poll(&wait, 1, static_cast<int>(patience.count())) <= 0) return false;
    std::array<char, 4096> buffer{};
    const ssize_t count = ::read(descriptor_, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) return false;
    if (count < 0) throw bad_input(name_, fmt::format("cannot be read: {}", std::generic_category().message(errno)));
    ended_ = count == 0;
    text_.append(buffer.data(), static_cast<std::size_t>(count));
    return true;
}

SequenceEntry StreamLines::parse(const std::string& line) const {
    const char* at = line.data();
    const char* const end = line.data() + line.size();
    const auto skip = [&] {
        while (at != end && (*at == ' ' || *at == '\t' || *at == ',' || *at == '\r')) ++at;
    };
    SequenceEntry entry{0, dwell_};
    skip();
    const auto index = std::from_chars(at, end, entry.index);
    at = index.ptr;
    skip();
    bool good = index.ec == std::errc();
    if (good && at != end) {
        const auto dwell = std::from_chars(at, end, entry.dwell);
        at = dwell.ptr;
        skip();
        good = dwell.ec == std::errc() && at == end;
    }
    if (!good || entry.index > records_)
        throw bad_input(fmt::format("{}:{}", name_, number_),
                        fmt::format("found '{}', expected 'index' or 'index dwell': an index from 0 to {}, a dwell "
                                    "from 0 to 65535 cycles",
                                    line.substr(0, 40), records_));
    return entry;
}

Played stream(Commands& device, const StreamSettings& settings, StreamSource& source, const Watch& watch) {
    using Clock = std::chrono::steady_clock;
    const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
    const Status before = device.status();
    Played played;
    Playing now{.status = before};
    const auto begun = Clock::now();
    const auto learn = [&](const Status& status) {
        now.status = status;
        now.underruns = static_cast<std::uint16_t>(status.underruns - before.underruns);
    };
    const auto go_on = [&] {
        now.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
        now.sent = played.sent;
        if (!played.interrupted && watch && !watch(now)) played.interrupted = true;
        return !played.interrupted;
    };
    {
        const Outputs on(device, settings.watchdog_ms, settings.warn);
        LiveFeed fifo(device, device.identity());
        std::optional<SequenceEntry> entry;
        auto asked = Clock::now();
        while (go_on()) {
            if (Clock::now() - asked > pause) {
                learn(device.status());
                require_on(now.status);
                asked = Clock::now();
            }
            if (!entry) entry = source.next(pause);
            if (!entry && source.ended()) break;
            if (!entry || fifo.room() < fifo.frame()) {  // learning the FIFO's level also keeps the watchdog quiet
                if (entry && device.unanswered() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                fifo.refresh();
                continue;
            }
            std::vector<std::uint16_t> indices;
            const std::uint16_t dwell = entry->dwell;
            while (entry && entry->dwell == dwell && indices.size() < fifo.room()) {
                indices.push_back(entry->index);
                entry = source.next(std::chrono::milliseconds(0));
            }
            fifo.push(indices, dwell);
            played.sent += indices.size();
        }
        // Silence for good comes last: running out of indices would count as an underrun.
        while (go_on() && fifo.room() == 0) fifo.refresh();
        if (!played.interrupted) fifo.push({0}, 0);
        for (learn(device.status()); go_on() && (now.status.live_level > 0 || now.status.present_index != 0);
             learn(device.status())) {
            require_on(now.status);
            std::this_thread::sleep_for(pause);
        }
    }
    const auto since = [&](std::uint16_t Status::*counter) {
        return static_cast<std::uint16_t>(now.status.*counter - before.*counter);
    };
    played.underruns = since(&Status::underruns);
    played.refused_records = since(&Status::refused_records);
    played.watchdog_trips = since(&Status::watchdog_trips);
    played.guard_trips = since(&Status::guard_trips);
    return played;
}

std::uint16_t dwell_of(double rate, double carrier_hz) {
    constexpr double most = 65535.0;
    constexpr double tolerance = 0.05;
    const double cycles = std::clamp(std::round(carrier_hz / rate), 1.0, most);
    const double made = carrier_hz / cycles;
    if (std::abs(made - rate) > tolerance * rate)
        throw bad_argument(
            "rate", fmt::format("{} a second cannot be made of whole cycles at {:.0f} Hz; the nearest is {:.6g}", rate,
                                carrier_hz, made));
    return static_cast<std::uint16_t>(cycles);
}

}  // namespace haptogram::link
