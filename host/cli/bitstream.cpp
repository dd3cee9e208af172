// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/verbs/patch.hpp"

namespace haptogram::cli {
namespace {

struct BitstreamOptions {
    PatchOptions patch;
    std::string image, output;
    bool empty = false;
};

int bitstream(BitstreamOptions options) {
    if (options.image.empty() != options.empty)
        throw bad_argument("bitstream", "give --image FILE, or --empty for memories without one");
    if (!options.empty) options.patch.image = options.image;
    const std::string beside = options.output + ".json";
    require_distinct({{"--image", options.image}}, {{"--output", options.output}, {"the manifest", beside}});
    // No bitstream holds what an SDRAM is filled with.
    const bool in_flash = !options.empty && load_board(options.patch.board).sdram;
    if (in_flash && options.patch.rx_delay)
        throw bad_argument("rx-delay", "an image for the flash has no inputs; give it with --empty");
    PatchOptions wanted = options.patch;
    wanted.makers = path_makers();
    const Patched patched = in_flash ? flash_contents(wanted) : patch(wanted);
    write_files({{options.output, patched.bitstream}, {beside, patched.manifest}});
    return 0;
}

}  // namespace

void add_bitstream(CLI::App& app, Action& action) {
    auto options = std::make_shared<BitstreamOptions>();
    CLI::App* sub = app.add_subcommand("bitstream",
                                       "Put an image into a board's bitstream, without placing it again; with an "
                                       "SDRAM, make what goes into its flash");
    sub->add_option("--board", options->patch.board, "Name of a shipped board, or its file")->required();
    auto* image =
        sub->add_option("--image", options->image, "Image made by 'haptogram compile --board', or a project (.toml)");
    sub->add_flag("--empty", options->empty, "No image: empty memories, to be filled over the link")->excludes(image);
    sub->add_option("-o,--output", options->output, "Bitstream; what is in it goes to FILE.json")->required();
    sub->add_option("--placed", options->patch.placed, "Folder of what 'make bitstream' made")->capture_default_str();
    sub->add_flag("--autostart", options->patch.autostart,
                  "The board plays the image at power-up, with no host and no watchdog");
    sub->add_option("--rx-delay", options->patch.rx_delay,
                    "Delay of the inputs of a board over Ethernet, in steps of 25 ps, instead of its file's");
    sub->callback([options, &action] { action = [options] { return bitstream(*options); }; });
}

}  // namespace haptogram::cli
