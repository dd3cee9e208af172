// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/progress.hpp"
#include "command.hpp"
#include "image/intel_hex.hpp"
#include "port.hpp"

namespace haptogram::cli {
namespace {

struct UploadOptions {
    std::string image;
    PortOptions port;
    bool verify = false;
    bool json = false;
};

int upload(const UploadOptions& options) {
    const Image image = from_intel_hex(read_file(options.image), options.image);
    const std::vector<std::string> found = problems(image);
    if (!found.empty()) throw bad_input(options.image, found.front());
    Device device(options.port);
    link::require_fits(image, device.identity(), options.image);
    const auto begun = std::chrono::steady_clock::now();
    Progress progress("upload");
    device.client().upload(image, [&](double fraction) { progress.update(fraction); });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (options.verify) {
        const std::string difference =
            device.client().compare(image, [&](double fraction) { progress.update(fraction, "verify"); });
        if (!difference.empty())
            throw Error(ErrorCode::device, options.image, difference + "; does another program write to this board?");
    }
    const nlohmann::ordered_json json = {{"records", image.records.size()},
                                         {"sequence_entries", image.sequence.size()},
                                         {"seconds", seconds},
                                         {"retransmissions", device.client().retransmissions()},
                                         {"verified", options.verify}};
    if (options.json)
        fmt::print("{}\n", json.dump(1));
    else
        fmt::print("{} records and {} sequence entries in {:.2f} s{}, {} frames sent again\n", image.records.size(),
                   image.sequence.size(), seconds, options.verify ? ", read back and equal" : "",
                   device.client().retransmissions());
    return 0;
}

}  // namespace

void add_upload(CLI::App& app, Action& action) {
    auto options = std::make_shared<UploadOptions>();
    CLI::App* sub = app.add_subcommand("upload", "Write an image into a board's memories");
    sub->add_option("image", options->image, "Intel HEX image")->required();
    add_port_options(*sub, options->port);
    sub->add_flag("--verify", options->verify, "Read it back and compare");
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return upload(*options); }; });
}

}  // namespace haptogram::cli
