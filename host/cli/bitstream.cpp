// SPDX-License-Identifier: Apache-2.0
// `haptogram bitstream`: an image into the block RAMs of a bitstream that was placed once (tools/bitstream.py).
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/file.hpp"
#include "board/board.hpp"
#include "command.hpp"
#include "image/image.hpp"
#include "image/manifest.hpp"
#include "link/client.hpp"

extern char** environ;

namespace haptogram::cli {
namespace {

namespace fs = std::filesystem;

struct BitstreamOptions {
    std::string board, image, output;
    std::string placed = "build/boards";
    bool autostart = false;
};

Error failed(const std::string& where, const std::string& what) { return Error(ErrorCode::run_failed, where, what); }

/// A folder for intermediate files that goes with its owner.
class ScratchFolder {
public:
    ScratchFolder() {
        std::string name = (fs::temp_directory_path() / "haptogram-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr)
            throw failed(name, fmt::format("cannot be made: {}", std::strerror(errno)));
        path_ = name;
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    [[nodiscard]] const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

/// A tool from PATH, or the project's PyPI build of it beside the placed boards.
std::string find_tool(const std::string& name, const fs::path& placed) {
    const char* const path = std::getenv("PATH");
    std::string_view rest = path == nullptr ? "" : path;
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(':'), rest.size());
        const fs::path candidate = fs::path(rest.substr(0, end)) / name;
        if (access(candidate.c_str(), X_OK) == 0) return candidate.string();
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    const fs::path own = fs::absolute(placed).parent_path() / "venv" / "bin" / ("yowasp-" + name);
    if (access(own.c_str(), X_OK) == 0) return own.string();
    throw failed(name,
                 fmt::format("is neither in PATH nor in {}; tools/setup installs it", own.parent_path().string()));
}

/// Runs a tool in `folder`, with its standard input and output from and to files there.
/// @return what it said on its standard error
std::string run_tool(const fs::path& folder, const std::vector<std::string>& command, const std::string& input,
                     const std::string& output) {
    const std::string said = (folder / "stderr").string();
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    posix_spawn_file_actions_addopen(&actions, 0, input.empty() ? "/dev/null" : input.c_str(), O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, output.empty() ? "/dev/null" : output.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int error = posix_spawn(&child, command[0].c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw failed(command[0], fmt::format("cannot be started: {}", std::strerror(error)));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    std::string text = read_file(said);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw failed(command[0], fmt::format("failed ({}): {}", status, text));
    return text;
}

/// `words`, one a line, filled up with `filler` to `lines` and on to the whole blocks that the patchers want.
std::string padded(std::string words, const std::string& filler, std::size_t lines) {
    constexpr std::size_t block = 512;
    const auto present = static_cast<std::size_t>(std::count(words.begin(), words.end(), '\n'));
    for (std::size_t i = present; i < (lines + block - 1) / block * block; ++i) words += filler;
    return words;
}

Image image_for(const Board& board, const std::string& file) {
    Image image = from_intel_hex(read_file(file), file);
    link::Identity identity;
    identity.channels = board.parameter("CHANNELS");
    identity.records = board.parameter("RECORDS");
    identity.sequence_depth = board.parameter("SEQUENCE_DEPTH");
    identity.timing_bits = board.parameter("TIMING_BITS");
    identity.pulse_bits = board.parameter("PULSE_BITS");
    identity.clock_hz = board.parameter("CLOCK_HZ");
    link::require_fits(image, identity, file);
    const auto found = problems(image);
    if (!found.empty()) throw bad_input(file, fmt::format("{}; compile it again", found.front()));
    return image;
}

/// The placed design with both memories replaced, packed.
std::string patched(const Board& board, const BitstreamOptions& options, const std::string& primary,
                    const std::string& sequence) {
    const bool ice = board.fpga.family == "ice40";
    const fs::path placed = fs::path(options.placed) / board.name;
    const std::string form = ice ? ".asc" : ".config";
    const ScratchFolder scratch;
    for (const std::string& name : {"placed" + form, std::string("primary.hex"), std::string("sequence.hex")}) {
        std::error_code error;
        fs::copy_file(placed / name, scratch.path() / name, error);
        if (error)
            throw bad_input((placed / name).string(),
                            fmt::format("{}; run 'make bitstream BOARD={}' first, or say where "
                                        "with --placed",
                                        error.message(), board.name));
    }
    write_file(scratch.path() / "primary_new.hex", primary);
    write_file(scratch.path() / "sequence_new.hex", sequence);
    std::string source = "placed" + form;
    const std::string patcher = find_tool(ice ? "icebram" : "ecpbram", options.placed);
    for (const std::string name : {"primary", "sequence"}) {
        const std::string target = name + form;
        const std::string said =
            ice ? run_tool(scratch.path(), {patcher, "-v", name + ".hex", name + "_new.hex"}, source, target)
                : run_tool(scratch.path(),
                           {patcher, "-v", "-i", source, "-o", target, "-f", name + ".hex", "-t", name + "_new.hex"},
                           "", "");
        if (said.find("replaced 1 instances") == std::string::npos)
            throw failed((placed / source).string(),
                         fmt::format("does not hold {} memory as {} describes it; run 'make "
                                     "bitstream BOARD={}' again\n{}",
                                     name, name + ".hex", board.name, said));
        source = target;
    }
    std::vector<std::string> pack = {find_tool(ice ? "icepack" : "ecppack", options.placed)};
    if (!ice) pack.emplace_back("--compress");
    pack.insert(pack.end(), {source, "packed"});
    run_tool(scratch.path(), pack, "", "");
    return read_file(scratch.path() / "packed");
}

int bitstream(const BitstreamOptions& options) {
    const Board board = load_board(options.board);
    const std::string beside = options.output + ".json";
    require_distinct({{"--image", options.image}}, {{"--output", options.output}, {"the manifest", beside}});
    const Image image = image_for(board, options.image);
    std::vector<std::uint32_t> sequence = sequence_words(image);
    if (options.autostart) sequence[0] |= interface::autostart_bit;
    std::string sequence_text;
    for (const std::uint32_t word : sequence) sequence_text += fmt::format("{:08x}\n", word);
    const std::size_t words = std::size_t{board.parameter("RECORDS")} * record_words(image.channels);
    const std::string packed = patched(board, options, padded(primary_readmemh(image), "0000\n", words),
                                       padded(sequence_text, "00000000\n", board.parameter("SEQUENCE_DEPTH")));
    const nlohmann::ordered_json manifest = {{"haptogram", version()},
                                             {"board", board.name},
                                             {"image", options.image},
                                             {"image_sha256", sha256(read_file(options.image))},
                                             {"autostart", options.autostart},
                                             {"watchdog_ms", options.autostart ? 0 : board.parameter("WATCHDOG_MS")},
                                             {"bitstream_sha256", sha256(packed)}};
    write_files({{options.output, packed}, {beside, manifest.dump(2) + "\n"}});
    return 0;
}

}  // namespace

void add_bitstream(CLI::App& app, Action& action) {
    auto options = std::make_shared<BitstreamOptions>();
    CLI::App* sub = app.add_subcommand("bitstream", "put an image into a board's bitstream, without placing it again");
    sub->add_option("--board", options->board, "name of a shipped board, or its file")->required();
    sub->add_option("--image", options->image, "image made by 'haptogram compile --board'")->required();
    sub->add_option("-o,--output", options->output, "bitstream; what is in it goes to FILE.json")->required();
    sub->add_option("--placed", options->placed, "folder of what 'make bitstream' made")->capture_default_str();
    sub->add_flag("--autostart", options->autostart,
                  "the board plays the image at power-up, with no host and no watchdog");
    sub->callback([options, &action] { action = [options] { return bitstream(*options); }; });
}

}  // namespace haptogram::cli
