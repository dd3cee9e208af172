// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/transfer.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct DownloadOptions {
    std::string output;
    link::PortSettings port;
    std::uint32_t records = 0;
    bool json = false;
};

int download(const DownloadOptions& options) {
    link::Device device(options.port);
    if (options.records > device.identity().records)
        throw Error(ErrorCode::bad_argument, "--records",
                    fmt::format("the board holds {}, not {}", device.identity().records, options.records));
    ProgressLine progress("download");
    const Image image =
        link::download(device, device.identity(), options.records, options.port.port, progress.callback());
    if (image.records.empty())
        throw Error(ErrorCode::device, options.port.port, "its sequence plays no record; ask for some by --records");
    write_file(options.output, to_intel_hex(image));
    const std::vector<std::string> found = problems(image);
    for (const std::string& problem : found) complain(fmt::format("{}: {}", options.port.port, problem));
    if (options.output == "-") return 0;
    tell({{"records", image.records.size()}, {"sequence_entries", image.sequence.size()}, {"problems", found}},
         options.json, fmt::format("{} records and {} sequence entries", image.records.size(), image.sequence.size()));
    return 0;
}

}  // namespace

void add_download(CLI::App& app, Action& action) {
    auto options = std::make_shared<DownloadOptions>();
    CLI::App* sub = app.add_subcommand("download", "Read the image in a board's memories back into a file");
    sub->add_option("-o,--output", options->output, "Intel HEX image")->required();
    sub->add_option("--records", options->records,
                    "At least so many records, also those that the sequence does not play")
        ->check(whole(1, 65535));
    add_port_options(*sub, options->port);
    sub->add_flag("--json", options->json, "Print what was found as JSON");
    sub->callback([options, &action] { action = [options] { return download(*options); }; });
}

}  // namespace haptogram::cli
