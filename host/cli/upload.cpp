// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/instrument/source.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct UploadOptions {
    link::PortSettings port;
    link::UploadSettings upload;
    bool json = false;
};

int upload(const UploadOptions& options) {
    link::UploadSettings settings = options.upload;
    const Image image = from_intel_hex(open_hex(settings.image), settings.image);
    require_playable(image, settings.image);
    ProgressLine progress("upload");
    settings.port = options.port.port;
    settings.progress = progress.callback();
    settings.lost = [](const link::LinkLost& lost, double wait_s) {
        complain(fmt::format("{}; waiting {:.0f} s for it to come back", lost.what(), wait_s));
    };
    const link::UploadReport report =
        link::upload([&] { return std::make_unique<link::Device>(options.port); }, image, settings);
    tell(to_json(report), options.json,
         fmt::format("{} records and {} sequence entries in {:.2f} s, {} of {} frames written{}, {} sent again",
                     report.records, report.sequence_entries, report.seconds, report.frames_written, report.frames,
                     report.verified ? ", read back and equal" : ", digests equal", report.retransmissions));
    return 0;
}

}  // namespace

void add_upload(CLI::App& app, Action& action) {
    auto options = std::make_shared<UploadOptions>();
    CLI::App* sub = app.add_subcommand("upload", "Write what differs of an image into a board's memories");
    sub->add_option("image", options->upload.image, "Intel HEX image, or a project (.toml)")->required();
    add_port_options(*sub, options->port);
    sub->add_option("--wait", options->upload.wait_s, "Seconds in which a port that was unplugged may come back")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_flag("--verify", options->upload.verify, "Read all of it back and compare, beyond the digests");
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return upload(*options); }; });
}

}  // namespace haptogram::cli
