// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/stream.hpp"

#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct StreamOptions {
    std::string file = "-";
    link::PortSettings port;
    link::StreamSettings stream{.warn = complain};
    std::uint16_t dwell = 1;
    double rate = 0.0;
    bool json = false;
};

int stream(const StreamOptions& options) {
    catch_interrupts();
    link::Device device(options.port);
    const std::uint32_t highest = link::highest_index(device);
    const std::uint32_t records = device.identity().records;
    const auto carried = static_cast<std::uint16_t>(highest > records ? records + 1 : 1);
    const std::uint16_t dwell =
        options.rate > 0.0 ? link::dwell_of(options.rate, link::record_carrier_hz(device, carried)) : options.dwell;
    link::StreamLines source(options.file, dwell, highest);
    ProgressLine progress("stream");
    const link::Played played = link::stream(device, options.stream, source, [&](const link::Playing& now) {
        progress.note(fmt::format("{} indices", now.sent));
        return !interrupted();
    });
    tell(streamed_to_json(played), options.json,
         fmt::format("{} indices, {} underruns", played.sent, played.underruns));
    return 0;
}

}  // namespace

void add_stream(CLI::App& app, Action& action) {
    auto options = std::make_shared<StreamOptions>();
    CLI::App* sub = app.add_subcommand(
        "stream",
        "Turn the outputs on and play indices as they come, no faster than the board takes them; then off again");
    sub->add_option("file", options->file,
                    "Lines 'index' or 'index dwell', of records or of the board's foci; - is standard input")
        ->capture_default_str();
    add_port_options(*sub, options->port);
    auto* dwell = sub->add_option("--dwell", options->dwell,
                                  "Cycles that an index lasts if its line does not say; 0: until the next")
                      ->check(whole(0, 65535))
                      ->capture_default_str();
    sub->add_option("--rate", options->rate, "Indices a second instead: the whole number of cycles that is nearest")
        ->check(positive())
        ->excludes(dwell);
    add_watchdog_option(*sub, options->stream.watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return stream(*options); }; });
}

}  // namespace haptogram::cli
