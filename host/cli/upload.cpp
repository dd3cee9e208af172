// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/source.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "rig_ports.hpp"

namespace haptogram::cli {
namespace {

struct UploadOptions {
    RigPorts ports;
    link::UploadSettings upload;
    bool json = false;
};

link::UploadReport upload_to(const link::PortSettings& port, const Image& image, link::UploadSettings settings,
                             const std::string& stage) {
    ProgressLine progress(stage);
    settings.port = port.port;
    settings.progress = progress.callback();
    settings.lost = [](const link::LinkLost& lost, double wait_s) {
        complain(fmt::format("{}; waiting {:.0f} s for it to come back", lost.what(), wait_s));
    };
    return link::upload([&] { return std::make_unique<link::Device>(port); }, image, settings);
}

std::string sentence_of(const link::UploadReport& report) {
    return fmt::format("{} records and {} sequence entries in {:.2f} s, {} of {} frames written{}, {} sent again",
                       report.records, report.sequence_entries, report.seconds, report.frames_written, report.frames,
                       report.verified ? ", read back and equal" : ", digests equal", report.retransmissions);
}

/// Each tile's image to its board, one after the other.
int upload_rig(const UploadOptions& options) {
    const RigBundle bundle = load_rig_bundle(options.ports.rig);
    const std::vector<link::PortSettings> ports = options.ports.of(bundle);
    nlohmann::ordered_json reports = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < ports.size(); ++i) {
        const std::string name = link::name_of_tile(i, ports[i].port);
        link::UploadSettings settings = options.upload;
        settings.image = bundle.tiles[i].name;
        try {
            const link::UploadReport report =
                upload_to(ports[i], bundle.tiles[i].image, settings, fmt::format("upload tile {}", i + 1));
            reports.push_back(to_json(report));
            if (!options.json) fmt::print("{}: {}\n", name, sentence_of(report));
        } catch (const Error& error) {
            throw Error(error.code(), name, error.what());
        }
    }
    if (options.json) tell(reports, true);
    return 0;
}

int upload(const UploadOptions& options) {
    if (options.ports.is_rig()) return upload_rig(options);
    const link::UploadSettings& settings = options.upload;
    if (settings.image.empty())
        throw bad_argument("image", "there is nothing to upload; name an image, or a rig with --rig");
    link::PortSettings port = options.ports.one();
    port.likely = likely_rate(settings.image);
    const Image image = from_intel_hex(open_hex(settings.image, path_makers()), settings.image);
    require_playable(image, settings.image);
    const link::UploadReport report = upload_to(port, image, settings, "upload");
    tell(to_json(report), options.json, sentence_of(report));
    return 0;
}

}  // namespace

void add_upload(CLI::App& app, Action& action) {
    auto options = std::make_shared<UploadOptions>();
    CLI::App* sub = app.add_subcommand(
        "upload", "Write an image, or each image of a rig, into a board's memories: only what differs");
    auto* image = sub->add_option("image", options->upload.image, "Intel HEX image, or a project (.toml, .haptogram)");
    add_rig_port_options(*sub, options->ports)->excludes(image);
    sub->add_option("--wait", options->upload.wait_s, "Seconds in which a port that was unplugged may come back")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_flag("--verify", options->upload.verify, "Also read the whole image back and compare");
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return upload(*options); }; });
}

}  // namespace haptogram::cli
