// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <memory>
#include <optional>
#include <system_error>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/image/image.hpp"
#include "interrupt.hpp"
#include "live.hpp"
#include "port.hpp"

namespace haptogram::cli {
namespace {

struct StreamOptions {
    std::string file = "-";
    PortOptions port;
    std::uint16_t dwell = 1;
    double rate_hz = 0.0;
    std::uint16_t watchdog_ms = 500;
    bool json = false;
};

/// Lines of a file, a pipe or a terminal, as they come: nothing waits for a full buffer.
class Source {
public:
    Source(const std::string& path, std::uint16_t dwell, std::uint32_t records)
        : name_(path == "-" ? "standard input" : path),
          descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)),
          dwell_(dwell),
          records_(records) {
        if (descriptor_ < 0)
            throw bad_input(
                path, fmt::format("cannot be opened: {}; check the path", std::generic_category().message(errno)));
    }
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;
    ~Source() {
        if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
    }

    [[nodiscard]] bool ended() const { return ended_ && text_.empty(); }

    /// The next entry that is there, waiting at most so long for it.
    std::optional<SequenceEntry> next(int milliseconds) {
        std::size_t newline = text_.find('\n');
        while (newline == std::string::npos && !ended_ && fill(milliseconds)) newline = text_.find('\n');
        if (newline == std::string::npos && !(ended_ && !text_.empty())) return {};
        const std::string line = text_.substr(0, newline);
        text_.erase(0, newline == std::string::npos ? newline : newline + 1);
        ++number_;
        return parse(line);
    }

private:
    bool fill(int milliseconds) {
        pollfd wait{descriptor_, POLLIN, 0};
        if (::poll(&wait, 1, milliseconds) <= 0) return false;
        std::array<char, 4096> buffer{};
        const ssize_t count = ::read(descriptor_, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) return false;
        if (count < 0)
            throw bad_input(name_, fmt::format("cannot be read: {}", std::generic_category().message(errno)));
        ended_ = count == 0;
        text_.append(buffer.data(), static_cast<std::size_t>(count));
        return true;
    }

    [[nodiscard]] SequenceEntry parse(const std::string& line) const {
        const char* at = line.data();
        const char* const end = line.data() + line.size();
        const auto skip = [&] {
            while (at != end && (*at == ' ' || *at == '\t' || *at == ',' || *at == '\r')) ++at;
        };
        SequenceEntry entry{0, dwell_};
        skip();
        auto index = std::from_chars(at, end, entry.index);
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
            throw bad_input(
                fmt::format("{}:{}", name_, number_),
                fmt::format("found '{}', expected 'index' or 'index dwell': an index from 0 to {}, a dwell from 0 to "
                            "65535 cycles",
                            line.substr(0, 40), records_));
        return entry;
    }

    std::string name_;
    int descriptor_;
    std::uint16_t dwell_;
    std::uint32_t records_;
    std::string text_;
    std::size_t number_ = 0;
    bool ended_ = false;
};

int stream(const StreamOptions& options) {
    catch_interrupts();
    Device device(options.port);
    const std::uint16_t dwell =
        options.rate_hz > 0.0 ? dwell_of(options.rate_hz, record_carrier_hz(device, 1)) : options.dwell;
    Source source(options.file, dwell, device.identity().records);
    const Fed fed = feed(
        device, options.watchdog_ms, [&](int milliseconds) { return source.next(milliseconds); },
        [&] { return source.ended(); });
    tell(fed, options.json);
    return 0;
}

}  // namespace

void add_stream(CLI::App& app, Action& action) {
    auto options = std::make_shared<StreamOptions>();
    CLI::App* sub = app.add_subcommand(
        "stream",
        "Turn the outputs on and play indices as they come, no faster than the board takes them; then off again");
    sub->add_option("file", options->file, "Lines 'index' or 'index dwell'; - is standard input")
        ->capture_default_str();
    add_port_options(*sub, options->port);
    auto* dwell = sub->add_option("--dwell", options->dwell,
                                  "Cycles that an index lasts if its line does not say; 0: until the next")
                      ->check(whole(0, 65535))
                      ->capture_default_str();
    sub->add_option("--rate", options->rate_hz, "Indices a second instead: the whole number of cycles that is nearest")
        ->check(positive())
        ->excludes(dwell);
    add_watchdog_option(*sub, options->watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return stream(*options); }; });
}

}  // namespace haptogram::cli
