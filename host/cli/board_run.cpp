// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include "board_run_tiles.hpp"
#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/intel_hex.hpp"
#include "haptogram/verbs/source.hpp"
#include "interrupt.hpp"
#include "network_port.hpp"
#include "playback.hpp"
#include "pseudo_terminal.hpp"
#include "pulse_check.hpp"
#include "reference_board.hpp"
#include "reference_port.hpp"
#include "serve.hpp"
#include "simulated_board.hpp"

namespace haptogram::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct RunOptions {
    std::string image;
    std::string pty;
    bool net = false;
    std::string net_address = "127.0.0.1";
    std::uint16_t net_port = interface::network::port;
    sim::NetworkFaults net_faults;
    std::string speed = "real";
    std::string model = "rtl";
    std::string trace;
    std::string pulses;
    std::string board;
    std::uint32_t channels = 100;
    double seconds = 0.0;
    RunTilesOptions tiles;
    bool json = false;
};

/// The line that says what the board is doing; on a terminal only.
class StatusLine {
public:
    ~StatusLine() {
        if (drawn_) std::fputs("\r\033[K", stderr);
    }

    void show(const sim::Served& now) {
        if (::isatty(STDERR_FILENO) != 1 || Clock::now() - last_ < std::chrono::milliseconds(200)) return;
        last_ = Clock::now();
        drawn_ = true;
        std::fputs(
            fmt::format("\r{:.3f} s simulated, {:.3f} of real time, record {}, outputs {}, {} frames in: {} applied, "
                        "{} repeated, {} refused\033[K",
                        now.simulated_s, now.wall_s > 0.0 ? now.simulated_s / now.wall_s : 0.0, now.index,
                        now.enabled ? "on" : "off", now.link.frames, now.link.applied, now.link.repeated,
                        now.link.refused)
                .c_str(),
            stderr);
        std::fflush(stderr);
    }

private:
    bool drawn_ = false;
    Clock::time_point last_{};
};

/// What a recorder saw, written while the board runs.
class PulseFile {
public:
    PulseFile(const std::string& path, sim::Board& board) : path_(path), staged_(path), recorder_(board) {
        if (!staged_.beside().empty()) beside_.open(staged_.beside(), std::ios::binary);
    }
    /// Writes what has come together, once that is worth it.
    void write() {
        if (recorder_.pulses().size() >= enough) write_all();
    }
    void commit() {
        write_all();
        if (beside_.is_open()) beside_.close();
        require_good();
        staged_.commit();
    }

private:
    static constexpr std::size_t enough = 1U << 16;

    void write_all() {
        std::string text = to_csv(recorder_.take());
        if (begun_) text.erase(0, text.find('\n') + 1);  // the header
        begun_ = true;
        if (!beside_.is_open()) return staged_.fill(text);
        beside_ << text << std::flush;
        require_good();
    }
    void require_good() const {
        if (beside_.fail())
            throw bad_input(path_, fmt::format("cannot be written: {}", std::generic_category().message(errno)));
    }

    std::string path_;
    StagedFile staged_;
    std::ofstream beside_;  // closed for standard output, devices and pipes
    sim::PulseRecorder recorder_;
    bool begun_ = false;
};

std::optional<Image> read_image(const std::string& path) {
    if (path.empty()) return {};
    Image image = from_intel_hex(open_hex(path, path_makers()), path);
    require_playable(image, path);
    return image;
}

/// One line, so that a program can read it while the board runs.
int run_tiles(const RunOptions& options) {
    RunTilesOptions tiles = options.tiles;
    tiles.reference = options.model == "reference";
    tiles.channels = options.channels;
    tiles.pty = options.pty;
    tiles.real_time = options.speed == "real";
    tiles.seconds = options.seconds;
    tiles.json = options.json;
    return run_boards(tiles);
}

int run_board(const RunOptions& options) {
    if (options.tiles.count != 0) return run_tiles(options);
    std::vector<NamedPath> outputs;
    if (!options.pulses.empty()) outputs.push_back({"--pulses", options.pulses});
    if (!options.trace.empty()) outputs.push_back({"--trace", options.trace});
    require_distinct({{"--image", options.image}}, outputs);
    const std::optional<Image> image = read_image(options.image);
    const bool is_rtl = options.model == "rtl";
    if (!is_rtl && !options.trace.empty())
        throw bad_argument("trace", "the reference board has no signals; give --model rtl, or leave out the trace");
    const std::span<const interface::CoreConfiguration> all =
        is_rtl ? std::span<const interface::CoreConfiguration>(sim::available_models())
               : interface::core_configurations;
    const std::vector<interface::CoreConfiguration> models = sim::models_of(options.net, all);
    const std::optional<Core> asked = options.board.empty() ? std::nullopt : std::optional(find_core(options.board));
    if (asked && (asked->parameters.net != 0) != options.net)
        throw bad_argument("board",
                           fmt::format("{} is reached {}", asked->name,
                                       options.net ? "by a serial line; leave out --net, or name a board with a "
                                                     "network port, such as colorlight-5a-75e-v7.1-net"
                                                   : "over Ethernet; give --net as well"));
    const auto model = [&] {
        if (asked) return sim::model_like(*asked, models);
        return image ? sim::model_for(*image, options.image, models)
                     : sim::model_with_channels(options.channels, models);
    };
    std::unique_ptr<sim::SimulatedBoard> core;
    std::unique_ptr<sim::ReferenceBoard> reference;
    if (is_rtl)
        core = std::make_unique<sim::SimulatedBoard>(model());
    else if (asked)
        reference = std::make_unique<sim::ReferenceBoard>(interface::CoreConfiguration{asked->name, asked->parameters});
    else
        reference = std::make_unique<sim::ReferenceBoard>(model());
    sim::Board& board = is_rtl ? static_cast<sim::Board&>(*core) : *reference;
    std::optional<StagedFile> trace;
    std::optional<PulseFile> pulses;
    if (!options.trace.empty()) {
        trace.emplace(options.trace);
        if (trace->beside().empty())
            throw bad_input(options.trace, "a trace needs a file of its own; name one that is no device or pipe");
        core->trace(trace->beside());
    }
    if (!options.pulses.empty()) pulses.emplace(options.pulses, board);
    if (image) sim::load_directly(board, *image);
    catch_interrupts();
    const interface::CoreParameters& p = board.parameters();
    const std::uint32_t baud =
        asked ? asked->parameters.baud : p.baud;  // a core that stands for a board may have another
    std::unique_ptr<sim::HostLine> host;
    if (options.net)
        host = std::make_unique<sim::NetworkPort>(board, options.net_address, options.net_port, options.net_faults);
    else
        host = std::make_unique<sim::PseudoTerminal>(baud, options.pty);
    tell_line({{"port", host->name()},
               {"model", options.model},
               {"configuration", board.name()},
               {"channels", p.channels},
               {"records", p.records},
               {"clock_hz", p.clock_hz},
               {"baud", baud}},
              options.json, host->name());
    sim::Served served;
    {
        StatusLine line;
        served = sim::serve(board, *host, {options.speed == "real", options.seconds}, [&](const sim::Served& now) {
            line.show(now);
            if (pulses) pulses->write();
            return !interrupted();
        });
    }

    if (pulses) pulses->commit();
    const double playing_mclk_per_s =
        served.playing_s > 0.0 ? 1e-6 * static_cast<double>(served.playing_clocks) / served.playing_s : 0.0;
    const double times_real_time = 1e6 * playing_mclk_per_s / p.clock_hz;
    tell_line({{"simulated_s", served.simulated_s},
               {"wall_s", served.wall_s},
               {"bytes_in", served.link.bytes_in},
               {"bytes_out", served.link.bytes_out},
               {"frames_in", served.link.frames},
               {"frames_applied", served.link.applied},
               {"frames_repeated", served.link.repeated},
               {"frames_refused", served.link.refused},
               {"playing_mclk_per_s", playing_mclk_per_s},
               {"playing_times_real_time", times_real_time},
               {"enabled", served.enabled}},
              options.json,
              fmt::format(
                  "{:.3f} s simulated in {:.1f} s, {} frames in, {} applied, {:.2f} Mclk/s while playing, {:.2f} times "
                  "real time",
                  served.simulated_s, served.wall_s, served.link.frames, served.link.applied, playing_mclk_per_s,
                  times_real_time));
    if (trace) {
        core->end_trace();
        trace->commit();
    }
    return 0;
}

}  // namespace

void add_board_run(CLI::App& board, Action& action) {
    auto options = std::make_shared<RunOptions>();
    CLI::App* sub = board.add_subcommand("run",
                                         "Run a board without hardware behind a pseudo-terminal, which any program can "
                                         "open as its serial port, or behind UDP; prints the port");
    auto* image = sub->add_option("--image", options->image,
                                  "Intel HEX image, or a project (.toml), that is in its memories from the start");
    auto* channels = sub->add_option("--channels", options->channels, "Channels of the board, without an image")
                         ->excludes(image)
                         ->capture_default_str();
    auto* like =
        sub->add_option(
               "--board", options->board,
               "Board to simulate, without an image: shipped board, board file (TOML) or configuration of the core "
               "such as tile-100-wide. With --model rtl, the first Verilated core that has what it has")
            ->excludes(image)
            ->excludes(channels);
    sub->add_option("--model", options->model,
                    "The Verilated FPGA, or the reference board, which does the same in real time")
        ->check(CLI::IsMember({"rtl", "reference"}))
        ->capture_default_str();
    auto* pty = sub->add_option("--pty", options->pty, "A name for the port: a link to it, removed at the end");
    auto* net =
        sub->add_flag("--net", options->net,
                      "Behind UDP, as a board on a network, and not behind a pseudo-terminal; --board names one "
                      "with a network port")
            ->excludes(pty);
    sub->add_option("--net-address", options->net_address, "Own address of this machine")
        ->needs(net)
        ->capture_default_str();
    sub->add_option("--net-port", options->net_port, "UDP port; the next one is the open port; 0: two that are free")
        ->needs(net)
        ->check(CLI::Range(0, 65534))
        ->capture_default_str();
    sub->add_option("--loss", options->net_faults.loss, "Share of the datagrams that are lost, each way")
        ->needs(net)
        ->check(CLI::Range(0.0, 1.0));
    sub->add_option("--duplicates", options->net_faults.duplicates, "Share of the datagrams that come twice")
        ->needs(net)
        ->check(CLI::Range(0.0, 1.0));
    sub->add_option("--jitter-ms", options->net_faults.jitter_ms,
                    "Datagrams come up to this much late, so also in another order")
        ->needs(net)
        ->check(CLI::Range(0.0, 1000.0));
    sub->add_option("--speed", options->speed, "No faster than a real board, or as fast as this machine can")
        ->check(CLI::IsMember({"real", "max"}))
        ->capture_default_str();
    sub->add_option("--seconds", options->seconds, "End after so much simulated time (default: Ctrl-C)")
        ->check(positive());
    auto* trace =
        sub->add_option("--trace", options->trace, "Write every signal (FST, for GTKWave; the Verilated FPGA only)");
    auto* pulses = sub->add_option("--pulses", options->pulses, "Write the pulses measured at the pins (CSV)");
    auto* tiles = sub->add_option("--tiles", options->tiles.count,
                                  "So many boards on one wire SYNC, each behind a pseudo-terminal of its own, for a "
                                  "rig; --pty NAME names them NAME-1, NAME-2 and so on")
                      ->excludes(image)
                      ->excludes(like)
                      ->excludes(trace)
                      ->excludes(pulses)
                      ->excludes(net)
                      ->check(whole(1, 64));
    sub->add_flag("--chain", options->tiles.chain,
                  "One pseudo-terminal for all of them: each passes the serial line on to the next; --pty names it")
        ->needs(tiles);
    sub->add_option("--drift-ppm", options->tiles.drift_ppm,
                    "The boards' crystals are off by up to this much, to either side")
        ->needs(tiles)
        ->check(CLI::Range(0.0, 50.0))
        ->capture_default_str();
    sub->add_option("--seed", options->tiles.seed, "Seed of drifts, start phases and what registers hold at power-up")
        ->needs(tiles)
        ->check(whole(0, 4'294'967'295))
        ->capture_default_str();
    sub->add_option(
           "--fault", options->tiles.faults,
           "silent:TILE@SECONDS cuts a tile's serial line after so much simulated time (in a chain those behind it "
           "lose theirs, too), sync:TILE@SECONDS its "
           "wire SYNC; again for each")
        ->needs(tiles);
    sub->add_flag("--json", options->json, "Print the port, and the outcome at the end, as a line of JSON each");
    sub->callback([options, &action] { action = [options] { return run_board(*options); }; });
}

}  // namespace haptogram::cli
