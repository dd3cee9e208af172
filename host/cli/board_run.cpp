// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/image/intel_hex.hpp"
#include "haptogram/link/frame.hpp"
#include "interrupt.hpp"
#include "playback.hpp"
#include "pseudo_terminal.hpp"
#include "pulse_check.hpp"

namespace haptogram::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct RunOptions {
    std::string image;
    std::string pty;
    std::string speed = "real";
    std::string trace;
    std::string pulses;
    std::uint32_t channels = 100;
    double seconds = 0.0;
    bool json = false;
};

/// What goes over the line, counted from outside: a frame that nobody answers was damaged, or cut off.
class LinkCounters {
public:
    void in(const std::vector<std::uint8_t>& bytes) {
        bytes_in += bytes.size();
        for (const std::uint8_t byte : bytes) {
            frames += byte == 0 && in_frame_ ? 1 : 0;
            in_frame_ = byte != 0;
        }
    }
    void out(const std::vector<std::uint8_t>& bytes) {
        bytes_out += bytes.size();
        std::vector<link::Reply> replies;
        decoder_.feed(bytes, replies);
        for (const link::Reply& reply : replies)
            ++(reply.status == interface::Status::ok         ? applied
               : reply.status == interface::Status::repeated ? repeated
                                                             : refused);
    }

    std::uint64_t bytes_in = 0, bytes_out = 0, frames = 0, applied = 0, repeated = 0, refused = 0;

private:
    bool in_frame_ = false;
    link::ReplyDecoder decoder_;
};

/// The line that says what the board is doing; on a terminal only.
class StatusLine {
public:
    ~StatusLine() {
        if (drawn_) std::fputs("\r\033[K", stderr);
    }

    void show(const sim::Board& board, double wall_s, const LinkCounters& link) {
        if (::isatty(STDERR_FILENO) != 1 || Clock::now() - last_ < std::chrono::milliseconds(200)) return;
        last_ = Clock::now();
        drawn_ = true;
        const double simulated = static_cast<double>(board.now()) / board.parameters().clock_hz;
        std::fputs(
            fmt::format("\r{:.3f} s simulated, {:.3f} of real time, record {}, outputs {}, {} frames in: {} applied, "
                        "{} repeated, {} refused\033[K",
                        simulated, wall_s > 0.0 ? simulated / wall_s : 0.0, board.outputs().index,
                        board.outputs().enabled ? "on" : "off", link.frames, link.applied, link.repeated, link.refused)
                .c_str(),
            stderr);
        std::fflush(stderr);
    }

private:
    bool drawn_ = false;
    Clock::time_point last_{};
};

std::optional<Image> read_image(const std::string& path) {
    if (path.empty()) return {};
    Image image = from_intel_hex(read_file(path), path);
    const std::vector<std::string> found = problems(image);
    if (!found.empty()) throw bad_input(path, found.front());
    return image;
}

std::string_view model_of(std::uint32_t channels) {
    std::string known;
    for (const auto& [name, parameters, about] : sim::available_models()) {
        if (parameters.channels == channels) return name;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", parameters.channels);
    }
    throw Error(ErrorCode::bad_argument, "--channels",
                fmt::format("no simulated board has {}; there are {}", channels, known));
}

/// What a board was asked and did while it ran.
struct Served {
    LinkCounters link;
    std::uint64_t playing_clocks = 0;
    double playing_s = 0.0;  ///< of real time, waiting for it left out
};

/// Runs until it is asked to end.
Served serve(sim::Board& board, sim::PseudoTerminal& terminal, const RunOptions& options) {
    constexpr std::uint64_t slice = 2000;  // clocks, less than one byte at 115,200 baud
    constexpr double most_behind_s = 0.1;
    const double clock_hz = board.parameters().clock_hz;
    const auto begun = Clock::now();
    const auto wall = [begun] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
    Served served;
    double given_up_s = 0.0;  // of real time: what a slow simulation is not to catch up with
    StatusLine line;
    while (!interrupted() &&
           (options.seconds == 0.0 || static_cast<double>(board.now()) < options.seconds * clock_hz)) {
        const double ahead_s = static_cast<double>(board.now()) / clock_hz + given_up_s - wall();
        if (ahead_s < -most_behind_s) given_up_s -= ahead_s + most_behind_s;
        const bool waits = options.speed == "real" && ahead_s > 1e-3;
        const auto arrived = terminal.read(std::chrono::milliseconds(waits ? static_cast<int>(1e3 * ahead_s) : 0));
        board.send(arrived);
        const double before_s = wall();
        board.run(slice);
        if (board.outputs().playing) {
            served.playing_clocks += slice;
            served.playing_s += wall() - before_s;
        }
        const auto answer = board.receive();
        terminal.write(answer);
        served.link.in(arrived);
        served.link.out(answer);
        line.show(board, wall(), served.link);
    }
    return served;
}

int run_board(const RunOptions& options) {
    std::vector<NamedPath> outputs;
    if (!options.pulses.empty()) outputs.push_back({"--pulses", options.pulses});
    if (!options.trace.empty()) outputs.push_back({"--trace", options.trace});
    require_distinct({{"--image", options.image}}, outputs);
    const std::optional<Image> image = read_image(options.image);
    sim::Board board(image ? sim::model_for(*image, options.image) : model_of(options.channels));
    std::optional<StagedFile> trace;
    std::optional<StagedFile> pulses;
    if (!options.trace.empty()) {
        trace.emplace(options.trace);
        if (trace->beside().empty())
            throw bad_input(options.trace, "a trace needs a file of its own; name one that is no device or pipe");
        board.trace(trace->beside());
    }
    std::optional<sim::PulseRecorder> recorder;
    if (!options.pulses.empty()) {
        pulses.emplace(options.pulses);
        recorder.emplace(board);
    }
    if (image) sim::load_directly(board, *image);
    catch_interrupts();
    sim::PseudoTerminal terminal(options.pty);
    const interface::CoreParameters& p = board.parameters();
    if (options.json)
        fmt::print("{}\n", nlohmann::ordered_json{{"port", terminal.name()},
                                                  {"channels", p.channels},
                                                  {"records", p.records},
                                                  {"clock_hz", p.clock_hz},
                                                  {"baud", p.baud}}
                               .dump());
    else
        fmt::print("{}\n", terminal.name());
    std::fflush(stdout);
    const auto begun = Clock::now();
    const Served served = serve(board, terminal, options);
    const double wall_s = std::chrono::duration<double>(Clock::now() - begun).count();

    if (pulses) {
        pulses->fill(to_csv(recorder->pulses()));
        pulses->commit();
    }
    const double simulated_s = static_cast<double>(board.now()) / p.clock_hz;
    const double playing_mclk_per_s =
        served.playing_s > 0.0 ? 1e-6 * static_cast<double>(served.playing_clocks) / served.playing_s : 0.0;
    if (options.json)
        fmt::print("{}\n", nlohmann::ordered_json{{"simulated_s", simulated_s},
                                                  {"wall_s", wall_s},
                                                  {"bytes_in", served.link.bytes_in},
                                                  {"bytes_out", served.link.bytes_out},
                                                  {"frames_in", served.link.frames},
                                                  {"frames_applied", served.link.applied},
                                                  {"frames_repeated", served.link.repeated},
                                                  {"frames_refused", served.link.refused},
                                                  {"playing_mclk_per_s", playing_mclk_per_s},
                                                  {"enabled", board.outputs().enabled}}
                               .dump());
    else
        fmt::print("{:.3f} s simulated in {:.1f} s, {} frames in, {} applied, {:.2f} Mclk/s while playing\n",
                   simulated_s, wall_s, served.link.frames, served.link.applied, playing_mclk_per_s);
    board.end_trace();
    if (trace) trace->commit();
    return 0;
}

}  // namespace

void add_board_run(CLI::App& board, Action& action) {
    auto options = std::make_shared<RunOptions>();
    CLI::App* sub = board.add_subcommand("run",
                                         "Run the Verilated FPGA behind a pseudo-terminal, which any program can open "
                                         "as its serial port; prints the port");
    auto* image = sub->add_option("--image", options->image, "Intel HEX image that is in its memories from the start");
    sub->add_option("--channels", options->channels, "Channels of the board, without an image")
        ->excludes(image)
        ->capture_default_str();
    sub->add_option("--pty", options->pty, "A name for the port: a link to it, removed at the end");
    sub->add_option("--speed", options->speed, "No faster than a real board, or as fast as this machine can")
        ->check(CLI::IsMember({"real", "max"}))
        ->capture_default_str();
    sub->add_option("--seconds", options->seconds, "End after so much simulated time (default: Ctrl-C)")
        ->check(positive());
    sub->add_option("--trace", options->trace, "Write every signal (FST, for GTKWave)");
    sub->add_option("--pulses", options->pulses, "Write the pulses measured at the pins (CSV)");
    sub->add_flag("--json", options->json, "Print the port, and the outcome at the end, as a line of JSON each");
    sub->callback([options, &action] { action = [options] { return run_board(*options); }; });
}

}  // namespace haptogram::cli
