// SPDX-License-Identifier: Apache-2.0
#include "haptogram/boards/board.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <set>
#include <sstream>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram {
namespace {

std::string place(const std::string& file, const toml::node& node) {
    return fmt::format("{}:{}", file, node.source().begin.line);
}

/// The value as the file has it, or what it is when that would fill a page.
std::string found(const toml::node& node) {
    if (node.is_table()) return "a table";
    if (const toml::array* list = node.as_array()) return fmt::format("a list of {}", list->size());
    std::ostringstream text;
    node.visit([&text](const auto& value) { text << value; });
    return text.str();
}

bool is_line(const std::string& text) {
    return !text.empty() &&
           std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

/// Fit for a cell of a table, of CSV and of a pin file.
bool is_word(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(),
                                        [](unsigned char c) { return c > 0x20 && c < 0x7f && c != ',' && c != '"'; });
}

/// One table of the file. What is asked for must be there, and `only` refuses what nobody asks for.
class Section {
public:
    Section(std::string file, const toml::table& table, std::string name = {})
        : file_(std::move(file)), table_(table), name_(std::move(name)) {}

    [[nodiscard]] bool has(std::string_view key) const { return table_.contains(key); }

    [[nodiscard]] Section section(const std::string& key) const {
        const toml::node& node = need(key, "a table");
        if (!node.is_table()) fail(node, key, "a table");
        return {file_, *node.as_table(), key};
    }

    [[nodiscard]] std::string text(std::string_view key) const {
        constexpr const char* expected = "a line of text in quotes";
        const toml::node& node = need(key, expected);
        auto value = node.value<std::string>();
        if (!value || !is_line(*value)) fail(node, key, expected);
        return *std::move(value);
    }

    [[nodiscard]] std::string ball(std::string_view key) const {
        constexpr const char* expected = "a ball in quotes, such as \"C4\"";
        const toml::node& node = need(key, expected);
        auto value = node.value<std::string>();
        if (!value || !is_word(*value)) fail(node, key, expected);
        return *std::move(value);
    }

    [[nodiscard]] std::uint32_t whole(std::string_view key, std::uint32_t low, std::uint32_t high) const {
        const std::string expected = fmt::format("a whole number from {} to {}", low, high);
        const toml::node& node = need(key, expected);
        const toml::value<std::int64_t>* value = node.as_integer();
        if (value == nullptr || value->get() < low || value->get() > high) fail(node, key, expected);
        return static_cast<std::uint32_t>(value->get());
    }

    /// @param fits  what each text must be; balls are words, all else are lines
    [[nodiscard]] std::vector<std::string> texts(std::string_view key, bool (*fits)(const std::string&)) const {
        constexpr const char* expected = "a list of texts in quotes";
        const toml::node& node = need(key, expected);
        if (!node.is_array()) fail(node, key, expected);
        std::vector<std::string> result;
        for (const toml::node& entry : *node.as_array()) {
            auto value = entry.value<std::string>();
            if (!value || !fits(*value)) fail(entry, key, expected);
            result.push_back(*std::move(value));
        }
        return result;
    }

    [[nodiscard]] const toml::node& need(std::string_view key, std::string_view expected) const {
        const toml::node* node = table_.get(key);
        if (node == nullptr)
            throw bad_input(name_.empty() ? file_ : place(file_, table_),
                            fmt::format("{} is missing; it must be {}", full(key), expected));
        return *node;
    }

    [[noreturn]] void fail(const toml::node& node, std::string_view key, std::string_view expected) const {
        throw bad_input(place(file_, node), fmt::format("{} must be {}, found {}", full(key), expected, found(node)));
    }

    void only(std::initializer_list<std::string_view> keys) const {
        for (const auto& [key, node] : table_)
            if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
                throw bad_input(place(file_, node),
                                fmt::format("unknown key {}; known are {}", full(key.str()), fmt::join(keys, ", ")));
    }

private:
    [[nodiscard]] std::string full(std::string_view key) const {
        return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
    }

    std::string file_;
    const toml::table& table_;
    std::string name_;
};

Board::Fpga read_fpga(const Section& section) {
    section.only({"family", "device", "package", "speed", "top"});
    Board::Fpga fpga;
    fpga.family = section.text("family");
    if (fpga.family != "ecp5" && fpga.family != "ice40")
        section.fail(section.need("family", ""), "family", "\"ecp5\" or \"ice40\"");
    fpga.device = section.text("device");
    fpga.package = section.text("package");
    if (fpga.family == "ecp5" || section.has("speed")) fpga.speed = section.whole("speed", 1, 9);
    fpga.top = section.text("top");
    return fpga;
}

/// The ranges are those that the Verilog takes.
std::map<std::string, std::uint32_t, std::less<>> read_parameters(const Section& section) {
    section.only({"CHANNELS", "RECORDS", "SEQUENCE_DEPTH", "LIVE_DEPTH", "TIMING_BITS", "PULSE_BITS", "CLOCK_HZ",
                  "BAUD", "WATCHDOG_MS", "MAX_HIGH_CLOCKS"});
    std::map<std::string, std::uint32_t, std::less<>> values;
    const auto read = [&](const char* key, std::uint32_t low, std::uint32_t high) {
        return values[key] = section.whole(key, low, high);
    };
    read("CHANNELS", 2, 1000);
    read("RECORDS", 1, 65535);
    read("SEQUENCE_DEPTH", 2, 32768);
    const std::uint32_t live = read("LIVE_DEPTH", 4, 32768);
    if ((live & (live - 1)) != 0) section.fail(section.need("LIVE_DEPTH", ""), "LIVE_DEPTH", "a power of two");
    const std::uint32_t timing_bits = read("TIMING_BITS", 4, 16);
    read("PULSE_BITS", 1, std::min(timing_bits, 8U));
    const std::uint32_t clock = read("CLOCK_HZ", 1'000'000, 1'000'000'000);
    read("BAUD", std::max(clock / 20'000, 1U), clock / 8);
    read("WATCHDOG_MS", 0, 65535);
    read("MAX_HIGH_CLOCKS", 8, (1U << 24) - 1U);
    return values;
}

Board::Flash read_flash(const Section& section) {
    section.only({"load", "write", "note"});
    return {section.texts("load", is_line), section.texts("write", is_line), section.text("note")};
}

Board::Pins read_pins(const Section& section) {
    section.only({"clk", "rx", "tx", "led", "high"});
    Board::Pins pins;
    pins.clk = section.ball("clk");
    pins.rx = section.ball("rx");
    pins.tx = section.ball("tx");
    if (section.has("led")) pins.led = section.ball("led");
    pins.high = section.texts("high", is_word);
    return pins;
}

/// Outputs, and that no ball has two uses; the LED and what is held may take spare outputs.
std::vector<Board::Output> read_outputs(const Section& root, const std::string& file, std::uint32_t channels,
                                        const Board::Pins& pins) {
    constexpr const char* expected = "a list of [connector, pin, net, ball]";
    constexpr const char* row_expected =
        "[connector, pin, net, ball], four texts in quotes without spaces, commas or quotes";
    const toml::node& node = root.need("outputs", expected);
    const toml::array* rows = node.as_array();
    if (rows == nullptr) root.fail(node, "outputs", expected);
    std::map<std::string, std::string> used;  // ball → by what
    const auto use = [&](const std::string& at, const std::string& ball, const std::string& what) {
        const auto [entry, fresh] = used.emplace(ball, what);
        if (!fresh)
            throw bad_input(at, fmt::format("ball {} is {} and {}; give each its own ball", ball, entry->second, what));
    };
    std::vector<Board::Output> outputs;
    for (const toml::node& row : *rows) {
        const std::string key = fmt::format("outputs[{}]", outputs.size());
        const toml::array* list = row.as_array();
        if (list == nullptr || list->size() != 4) root.fail(row, key, row_expected);
        std::vector<std::string> words;
        for (const toml::node& entry : *list) {
            auto value = entry.value<std::string>();
            if (!value || !is_word(*value)) root.fail(entry, key, row_expected);
            words.push_back(*std::move(value));
        }
        use(place(file, row), words[3], fmt::format("{} pin {}", words[0], words[1]));
        outputs.push_back({words[0], words[1], words[2], words[3]});
    }
    if (outputs.size() < channels)
        throw bad_input(place(file, node), fmt::format("outputs holds {} but parameters.CHANNELS is {}; name more "
                                                       "outputs, or build fewer channels",
                                                       outputs.size(), channels));
    for (std::size_t k = channels; k < outputs.size(); ++k) used.erase(outputs[k].ball);
    use(file, pins.clk, "pins.clk");
    use(file, pins.rx, "pins.rx");
    use(file, pins.tx, "pins.tx");
    if (pins.led) use(file, *pins.led, "pins.led");
    for (const std::string& ball : pins.high) use(file, ball, "in pins.high");
    return outputs;
}

bool is_path(const std::string& name) { return name.find('/') != std::string::npos || name.ends_with(".toml"); }

Board read_board(const std::filesystem::path& path) {
    Board board;
    board.file = path.string();
    board.name = path.stem().string();
    const std::string text = read_file(path);
    toml::table table;
    try {
        table = toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw bad_input(fmt::format("{}:{}", board.file, error.source().begin.line),
                        fmt::format("not valid TOML: {}", error.description()));
    }
    const Section root(board.file, table);
    root.only({"description", "sources", "array", "outputs", "fpga", "parameters", "flash", "pins"});
    board.description = root.text("description");
    board.sources = root.texts("sources", is_line);
    board.array = root.text("array");
    if (is_path(board.array)) board.array = (path.parent_path() / board.array).string();
    board.fpga = read_fpga(root.section("fpga"));
    board.parameters = read_parameters(root.section("parameters"));
    board.flash = read_flash(root.section("flash"));
    board.pins = read_pins(root.section("pins"));
    board.outputs = read_outputs(root, board.file, board.parameter("CHANNELS"), board.pins);
    return board;
}

/// Beside the installed program, else in the source tree.
std::filesystem::path boards_folder() {
    std::error_code error;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    for (const auto& folder : {program / HAPTOGRAM_INSTALLED_BOARDS, std::filesystem::path(HAPTOGRAM_SOURCE_BOARDS)})
        if (std::filesystem::is_directory(folder, error)) return folder;
    throw bad_input(HAPTOGRAM_INSTALLED_BOARDS,
                    "the folder of the shipped boards is missing beside the program; install it again, or give the "
                    "path of a .toml file");
}

}  // namespace

std::uint32_t Board::parameter(std::string_view key) const { return parameters.at(std::string(key)); }

BoardSpec Board::spec() const {
    return {.name = name,
            .clock_hz = static_cast<double>(parameter("CLOCK_HZ")),
            .baud = parameter("BAUD"),
            .channels = parameter("CHANNELS"),
            .records = parameter("RECORDS"),
            .sequence_depth = parameter("SEQUENCE_DEPTH"),
            .timing_bits = parameter("TIMING_BITS"),
            .pulse_bits = parameter("PULSE_BITS")};
}

Board load_board(const std::string& name) {
    if (is_path(name)) return read_board(name);
    const std::vector<std::string> shipped = shipped_boards();
    if (std::find(shipped.begin(), shipped.end(), name) == shipped.end())
        throw bad_input(name, fmt::format("no shipped board has this name (shipped are {}); give the path of a .toml "
                                          "file",
                                          fmt::join(shipped, ", ")));
    return read_board(boards_folder() / (name + ".toml"));
}

std::vector<std::string> shipped_boards() {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(boards_folder()))
        if (entry.path().extension() == ".toml") names.insert(entry.path().stem().string());
    return {names.begin(), names.end()};
}

}  // namespace haptogram
