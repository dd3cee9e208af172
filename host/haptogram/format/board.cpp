// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/format/core_section.hpp"

namespace haptogram {
namespace {

using section::found;
using section::place;
using section::Section;

bool is_line(const std::string& text) {
    return !text.empty() &&
           std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

/// Whether a text can stand in a cell of a table, in CSV and in a pin file.
bool is_word(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(),
                                        [](unsigned char c) { return c > 0x20 && c < 0x7f && c != ',' && c != '"'; });
}

constexpr std::string_view a_line = "a line of text in quotes";
constexpr std::string_view a_ball = "a ball in quotes, such as \"C4\"";
constexpr std::string_view a_list = "a list of texts in quotes";

std::string line(const Section& section, std::string_view key) {
    return section.required(section.text(key, a_line, is_line), key, a_line);
}

std::string ball(const Section& section, std::string_view key) {
    return section.required(section.text(key, a_ball, is_word), key, a_ball);
}

/// @param fits  checks each text: is_word for balls, is_line for all else
std::vector<std::string> list(const Section& section, std::string_view key, bool (*fits)(const std::string&)) {
    return section.required(section.texts(key, fits), key, a_list);
}

Section table(const std::string& file, const toml::table& root, const std::string& name) {
    if (root.get(name) == nullptr) throw bad_input(file, fmt::format("{} is missing; it must be a table", name));
    if (!root.get(name)->is_table())
        throw bad_input(place(file, *root.get(name)),
                        fmt::format("{} must be a table, found {}", name, found(*root.get(name))));
    return {file, root, name};
}

Board::Fpga read_fpga(const Section& section) {
    section.only({"family", "device", "package", "speed", "top"});
    Board::Fpga fpga;
    fpga.family = line(section, "family");
    if (fpga.family != "ecp5" && fpga.family != "ice40")
        throw section.wrong(*section.find("family"), "family", "\"ecp5\" or \"ice40\"");
    fpga.device = line(section, "device");
    fpga.package = line(section, "package");
    fpga.speed = section.whole("speed", 1, 9);
    if (fpga.family == "ecp5" && !fpga.speed) throw section.missing("speed", "a whole number from 1 to 9");
    fpga.top = line(section, "top");
    return fpga;
}

/// What the RTL wants of a core whose records lie in an SDRAM.
void require_room(const Section& section, const interface::CoreParameters& parameters) {
    if (parameters.channels % 2 != 0 || parameters.clock_hz > 60'000'000)
        throw bad_input(section.at("SDRAM"),
                        fmt::format("parameters.SDRAM is beside CHANNELS {} and CLOCK_HZ {}, expected an even number "
                                    "and at most 60000000, or no SDRAM",
                                    parameters.channels, parameters.clock_hz));
    const std::uint32_t most = (parameters.sdram << 19) / (parameters.channels + interface::record_header_words);
    if (parameters.records > most)
        throw bad_input(section.at("RECORDS"),
                        fmt::format("parameters.RECORDS is {}, expected at most {}: {} MiB hold no more records of {} "
                                    "channels",
                                    parameters.records, most, parameters.sdram, parameters.channels));
}

/// The parameters that the file says, and for the rest those of the configuration that it names, or the defaults.
interface::CoreParameters read_core(const Section& section) {
    std::vector<std::string> known = {"configuration"};
    for (const auto& one : interface::core_parameters) known.emplace_back(one.name);
    section.only(known);
    interface::CoreParameters parameters {};
    if (const auto configuration = section.text("configuration")) {
        try {
            parameters = find_configuration(*configuration).parameters;
        } catch (const Error& error) {
            throw bad_input(section.at("configuration"), error.what());
        }
    }
    read_parameters(parameters, section, KeyStyle::verilog);
    if (parameters.sdram != 0) require_room(section, parameters);
    return parameters;
}

/// What a build may use is for tools/bitstream.py.
void check_budget(const Section& section) {
    section.only({"cells", "clock_margin", "network_mhz"});
    std::ignore = section.whole("cells", 1, 1'000'000);
    std::ignore = section.number("clock_margin", 1.0, 10.0);
    std::ignore = section.number("network_mhz", 125.0, 1000.0);
}

Board::Flash read_flash(const Section& section) {
    section.only({"load", "write", "note", "load_jumpers", "write_jumpers"});
    return {list(section, "load", is_line), list(section, "write", is_line), line(section, "note"),
            section.text("load_jumpers", a_line, is_line), section.text("write_jumpers", a_line, is_line)};
}

Board::Wiring read_wiring(const Section& section) {
    section.only({"ground", "power", "serial", "before_configuration", "places"});
    Board::Wiring wiring;
    wiring.ground = line(section, "ground");
    wiring.power = line(section, "power");
    wiring.serial = line(section, "serial");
    const std::string before = line(section, "before_configuration");
    if (before != "inputs" && before != "driven")
        throw section.wrong(*section.find("before_configuration"), "before_configuration", "\"inputs\" or \"driven\"");
    wiring.driven = before == "driven";
    if (const toml::node* node = section.find("places")) {
        constexpr std::string_view expected = "a table of balls, each with its place in quotes, such as \"J1 pin 36\"";
        const toml::table* places = node->as_table();
        if (places == nullptr) throw section.wrong(*node, "places", expected);
        for (const auto& [ball, place] : *places) {
            const auto text = place.value<std::string>();
            if (!text || !is_line(*text)) throw section.wrong(place, "places", expected);
            wiring.places.emplace(ball.str(), *text);
        }
    }
    return wiring;
}

Board::Pins read_pins(const Section& section, const Board::Fpga& fpga, const interface::CoreParameters& parameters) {
    section.only({"clk",
                  "rx",
                  "tx",
                  "led",
                  "stop",
                  "stop_level",
                  "driver_enable",
                  "driver_enable_level",
                  "alive",
                  "sync_in",
                  "sync_out",
                  "trigger_in",
                  "trigger_out",
                  "test",
                  "next_rx",
                  "next_tx",
                  "active",
                  "drive_ma",
                  "slew",
                  "high"});
    Board::Pins pins;
    pins.clk = ball(section, "clk");
    pins.rx = section.text("rx", a_ball, is_word);
    pins.tx = section.text("tx", a_ball, is_word);
    for (const char* key : {"rx", "tx"}) {
        if (parameters.net == 0 && section.find(key) == nullptr) throw section.missing(key, a_ball);
        if (parameters.net != 0 && section.find(key) != nullptr)
            throw section.wrong(*section.find(key), key, "no such key: with parameters.NET there is no serial line");
    }
    pins.led = section.text("led", a_ball, is_word);
    pins.stop = section.text("stop", a_ball, is_word);
    pins.stop_level = section.whole("stop_level", 0, 1).value_or(0);
    pins.driver_enable = section.text("driver_enable", a_ball, is_word);
    pins.driver_enable_level = section.whole("driver_enable_level", 0, 1).value_or(1);
    pins.alive = section.text("alive", a_ball, is_word);
    pins.sync_in = section.text("sync_in", a_ball, is_word);
    pins.sync_out = section.text("sync_out", a_ball, is_word);
    for (const char* key : {"sync_in", "sync_out"})
        if (section.find(key) != nullptr && parameters.sync == 0)
            throw section.wrong(*section.find(key), key, "no such key, or parameters.SYNC = 1: this core has no SYNC");
    pins.trigger_in = section.text("trigger_in", a_ball, is_word);
    pins.trigger_out = section.text("trigger_out", a_ball, is_word);
    pins.test = section.text("test", a_ball, is_word);
    for (const char* key : {"trigger_in", "trigger_out", "test"})
        if (section.find(key) != nullptr && parameters.trigger == 0)
            throw section.wrong(*section.find(key), key,
                                "no such key, or parameters.TRIGGER = 1: this core has no triggers");
    pins.next_rx = section.text("next_rx", a_ball, is_word);
    pins.next_tx = section.text("next_tx", a_ball, is_word);
    for (const char* key : {"next_rx", "next_tx"})
        if (section.find(key) != nullptr && parameters.chain == 0)
            throw section.wrong(*section.find(key), key,
                                "no such key, or parameters.CHAIN = 1: this core passes no line on");
    if (pins.next_rx.has_value() != pins.next_tx.has_value())
        throw bad_input(section.at(pins.next_rx ? "next_rx" : "next_tx"),
                        "found one of next_rx and next_tx, expected both or none");
    if (const auto active = section.text("active")) {
        if (*active != "high" && *active != "low")
            throw section.wrong(*section.find("active"), "active", "\"high\" or \"low\"");
        pins.active_low = *active == "low";
    }
    pins.drive_ma = section.whole("drive_ma", 4, 16);
    if (pins.drive_ma && *pins.drive_ma % 4 != 0)
        throw section.wrong(*section.find("drive_ma"), "drive_ma", "4, 8, 12 or 16");
    pins.slew = section.text("slew");
    if (pins.slew && *pins.slew != "slow" && *pins.slew != "fast")
        throw section.wrong(*section.find("slew"), "slew", "\"slow\" or \"fast\"");
    for (const char* key : {"drive_ma", "slew"})
        if (section.find(key) != nullptr && fpga.family != "ecp5")
            throw section.wrong(*section.find(key), key, "no such key: the outputs of this FPGA have no choice of it");
    pins.high = list(section, "high", is_word);
    return pins;
}

/// Whether a text is `count` numbers with `mark` between them, of these digits and this base, none above 255.
bool is_address(const std::string& text, std::size_t count, char mark, int base) {
    std::size_t numbers = 0;
    const char *at = text.data(), *const end = at + text.size();
    while (at <= end) {
        unsigned value = 256;
        const auto [next, error] = std::from_chars(at, end, value, base);
        if (error != std::errc() || value > 255 || (base == 16 && next != at + 2)) return false;
        ++numbers;
        if (next == end) return numbers == count;
        if (*next != mark) return false;
        at = next + 1;
    }
    return false;
}

Board::Network read_network(const Section& section) {
    section.only({"mac", "ip", "rx_delay", "tx_delay", "rx_clk", "rx_ctl", "rx", "tx_clk", "tx_ctl", "tx"});
    constexpr std::string_view a_mac = "an address of one board, such as \"02:48:47:00:00:01\"";
    constexpr std::string_view an_ip = "an address of IPv4, such as \"169.254.71.1\"";
    Board::Network network;
    // The lowest bit of the first number is of groups.
    const auto is_mac = [](const std::string& text) {
        return is_address(text, 6, ':', 16) && std::string_view("02468aceACE").find(text[1]) != std::string_view::npos;
    };
    network.mac = section.required(section.text("mac", a_mac, is_mac), "mac", a_mac);
    const auto is_ip = [](const std::string& text) { return is_address(text, 4, '.', 10); };
    network.ip = section.required(section.text("ip", an_ip, is_ip), "ip", an_ip);
    constexpr std::string_view a_delay = "a whole number from 0 to 127, in steps of 25 ps";
    network.rx_delay = section.required(section.whole("rx_delay", 0, 127), "rx_delay", a_delay);
    network.tx_delay = section.required(section.whole("tx_delay", 0, 127), "tx_delay", a_delay);
    network.rx_clk = ball(section, "rx_clk");
    network.rx_ctl = ball(section, "rx_ctl");
    network.tx_clk = ball(section, "tx_clk");
    network.tx_ctl = ball(section, "tx_ctl");
    network.rx = list(section, "rx", is_word);
    network.tx = list(section, "tx", is_word);
    for (const auto* key : {"rx", "tx"})
        if (section.texts(key, is_word)->size() != 4)
            throw section.wrong(*section.find(key), key, "a list of four balls, that of bit 0 first");
    return network;
}

Board::Sdram read_sdram(const Section& section, std::uint32_t mib) {
    section.only({"clk", "ras_n", "cas_n", "we_n", "bank", "address", "data", "flash"});
    Board::Sdram sdram{ball(section, "clk"),           ball(section, "ras_n"),
                       ball(section, "cas_n"),         ball(section, "we_n"),
                       list(section, "bank", is_word), list(section, "address", is_word),
                       list(section, "data", is_word), list(section, "flash", is_word)};
    const auto require = [&section](const std::string& key, std::size_t found, std::size_t count) {
        if (found != count)
            throw section.wrong(*section.find(key), key, fmt::format("a list of {} balls, that of bit 0 first", count));
    };
    require("bank", sdram.bank.size(), mib == 8 ? 2 : 1);
    require("address", sdram.address.size(), 11);
    require("data", sdram.data.size(), 32);
    if (sdram.flash.size() != 3)
        throw section.wrong(*section.find("flash"), "flash", "three balls: chip select, to, and from the flash");
    return sdram;
}

/// Reads the outputs, and checks that no ball has two uses. The other pins may use the balls of spare outputs.
std::vector<Board::Output> read_outputs(const Section& root, const std::string& file, std::uint32_t channels,
                                        const Board::Pins& pins, const std::optional<Board::Network>& network,
                                        const std::optional<Board::Sdram>& sdram) {
    constexpr const char* expected = "a list of [connector, pin, net, ball]";
    constexpr const char* row_expected =
        "[connector, pin, net, ball], four texts in quotes without spaces, commas or quotes";
    if (root.find("outputs") == nullptr) throw root.missing("outputs", expected);
    const toml::node& node = *root.find("outputs");
    const toml::array* rows = node.as_array();
    if (rows == nullptr) throw root.wrong(node, "outputs", expected);
    std::map<std::string, std::string> used;  // ball → what uses it
    const auto use = [&](const std::string& at, const std::string& ball, const std::string& what) {
        const auto [entry, fresh] = used.emplace(ball, what);
        if (!fresh)
            throw bad_input(at, fmt::format("ball {} is {} and {}; give each its own ball", ball, entry->second, what));
    };
    std::vector<Board::Output> outputs;
    for (const toml::node& row : *rows) {
        const std::string key = fmt::format("outputs[{}]", outputs.size());
        const toml::array* cells = row.as_array();
        if (cells == nullptr || cells->size() != 4) throw root.wrong(row, key, row_expected);
        std::vector<std::string> words;
        for (const toml::node& entry : *cells) {
            auto value = entry.value<std::string>();
            if (!value || !is_word(*value)) throw root.wrong(entry, key, row_expected);
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
    if (pins.rx) use(file, *pins.rx, "pins.rx");
    if (pins.tx) use(file, *pins.tx, "pins.tx");
    if (network) {
        for (const auto* one : {&network->rx_clk, &network->rx_ctl, &network->tx_clk, &network->tx_ctl})
            use(file, *one, "in network");
        for (const auto* several : {&network->rx, &network->tx})
            for (const std::string& ball : *several) use(file, ball, "in network");
    }
    if (sdram) {
        for (const auto* one : {&sdram->clk, &sdram->ras_n, &sdram->cas_n, &sdram->we_n}) use(file, *one, "in sdram");
        for (const auto* several : {&sdram->bank, &sdram->address, &sdram->data, &sdram->flash})
            for (const std::string& ball : *several) use(file, ball, "in sdram");
    }
    if (pins.led) use(file, *pins.led, "pins.led");
    if (pins.stop) use(file, *pins.stop, "pins.stop");
    if (pins.driver_enable) use(file, *pins.driver_enable, "pins.driver_enable");
    if (pins.alive) use(file, *pins.alive, "pins.alive");
    if (pins.sync_in) use(file, *pins.sync_in, "pins.sync_in");
    if (pins.sync_out) use(file, *pins.sync_out, "pins.sync_out");
    if (pins.trigger_in) use(file, *pins.trigger_in, "pins.trigger_in");
    if (pins.trigger_out) use(file, *pins.trigger_out, "pins.trigger_out");
    if (pins.test) use(file, *pins.test, "pins.test");
    if (pins.next_rx) use(file, *pins.next_rx, "pins.next_rx");
    if (pins.next_tx) use(file, *pins.next_tx, "pins.next_tx");
    for (const std::string& ball : pins.high) use(file, ball, "in pins.high");
    return outputs;
}

bool is_path(const std::string& name) { return name.find('/') != std::string::npos || name.ends_with(".toml"); }

/// A board's file as it was read.
struct BoardFile {
    std::filesystem::path path;
    toml::table tables;
};

BoardFile read_file_of(const std::filesystem::path& path) {
    BoardFile file{path, section::parse(path)};
    Section(path.string(), file.tables)
        .only({"description", "like", "sources", "array", "outputs", "fpga", "parameters", "budget", "flash", "pins",
               "network", "sdram", "wiring"});
    return file;
}

/// The board that this one is like, if it says so: another one's name or file.
std::optional<BoardFile> read_like(const BoardFile& own) {
    const Section root(own.path.string(), own.tables);
    const auto like = root.text("like", a_line, is_line);
    if (!like) return {};
    try {
        return read_file_of(is_path(*like) ? named_in(own.path.parent_path(), *like)
                                           : std::filesystem::path{path_or_shipped(*like, "boards", ".toml", "board")});
    } catch (const Error& error) {
        throw bad_input(root.at("like"), error.what());
    }
}

/// The files that make up a board: its own, then the one that it is like, then the one that this is like.
std::vector<BoardFile> read_chain(const std::filesystem::path& path) {
    constexpr std::size_t most = 4;
    std::vector<BoardFile> chain;
    chain.reserve(most);  // because a copy does not know its lines
    chain.push_back(read_file_of(path));
    std::string names = path.stem().string();
    while (auto like = read_like(chain.back())) {
        const std::string at = Section(chain.back().path.string(), chain.back().tables).at("like");
        names += ", like " + like->path.stem().string();
        const auto is_it = [&](const BoardFile& file) {
            return file.path.lexically_normal() == like->path.lexically_normal();
        };
        if (std::any_of(chain.begin(), chain.end(), is_it))
            throw bad_input(at, fmt::format("found a board that is like itself ({}), expected another one", names));
        if (chain.size() == most)
            throw bad_input(
                at, fmt::format("found more than {} boards, each like the next ({}); name one that is like fewer", most,
                                names));
        chain.push_back(*std::move(like));
    }
    return chain;
}

Board read_board(const std::filesystem::path& path) {
    const std::vector<BoardFile> chain = read_chain(path);
    // The first that says it; where none does, the board's own, so that a message names that.
    const auto holder = [&](std::string_view key) -> const BoardFile& {
        const auto says = [key](const BoardFile& file) { return file.tables.get(key) != nullptr; };
        const auto found = std::find_if(chain.begin(), chain.end(), says);
        return found == chain.end() ? chain.front() : *found;
    };
    const auto root = [&](std::string_view key) { return Section(holder(key).path.string(), holder(key).tables); };
    const auto table_of = [&](const std::string& name) {
        return table(holder(name).path.string(), holder(name).tables, name);
    };
    Board board;
    board.file = path.string();
    board.name = path.stem().string();
    board.description = line(root("description"), "description");
    board.sources = list(root("sources"), "sources", is_line);
    board.array = line(root("array"), "array");
    if (is_path(board.array)) board.array = named_in(holder("array").path.parent_path(), board.array).string();
    board.fpga = read_fpga(table_of("fpga"));
    board.parameters = read_core(table_of("parameters"));
    if (holder("budget").tables.get("budget") != nullptr) check_budget(table_of("budget"));
    board.flash = read_flash(table_of("flash"));
    board.pins = read_pins(table_of("pins"), board.fpga, board.parameters);
    const bool has_network = holder("network").tables.get("network") != nullptr;
    if (has_network && board.parameters.net == 0)
        throw bad_input(root("network").at("network"), "found a network, expected none, or parameters.NET = 1");
    if (board.parameters.net != 0) board.network = read_network(table_of("network"));
    const bool has_sdram = holder("sdram").tables.get("sdram") != nullptr;
    if (has_sdram && board.parameters.sdram == 0)
        throw bad_input(root("sdram").at("sdram"), "found an SDRAM, expected none, or parameters.SDRAM = 4 or 8");
    if (board.parameters.sdram != 0) board.sdram = read_sdram(table_of("sdram"), board.parameters.sdram);
    if (holder("wiring").tables.get("wiring") != nullptr) board.wiring = read_wiring(table_of("wiring"));
    board.outputs = read_outputs(root("outputs"), holder("outputs").path.string(), board.parameters.channels,
                                 board.pins, board.network, board.sdram);
    if (board.wiring) {
        for (const Board::Output& output : board.outputs)
            if (board.wiring->places.contains(output.ball))
                throw bad_input(table_of("wiring").at("places"),
                                fmt::format("wiring.places has ball {}, an output, which has its place under outputs",
                                            output.ball));
    }
    return board;
}

}  // namespace

std::string Board::place_of(const std::string& ball) const {
    if (wiring)
        if (const auto found = wiring->places.find(ball); found != wiring->places.end()) return found->second;
    const auto found =
        std::find_if(outputs.begin(), outputs.end(), [&](const Output& one) { return one.ball == ball; });
    return found == outputs.end() ? "" : fmt::format("{} pin {}", found->connector, found->pin);
}

Board load_board(const std::string& name) { return read_board(path_or_shipped(name, "boards", ".toml", "board")); }

std::string bitstream_file(const Board& board) { return board.name + (board.fpga.family == "ice40" ? ".bin" : ".bit"); }

std::vector<std::string> shipped_boards() { return shipped_names("boards", ".toml"); }

}  // namespace haptogram
