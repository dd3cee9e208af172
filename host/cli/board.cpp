// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/format/pinout.hpp"
#include "haptogram/verbs/supply.hpp"

namespace haptogram::cli {
namespace {

using nlohmann::ordered_json;
using Row = std::vector<std::string>;

struct PinoutOptions {
    std::string board;
    std::optional<std::string> array;
    std::string output = "-";
    bool json = false;
    bool csv = false;
};

/// Columns as wide as their widest cell, two spaces apart, from `first_right` on aligned to the right.
std::string aligned(const std::vector<Row>& rows, std::size_t first_right) {
    std::vector<std::size_t> widths(rows.front().size());
    for (const Row& row : rows)
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    std::string text;
    for (const Row& row : rows) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i)
            line += i < first_right ? fmt::format("{:<{}}  ", row[i], widths[i])
                                    : fmt::format("{:>{}}  ", row[i], widths[i]);
        text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
}

std::string fpga_name(const Board::Fpga& fpga) {
    return fmt::format("{} {} {}{}", fpga.family, fpga.device, fpga.package,
                       fpga.speed ? fmt::format(", speed grade {}", *fpga.speed) : "");
}

/// Rounded to a ten-thousandth of a millimetre, as in a manifest.
double to_mm(double metres) { return std::round(metres * 1e7) / 1e4 + 0.0; }

template <class T>
ordered_json or_null(const std::optional<T>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json to_json(const Board::Pins& pins) {
    return {{"clk", pins.clk},
            {"rx", or_null(pins.rx)},
            {"tx", or_null(pins.tx)},
            {"led", or_null(pins.led)},
            {"stop", or_null(pins.stop)},
            {"stop_level", pins.stop_level},
            {"driver_enable", or_null(pins.driver_enable)},
            {"driver_enable_level", pins.driver_enable_level},
            {"alive", or_null(pins.alive)},
            {"sync_in", or_null(pins.sync_in)},
            {"sync_out", or_null(pins.sync_out)},
            {"trigger_in", or_null(pins.trigger_in)},
            {"trigger_out", or_null(pins.trigger_out)},
            {"test", or_null(pins.test)},
            {"next_rx", or_null(pins.next_rx)},
            {"next_tx", or_null(pins.next_tx)},
            {"active", pins.active_low ? "low" : "high"},
            {"drive_ma", or_null(pins.drive_ma)},
            {"slew", or_null(pins.slew)},
            {"high", pins.high}};
}

ordered_json to_json(const std::optional<Board::Network>& net) {
    if (!net) return nullptr;
    return {{"mac", net->mac},
            {"ip", net->ip},
            {"rx_delay", net->rx_delay},
            {"tx_delay", net->tx_delay},
            {"rx_clk", net->rx_clk},
            {"rx_ctl", net->rx_ctl},
            {"rx", net->rx},
            {"tx_clk", net->tx_clk},
            {"tx_ctl", net->tx_ctl},
            {"tx", net->tx}};
}

ordered_json to_json(const std::optional<Board::Sdram>& sdram) {
    if (!sdram) return nullptr;
    return {{"clk", sdram->clk},   {"ras_n", sdram->ras_n},     {"cas_n", sdram->cas_n}, {"we_n", sdram->we_n},
            {"bank", sdram->bank}, {"address", sdram->address}, {"data", sdram->data},   {"flash", sdram->flash}};
}

ordered_json to_json(const Board::Flash& flash) {
    ordered_json json = {{"load", flash.load}, {"write", flash.write}, {"note", flash.note}};
    if (flash.load_jumpers) json["load_jumpers"] = *flash.load_jumpers;
    if (flash.write_jumpers) json["write_jumpers"] = *flash.write_jumpers;
    return json;
}

ordered_json to_json(const std::optional<Board::Wiring>& wiring) {
    if (!wiring) return nullptr;
    return {{"ground", wiring->ground},
            {"power", wiring->power},
            {"serial", wiring->serial},
            {"before_configuration", wiring->driven ? "driven" : "inputs"},
            {"places", wiring->places}};
}

/// Where a wire reaches each of the other pins, as far as it is known.
ordered_json places_of(const Board& board) {
    ordered_json json = ordered_json::object();
    const Board::Pins& pins = board.pins;
    const std::pair<const char*, const std::optional<std::string>&> named[] = {{"rx", pins.rx},
                                                                               {"tx", pins.tx},
                                                                               {"led", pins.led},
                                                                               {"stop", pins.stop},
                                                                               {"driver_enable", pins.driver_enable},
                                                                               {"alive", pins.alive},
                                                                               {"sync_in", pins.sync_in},
                                                                               {"sync_out", pins.sync_out},
                                                                               {"trigger_in", pins.trigger_in},
                                                                               {"trigger_out", pins.trigger_out},
                                                                               {"test", pins.test},
                                                                               {"next_rx", pins.next_rx},
                                                                               {"next_tx", pins.next_tx}};
    for (const auto& [name, ball] : named)
        if (ball && !board.place_of(*ball).empty()) json[name] = board.place_of(*ball);
    return json;
}

/// What keeps the drivers off while the FPGA does not.
std::string off_of(const Board& board) {
    const Board::Pins& pins = board.pins;
    if (!board.wiring->driven)
        return fmt::format("4.7 kΩ from each driver's input to {}: pins are inputs until the FPGA is configured",
                           pins.active_low ? "its supply of logic" : "ground");
    if (!pins.driver_enable)
        return "a hand switches the drivers' supply on last and off first: the pins drive before the FPGA is "
               "configured";
    return fmt::format("switch the drivers' supply by {}: the pins drive before the FPGA is configured",
                       board.place_of(*pins.driver_enable).empty() ? "ball " + *pins.driver_enable
                                                                   : board.place_of(*pins.driver_enable));
}

ordered_json to_json(const Pinout& pinout) {
    const Board& board = pinout.board;
    ordered_json json = {{"board", board.name},
                         {"description", board.description},
                         {"sources", board.sources},
                         {"fpga",
                          {{"family", board.fpga.family},
                           {"device", board.fpga.device},
                           {"package", board.fpga.package},
                           {"speed", nullptr},
                           {"top", board.fpga.top}}},
                         {"parameters", ordered_json::object()},
                         {"flash", to_json(board.flash)},
                         {"pins", to_json(board.pins)},
                         {"network", to_json(board.network)},
                         {"sdram", to_json(board.sdram)},
                         {"wiring", to_json(board.wiring)},
                         {"places", places_of(board)},
                         {"off", board.wiring ? ordered_json(off_of(board)) : ordered_json(nullptr)},
                         {"array", pinout.array.name},
                         {"outputs", ordered_json::array()}};
    for (const auto& one : interface::core_parameters) json["parameters"][one.name] = board.parameters.*one.member;
    if (board.fpga.speed) json["fpga"]["speed"] = *board.fpga.speed;
    for (const PinoutRow& row : pinout.rows) {
        const Board::Output& o = row.output;
        ordered_json cells = {{"connector", o.connector}, {"pin", o.pin},   {"net", o.net},     {"ball", o.ball},
                              {"channel", row.channel},   {"row", nullptr}, {"column", nullptr}};
        if (row.row) cells["row"] = *row.row;
        if (row.column) cells["column"] = *row.column;
        cells["x_mm"] = to_mm(row.position.x);
        cells["y_mm"] = to_mm(row.position.y);
        json["outputs"].push_back(cells);
    }
    return json;
}

/// The header and a row a channel; row and column hold `none` for an array that is no grid.
std::vector<Row> rows_of(const Pinout& pinout, const char* none) {
    std::vector<Row> rows = {{"connector", "pin", "net", "ball", "channel", "row", "column", "x_mm", "y_mm"}};
    for (const PinoutRow& row : pinout.rows) {
        const Board::Output& o = row.output;
        rows.push_back({o.connector, o.pin, o.net, o.ball, fmt::to_string(row.channel),
                        row.row ? fmt::to_string(*row.row) : none, row.column ? fmt::to_string(*row.column) : none,
                        fmt::format("{:.2f}", to_mm(row.position.x)), fmt::format("{:.2f}", to_mm(row.position.y))});
    }
    return rows;
}

std::string to_csv(const Pinout& pinout) {
    std::string text;
    for (const Row& row : rows_of(pinout, "")) text += fmt::format("{}\n", fmt::join(row, ","));
    return text;
}

const char* level(std::uint32_t value) { return value == 0 ? "low" : "high"; }

std::string to_text(const Pinout& pinout) {
    const Board& board = pinout.board;
    const Board::Pins& pins = board.pins;
    const auto at = [&board](const std::string& ball) {
        const std::string place = board.place_of(ball);
        return fmt::format("ball {}{}{}", ball, place.empty() ? "" : ", ", place);
    };
    std::string text = fmt::format("board  {}, {}\nFPGA   {}\n", board.name, board.description, fpga_name(board.fpga));
    text += fmt::format("clock  ball {}; the instrument runs at {} MHz\n", pins.clk, board.parameters.clock_hz / 1e6);
    if (pins.rx)
        text += fmt::format("UART   rx {}, tx {}, {} baud\n", at(*pins.rx), at(*pins.tx), board.parameters.baud);
    if (board.network)
        text += fmt::format("net    {}, MAC {}, UDP port {}; 1 Gbit/s\n", board.network->ip, board.network->mac,
                            interface::network::port);
    if (board.sdram)
        text += fmt::format("SDRAM  {} MiB, for {} records\n", board.parameters.sdram, board.parameters.records);
    if (pins.led) text += fmt::format("LED    {}\n", at(*pins.led));
    if (pins.stop)
        text += fmt::format("stop   {}; outputs are off while it is {}\n", at(*pins.stop), level(pins.stop_level));
    if (pins.driver_enable)
        text += fmt::format("enable {}; {} while outputs are on, for what switches the drivers\n",
                            at(*pins.driver_enable), level(pins.driver_enable_level));
    if (pins.alive) text += fmt::format("alive  {}; changes as long as there is a clock\n", at(*pins.alive));
    if (pins.sync_in)
        text += fmt::format("SYNC   in {}; from the master, when this board is a slave\n", at(*pins.sync_in));
    if (pins.sync_out)
        text += fmt::format("SYNC   out {}; to the slaves, when this board is the master\n", at(*pins.sync_out));
    if (pins.trigger_in) text += fmt::format("trigger in {}\n", at(*pins.trigger_in));
    if (pins.trigger_out) text += fmt::format("trigger out {}\n", at(*pins.trigger_out));
    if (pins.test) text += fmt::format("test   {}; for an oscilloscope\n", at(*pins.test));
    if (pins.next_rx)
        text += fmt::format("chain  rx {}, tx {}; the serial line of the next board\n", at(*pins.next_rx),
                            at(*pins.next_tx));
    if (pins.active_low) text += "active low: a transducer's driver is on while its pin is low\n";
    if (!pins.high.empty()) text += fmt::format("high   ball {}\n", fmt::join(pins.high, ", "));
    if (board.wiring) {
        text += fmt::format("ground {}, by a meter first; join those of board, drivers and supplies\n",
                            board.wiring->ground);
        text += fmt::format("power  {}; the drivers have a supply of their own\n", board.wiring->power);
        if (pins.rx) text += fmt::format("serial {}\n", board.wiring->serial);
        text += fmt::format("off    {}\n", off_of(board));
    }
    text += fmt::format("array  {}, {} elements; x to the right, y up, seen from the side of the hand\n",
                        pinout.array.name, pinout.array.elements.size());
    text += fmt::format("flash  {}\n", board.flash.note);
    if (board.flash.load_jumpers) text += fmt::format("jumpers to load: {}\n", *board.flash.load_jumpers);
    if (board.flash.write_jumpers) text += fmt::format("jumpers to write the flash: {}\n", *board.flash.write_jumpers);
    return text + "\n" + aligned(rows_of(pinout, "-"), 4);
}

int write_pinout(const PinoutOptions& options) {
    std::vector<NamedPath> inputs = {{"the board", options.board}};
    if (options.array) inputs.push_back({"--array", *options.array});
    require_distinct(inputs, {{"--output", options.output}});
    const Pinout found = pinout(options.board, options.array.value_or(""));
    if (options.output.ends_with(".svg")) {
        if (options.json || options.csv)
            throw bad_argument("output", "an .svg is a picture; leave --json and --csv out, or write another file");
        Picture picture("shipped:tools/plot_wiring.py");
        picture.add("pinout.json", to_json(found).dump());
        picture.draw(options.output, "text, --csv and --json");
        return 0;
    }
    write_file(options.output, options.json  ? to_json(found).dump(1) + "\n"
                               : options.csv ? to_csv(found)
                                             : to_text(found));
    return 0;
}

struct PowerOptions {
    std::string board;
    SupplyOptions supply;
    double nanofarads = 2.7;
    double driver_ma = 4.5;
    bool json = false;
};

int print_power(PowerOptions options) {
    options.supply.channels = load_board(options.board).parameters.channels;
    options.supply.capacitance_f = options.nanofarads * 1e-9;
    options.supply.driver_a = options.driver_ma * 1e-3;
    const SupplyOptions& o = options.supply;
    const Supply s = supply_of(o);
    if (options.json)
        fmt::print("{}\n", ordered_json{{"channels", o.channels},
                                        {"volts", o.volts},
                                        {"duty", o.duty},
                                        {"motion_w", s.motion_w},
                                        {"charge_w", s.charge_w},
                                        {"all_w", s.all_w},
                                        {"current_a", s.current_a},
                                        {"drivers_a", s.drivers_a}}
                               .dump());
    else
        fmt::print(
            "{} channels at {:g} V and a duty of {:g}: {:.2f} W, {:.2f} A from the supply\n"
            "a channel: {:.1f} mW move the element, {:.1f} mW charge it, at any duty\n"
            "by formula for a typical element ({:g} ohms, {:g} nF)\n"
            "and at most {:.2f} A that {} dual drivers take for themselves ({:g} mA each while their inputs are "
            "high)\n",
            o.channels, o.volts, o.duty, s.all_w, s.current_a, s.motion_w * 1e3, s.charge_w * 1e3, o.resistance_ohm,
            options.nanofarads, s.drivers_a, (o.channels + 1) / 2, options.driver_ma);
    return 0;
}

int list(bool as_json) {
    std::vector<Row> rows = {{"board", "channels", "MHz", "array", "FPGA", "description"}};
    ordered_json json = ordered_json::array();
    for (const std::string& name : shipped_boards()) {
        const Board board = load_board(name);
        rows.push_back({board.name, fmt::to_string(board.parameters.channels),
                        fmt::format("{}", board.parameters.clock_hz / 1e6), board.array,
                        fmt::format("{} {}", board.fpga.family, board.fpga.device), board.description});
        json.push_back({{"board", board.name},
                        {"description", board.description},
                        {"channels", board.parameters.channels},
                        {"clock_hz", board.parameters.clock_hz},
                        {"array", board.array},
                        {"family", board.fpga.family},
                        {"device", board.fpga.device}});
    }
    fmt::print("{}", as_json ? json.dump(1) + "\n" : aligned(rows, rows.front().size()));
    return 0;
}

}  // namespace

void add_board(CLI::App& app, Action& action) {
    CLI::App* sub = app.add_subcommand("board", "List FPGA boards and their pins, or run one without hardware");
    // Checked after parsing, so that an unknown subcommand is reported first.
    sub->callback([sub, &action] {
        if (sub->get_subcommands().empty())
            action = []() -> int {
                throw Error(ErrorCode::bad_argument, "board",
                            "expected a subcommand: list, run, holder, power or pinout; see haptogram board --help");
            };
    });

    auto as_json = std::make_shared<bool>(false);
    CLI::App* names = sub->add_subcommand("list", "Print the shipped boards");
    names->add_flag("--json", *as_json, "As JSON");
    names->callback([as_json, &action] { action = [as_json] { return list(*as_json); }; });

    add_below("board", *sub, action);
    add_holder(*sub, action);

    auto power = std::make_shared<PowerOptions>();
    CLI::App* supply = sub->add_subcommand("power", "Print what a board's array takes from its supply");
    supply->add_option("board", power->board, "Board file (TOML) or shipped board")->required();
    supply->add_option("--volts", power->supply.volts, "Supply of the drivers, V")->capture_default_str();
    supply->add_option("--duty", power->supply.duty, "Share of a carrier period for which a pin is high")
        ->capture_default_str();
    supply->add_option("--resistance-ohm", power->supply.resistance_ohm, "Resistance of an element at its resonance")
        ->capture_default_str();
    supply->add_option("--capacitance-nf", power->nanofarads, "Capacitance of an element")->capture_default_str();
    supply->add_option("--series-ohm", power->supply.series_ohm, "Resistance of a driver and what is behind it")
        ->capture_default_str();
    supply->add_option("--driver-ma", power->driver_ma, "What a dual driver takes for itself at most; of a TC4427")
        ->capture_default_str();
    supply->add_flag("--json", power->json, "As JSON");
    supply->callback([power, &action] { action = [power] { return print_power(*power); }; });

    auto options = std::make_shared<PinoutOptions>();
    CLI::App* pins = sub->add_subcommand(
        "pinout", "Print the connector, pin and ball of every channel, and where its element is, for making a cable");
    pins->add_option("board", options->board, "Board file (TOML) or shipped board")->required();
    pins->add_option("--array", options->array, "Array file (TOML) or shipped array (default: the board's)");
    auto* json = pins->add_flag("--json", options->json, "As JSON, with all that the board file says");
    pins->add_flag("--csv", options->csv, "As CSV, only the rows")->excludes(json);
    pins->add_option("-o,--output", options->output, "File; - is standard output, .svg a picture of the wiring")
        ->capture_default_str();
    pins->callback([options, &action] { action = [options] { return write_pinout(*options); }; });
}

}  // namespace haptogram::cli
