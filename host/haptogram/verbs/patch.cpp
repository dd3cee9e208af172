// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/patch.hpp"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <nlohmann/json.hpp>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/ecp5_config.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/source.hpp"

namespace haptogram {
namespace {

namespace fs = std::filesystem;

Error failed(const std::string& where, const std::string& what) { return {ErrorCode::failed, where, what}; }

/// The path of a tool: from PATH, or from the Python environment of tools/setup, which is beside the placed boards.
std::string find_tool(const std::string& name, const fs::path& placed) {
    if (const fs::path found = find_program(name); !found.empty()) return found.string();
    const fs::path own = fs::absolute(placed).parent_path() / "venv" / "bin" / ("yowasp-" + name);
    if (fs::exists(own)) return own.string();
    throw failed(name,
                 fmt::format("is neither in PATH nor in {}; tools/setup dev installs it", own.parent_path().string()));
}

/// Runs a tool that must succeed.
/// @return what it said on its standard error
std::string run_tool(const fs::path& folder, const std::vector<std::string>& command, const fs::path& input,
                     const fs::path& output) {
    const ProcessResult result = run_process(folder, command, input, output);
    if (!result.succeeded)
        throw failed(command[0], fmt::format("failed; is the placed design damaged? 'make bitstream' makes it anew\n{}",
                                             result.said));
    return result.said;
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

Image image_for(const Board& board, const std::string& hex, const std::string& file) {
    Image image = from_intel_hex(hex, file);
    require_fits(image, board.parameters, file);
    require_playable(image, file);
    if (board.parameters.sdram == 0 && (image.foci || image.modulation))
        throw bad_input(file,
                        "its parameters, geometry and modulation are in no bitstream; compile it with --records, or "
                        "upload it",
                        {"records"});
    return image;
}

/// A file that tools/bitstream.py leaves beside the placed design.
fs::path placed_file(const Board& board, const PatchOptions& options, const std::string& name) {
    fs::path file = options.placed / board.name / name;
    if (!fs::exists(file))
        throw bad_input(
            file.string(),
            fmt::format("is not there; run 'make bitstream BOARD={}' first, or say where it is", board.name),
            {"placed"});
    return file;
}

std::string patched_ice40(const Board& board, const PatchOptions& options, const std::vector<Contents>& memories) {
    const TemporaryFolder scratch;
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

std::string patched_ecp5(const Board& board, const PatchOptions& options, const std::vector<Contents>& memories) {
    const TemporaryFolder scratch;
    const fs::path placed = placed_file(board, options, "placed.config");
    std::string config = read_file(placed);
    for (const Contents& memory : memories)
        config = replace_block_ram(config, read_words(placed_file(board, options, memory.name + "_init.hex")),
                                   memory.words, memory.width, placed.string());
    if (options.rx_delay && *options.rx_delay != board.network->rx_delay)
        config = replace_rx_delay(std::move(config), board.network->rx_delay, *options.rx_delay, placed.string());
    write_file(scratch.path() / "patched.config", config);
    run_tool(scratch.path(), {find_tool("ecppack", options.placed), "--compress", "patched.config", "packed"}, "", "");
    return read_file(scratch.path() / "packed");
}

void say_image(nlohmann::ordered_json& manifest, const PatchOptions& options, const std::string& hex) {
    manifest["image"] = *options.image;
    manifest["image_sha256"] = sha256(hex);
}

void say_start(nlohmann::ordered_json& manifest, const Board& board, const PatchOptions& options) {
    manifest["autostart"] = options.autostart;
    // A board that starts by itself has no host, so nothing for the watchdog to watch.
    manifest["watchdog_ms"] = options.autostart ? 0 : board.parameters.watchdog_ms;
}

}  // namespace

Patched flash_contents(const PatchOptions& options) {
    const Board board = load_board(options.board);
    const std::string hex = open_hex(*options.image, options.makers);
    const link::Bytes bytes =
        link::flash_image(image_for(board, hex, *options.image), options.autostart, *options.image);
    Patched made{std::string(bytes.begin(), bytes.end()), {}};
    nlohmann::ordered_json manifest = {{"haptogram", version()}, {"board", board.name}};
    say_image(manifest, options, hex);
    manifest["flash_offset"] = interface::flash_image::first;
    say_start(manifest, board, options);
    manifest["flash_sha256"] = sha256(made.bitstream);
    made.manifest = manifest.dump(2) + "\n";
    return made;
}

Patched patch(const PatchOptions& options, const Progress& progress) {
    const Board board = load_board(options.board);
    if (!options.image && options.autostart)
        throw bad_argument("autostart", "there is nothing to play in an empty memory; give an image", {"image"});
    if (options.rx_delay && (!board.network || *options.rx_delay > 127))
        throw bad_argument(
            "rx_delay", board.network ? fmt::format("found {}, expected 0 to 127, in steps of 25 ps", *options.rx_delay)
                                      : fmt::format("{} has no network whose inputs it could delay", board.name));
    if (options.image && board.parameters.sdram != 0)
        throw bad_input(
            *options.image,
            fmt::format("the records of {} lie in an SDRAM, so no bitstream holds them; 'haptogram bitstream "
                        "--image' makes what goes into its flash, or upload them",
                        board.name),
            {"image"});
    std::vector<Contents> memories = {{"primary", interface::primary_word_bits, {}},
                                      {"sequence", interface::sequence_word_bits, {}}};
    nlohmann::ordered_json manifest = {{"haptogram", version()}, {"board", board.name}};
    if (options.image) {
        const std::string hex = open_hex(*options.image, options.makers);
        const Image image = image_for(board, hex, *options.image);
        for (const std::uint16_t word : primary_words(image)) memories[0].words.push_back(word);
        memories[1].words = sequence_words(image);
        if (options.autostart) interface::sequence_header_field::autostart.set(memories[1].words, 1);
        say_image(manifest, options, hex);
    }
    memories[0].words.resize(std::size_t{board.parameters.records} * record_words(board.parameters.channels));
    memories[1].words.resize(board.parameters.sequence_depth);
    if (board.parameters.sdram != 0) memories.erase(memories.begin());
    progress(0.1);
    Patched patched;
    patched.bitstream =
        board.fpga.family == "ice40" ? patched_ice40(board, options, memories) : patched_ecp5(board, options, memories);
    if (board.network) manifest["rx_delay"] = options.rx_delay.value_or(board.network->rx_delay);
    say_start(manifest, board, options);
    manifest["bitstream_sha256"] = sha256(patched.bitstream);
    patched.manifest = manifest.dump(2) + "\n";
    progress(1.0);
    return patched;
}

}  // namespace haptogram
