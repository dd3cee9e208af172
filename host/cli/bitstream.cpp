// SPDX-License-Identifier: Apache-2.0
// `haptogram bitstream`: an image into the block RAMs of a bitstream that was placed once (tools/bitstream.py).
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/boards/board.hpp"
#include "haptogram/boards/ecp5_config.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/image/manifest.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/transfer.hpp"

extern char** environ;

namespace haptogram::cli {
namespace {

namespace fs = std::filesystem;

struct BitstreamOptions {
    std::string board, image, output;
    std::string placed = "build/boards";
    bool autostart = false, empty = false;
};

Error failed(const std::string& where, const std::string& what) { return Error(ErrorCode::failed, where, what); }

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
        throw failed(command[0],
                     fmt::format("failed; is the placed design damaged? 'make bitstream' makes it anew\n{}", text));
    return text;
}

/// What goes into one of the two memories.
struct Contents {
    std::string name;  ///< of its files beside the placed design
    unsigned width;    ///< bits
    std::vector<std::uint32_t> words;
};

/// $readmemh text, filled up with zeros to the whole blocks that icebram wants.
std::string padded_text(const Contents& memory) {
    constexpr std::size_t block = 256;
    std::string text;
    for (std::size_t i = 0; i < (memory.words.size() + block - 1) / block * block; ++i)
        text += fmt::format("{:0{}x}\n", i < memory.words.size() ? memory.words[i] : 0U, memory.width / 4);
    return text;
}

std::vector<std::uint32_t> read_words(const fs::path& file) {
    const std::string text = read_file(file);
    std::vector<std::uint32_t> words;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (at < end) {
        std::uint32_t word = 0;
        const auto [next, error] = std::from_chars(at, end, word, 16);
        if (error != std::errc())
            throw bad_input(file.string(), fmt::format("word {} is no hexadecimal number; run 'make bitstream' again",
                                                       words.size() + 1));
        words.push_back(word);
        at = next;
        while (at < end && std::isspace(static_cast<unsigned char>(*at)) != 0) ++at;
    }
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

/// A file that tools/bitstream.py leaves beside the placed design.
fs::path placed_file(const Board& board, const BitstreamOptions& options, const std::string& name) {
    fs::path file = fs::path(options.placed) / board.name / name;
    if (!fs::exists(file))
        throw bad_input(file.string(),
                        fmt::format("is not there; run 'make bitstream BOARD={}' first, or say where it is "
                                    "with --placed",
                                    board.name));
    return file;
}

std::string patched_ice40(const Board& board, const BitstreamOptions& options, const std::vector<Contents>& memories) {
    const ScratchFolder scratch;
    const std::string patcher = find_tool("icebram", options.placed);
    std::string source = fs::absolute(placed_file(board, options, "placed.asc")).string();
    for (const Contents& memory : memories) {
        const std::string from = fs::absolute(placed_file(board, options, memory.name + ".hex")).string();
        const std::string to = (scratch.path() / (memory.name + ".hex")).string();
        const std::string target = (scratch.path() / (memory.name + ".asc")).string();
        write_file(to, padded_text(memory));
        const std::string said = run_tool(scratch.path(), {patcher, "-v", from, to}, source, target);
        if (said.find("replaced 1 instances") == std::string::npos)
            throw failed(source,
                         fmt::format("does not hold {} memory as {} describes it; run 'make bitstream BOARD={}' "
                                     "again\n{}",
                                     memory.name, from, board.name, said));
        source = target;
    }
    run_tool(scratch.path(), {find_tool("icepack", options.placed), source, "packed"}, "", "");
    return read_file(scratch.path() / "packed");
}

std::string patched_ecp5(const Board& board, const BitstreamOptions& options, const std::vector<Contents>& memories) {
    const ScratchFolder scratch;
    const fs::path placed = placed_file(board, options, "placed.config");
    std::string config = read_file(placed);
    for (const Contents& memory : memories)
        config = replace_block_ram(config, read_words(placed_file(board, options, memory.name + "_init.hex")),
                                   memory.words, memory.width, placed.string());
    write_file(scratch.path() / "patched.config", config);
    run_tool(scratch.path(), {find_tool("ecppack", options.placed), "--compress", "patched.config", "packed"}, "", "");
    return read_file(scratch.path() / "packed");
}

int bitstream(const BitstreamOptions& options) {
    const Board board = load_board(options.board);
    const std::string beside = options.output + ".json";
    if (options.image.empty() != options.empty)
        throw Error(ErrorCode::bad_argument, "bitstream", "give --image FILE, or --empty for memories without one");
    if (options.empty && options.autostart)
        throw Error(ErrorCode::bad_argument, "--autostart",
                    "there is nothing to play in an empty memory; give --image");
    require_distinct({{"--image", options.image}}, {{"--output", options.output}, {"the manifest", beside}});

    std::vector<Contents> memories = {{"primary", 16, {}}, {"sequence", 32, {}}};
    nlohmann::ordered_json manifest = {{"haptogram", version()}, {"board", board.name}};
    if (!options.empty) {
        const Image image = image_for(board, options.image);
        for (const std::uint16_t word : primary_words(image)) memories[0].words.push_back(word);
        memories[1].words = sequence_words(image);
        if (options.autostart) memories[1].words[0] |= interface::autostart_bit;
        manifest["image"] = options.image;
        manifest["image_sha256"] = sha256(read_file(options.image));
    }
    memories[0].words.resize(std::size_t{board.parameter("RECORDS")} * record_words(board.parameter("CHANNELS")));
    memories[1].words.resize(board.parameter("SEQUENCE_DEPTH"));

    const std::string packed =
        board.fpga.family == "ice40" ? patched_ice40(board, options, memories) : patched_ecp5(board, options, memories);
    manifest["autostart"] = options.autostart;
    // A stand-alone board has no host that could fall silent.
    manifest["watchdog_ms"] = options.autostart ? 0 : board.parameter("WATCHDOG_MS");
    manifest["bitstream_sha256"] = sha256(packed);
    write_files({{options.output, packed}, {beside, manifest.dump(2) + "\n"}});
    return 0;
}

}  // namespace

void add_bitstream(CLI::App& app, Action& action) {
    auto options = std::make_shared<BitstreamOptions>();
    CLI::App* sub = app.add_subcommand("bitstream", "put an image into a board's bitstream, without placing it again");
    sub->add_option("--board", options->board, "name of a shipped board, or its file")->required();
    auto* image = sub->add_option("--image", options->image, "image made by 'haptogram compile --board'");
    sub->add_flag("--empty", options->empty, "no image: empty memories, to be filled over the link")->excludes(image);
    sub->add_option("-o,--output", options->output, "bitstream; what is in it goes to FILE.json")->required();
    sub->add_option("--placed", options->placed, "folder of what 'make bitstream' made")->capture_default_str();
    sub->add_flag("--autostart", options->autostart,
                  "the board plays the image at power-up, with no host and no watchdog");
    sub->callback([options, &action] { action = [options] { return bitstream(*options); }; });
}

}  // namespace haptogram::cli
