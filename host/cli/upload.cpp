// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/link/transfer.hpp"
#include "port.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

struct UploadOptions {
    std::string image;
    PortOptions port;
    double wait_s = 30.0;
    bool verify = false;
    bool json = false;
};

/// Opens the port again after it was lost, for as long as is left of `wait_s`.
/// @return empty when it did not come back
std::unique_ptr<Device> come_back(const PortOptions& port, double& wait_s) {
    constexpr std::chrono::milliseconds pause{200};
    while (wait_s > 0.0) {
        const auto begun = std::chrono::steady_clock::now();
        std::unique_ptr<Device> device;
        std::this_thread::sleep_for(pause);
        try {
            device = std::make_unique<Device>(port);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::device) throw;
        }
        wait_s -= std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        if (device) return device;
    }
    return {};
}

int upload(const UploadOptions& options) {
    const Image image = from_intel_hex(read_file(options.image), options.image);
    const std::vector<std::string> found = problems(image);
    if (!found.empty()) throw bad_input(options.image, found.front());
    auto device = std::make_unique<Device>(options.port);
    link::require_fits(image, device->identity(), options.image);
    const auto begun = std::chrono::steady_clock::now();
    ProgressLine progress("upload");
    link::Uploaded outcome;
    std::uint64_t again = 0;
    unsigned losses = 0;
    double wait_s = options.wait_s;
    for (bool done = false; !done;) {
        try {
            // Of the last attempt: what came through before a loss is found on the board.
            outcome = link::upload(device->client(), image, progress.callback());
            done = true;
        } catch (const link::LinkLost& lost) {
            again += device->client().retransmissions();
            device.reset();
            ++losses;
            complain(fmt::format("{}; waiting {:.0f} s for it to come back", lost.what(), wait_s));
            device = come_back(options.port, wait_s);
            if (!device)
                throw Error(ErrorCode::device, options.port.port,
                            "it did not come back; the same command goes on where this one stopped");
            link::require_fits(image, device->identity(), options.image);
        }
    }
    again += device->client().retransmissions();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (options.verify) {
        const std::string difference = link::compare(device->client(), image, progress.callback().in_stage("verify"));
        if (!difference.empty())
            throw Error(ErrorCode::device, options.image, difference + "; does another program write to this board?");
    }
    const nlohmann::ordered_json json = {{"records", image.records.size()},
                                         {"sequence_entries", image.sequence.size()},
                                         {"frames", outcome.pieces},
                                         {"frames_written", outcome.written},
                                         {"seconds", seconds},
                                         {"retransmissions", again},
                                         {"link_losses", losses},
                                         {"verified", options.verify}};
    if (options.json)
        fmt::print("{}\n", json.dump(1));
    else
        fmt::print("{} records and {} sequence entries in {:.2f} s, {} of {} frames written{}, {} sent again\n",
                   image.records.size(), image.sequence.size(), seconds, outcome.written, outcome.pieces,
                   options.verify ? ", read back and equal" : ", digests equal", again);
    return 0;
}

}  // namespace

void add_upload(CLI::App& app, Action& action) {
    auto options = std::make_shared<UploadOptions>();
    CLI::App* sub = app.add_subcommand("upload", "Write what differs of an image into a board's memories");
    sub->add_option("image", options->image, "Intel HEX image")->required();
    add_port_options(*sub, options->port);
    sub->add_option("--wait", options->wait_s, "Seconds in which a port that was unplugged may come back")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_flag("--verify", options->verify, "Read all of it back and compare, beyond the digests");
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return upload(*options); }; });
}

}  // namespace haptogram::cli
