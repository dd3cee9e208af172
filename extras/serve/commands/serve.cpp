// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/link/background_player.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "server.hpp"
#ifdef HAPTOGRAM_HAS_SIMULATION
#include "reference_port.hpp"
#endif

namespace haptogram::cli {

void add_serve(CLI::App& app, Action& action);
namespace {

struct ServeOptions {
    link::PortSettings port;
    serve::ServerOptions server;
    bool no_token = false, json = false;
};

int run(const ServeOptions& given) {
    catch_interrupts();
    serve::ServerOptions server = given.server;
    if (!given.no_token && server.token.empty()) server.token = make_token();
#ifdef HAPTOGRAM_HAS_SIMULATION
    const auto open = sim::opener_of(given.port);
#else
    const auto open = [&] { return link::open_port(given.port); };
#endif
    link::BackgroundPlayer board(open, std::chrono::seconds(10));
    serve::Verbs verbs(board, path_makers());
    const auto listening = [&](std::uint16_t port) {
        const std::string address = fmt::format("ws://127.0.0.1:{}", port);
        if (given.json)
            fmt::print("{}\n", nlohmann::ordered_json{{"address", address}, {"token", server.token}}.dump());
        else
            fmt::print("{}{}\n", address, server.token.empty() ? "" : "  token " + server.token);
        std::fflush(stdout);
    };
    serve::run(verbs, server, listening, [] { return !interrupted(); });
    return 0;
}

}  // namespace

void add_serve(CLI::App& app, Action& action) {
    auto options = std::make_shared<ServeOptions>();
    CLI::App* sub = app.add_subcommand("serve",
                                       "Drive a board for programs that cannot load a library: JSON and foci over a "
                                       "WebSocket, foci by OSC, on this machine alone. Prints the address and the "
                                       "token; Ctrl-C ends it, and the outputs are off");
    sub->add_option("--port", options->port.port,
                    "Serial port of the board, ftdi:[VID:PID[:SERIAL]], udp:ADDRESS[:PORT], or reference:NAME for a "
                    "simulated one")
        ->required();
    add_baud_option(*sub, options->port.baud);
    sub->add_option("--listen", options->server.port, "Port of the WebSocket (default: one that is free)")
        ->check(whole(1, 65535));
    sub->add_option("--osc", options->server.osc_port, "Port of OSC over UDP (default: none)")->check(whole(1, 65535));
    auto* const token =
        sub->add_option("--token", options->server.token, "Token that clients must show (default: a random one)");
    auto* const open =
        sub->add_flag("--no-token", options->no_token, "Let every program of this machine in")->excludes(token);
    sub->add_option(
           "--origin", options->server.origins,
           "Let pages of this site in, too, such as https://example.org or http://localhost:8000; they need the token. "
           "May be given several times")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->excludes(open);
    sub->add_flag("--json", options->json, "Print address and token as JSON");
    sub->callback([options, &action] { action = [options] { return run(*options); }; });
}

void register_serve(Extras& extras) { extras.commands[Purpose::other].push_back(add_serve); }

}  // namespace haptogram::cli
