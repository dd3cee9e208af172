// SPDX-License-Identifier: Apache-2.0
// The commands of parts that a build leaves out: they are known, and say what they would need.
#include <fmt/format.h>

#include <string>

#include "command.hpp"
#include "hands.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/perception/path_magnitude.hpp"
#ifdef HAPTOGRAM_HAS_LIVE
#include "live_board.hpp"
#endif
#ifdef HAPTOGRAM_HAS_ROBOT
#include "frame_pins.hpp"
#endif

namespace haptogram::cli {
namespace {

[[maybe_unused]] void add_absent(CLI::App& app, Action& action, const std::string& name, const std::string& part,
                                 const std::string& remedy) {
    CLI::App* sub = app.add_subcommand(name, "Not in this build, which has no " + part);
    sub->allow_extras();
    sub->callback([=, &action] {
        action = [=]() -> int { throw bad_argument(name, "this build has no " + part + "; build with " + remedy); };
    });
}

}  // namespace

#ifndef HAPTOGRAM_HAS_STUDIO
void add_studio(CLI::App& app, Action& action) { add_absent(app, action, "studio", "studio", "HAPTOGRAM_STUDIO=ON"); }
void add_serve(CLI::App& app, Action& action) { add_absent(app, action, "serve", "service", "HAPTOGRAM_STUDIO=ON"); }
#endif

#ifndef HAPTOGRAM_HAS_SIMULATION
constexpr auto with_verilator = "HAPTOGRAM_SIMULATION=ON, which needs Verilator";
void add_simulate(CLI::App& app, Action& action) {
    add_absent(app, action, "simulate", "simulated board", with_verilator);
}
void use_simulation_of_this_build() {}
void add_board_run(CLI::App& board, Action& action) {
    add_absent(board, action, "run", "simulated board", with_verilator);
}
#ifdef HAPTOGRAM_HAS_ROBOT
PinsOfFrame pins_of(const fusion::Frame&, const Array&, const Core&, const perception::Tables&) {
    throw bad_argument(
        "frames",
        fmt::format("this build has no simulated board to play them; ask for 0, or build with {}", with_verilator));
}
#endif
#ifdef HAPTOGRAM_HAS_LIVE
std::unique_ptr<LiveBoard> reference_board(const std::string&) {
    throw bad_argument(
        "port", fmt::format("this build has no simulated board; name a serial port, or build with {}", with_verilator));
}
std::unique_ptr<LiveBoard> reference_rig(const std::string& configuration, const Rig&, const link::RigSettings&) {
    return reference_board(configuration);
}
#endif
#endif

#ifndef HAPTOGRAM_HAS_CALIBRATION
void add_calibrate(CLI::App& app, Action& action) {
    add_absent(app, action, "calibrate", "calibration", "calibration in HAPTOGRAM_EXTENSIONS");
}
#endif

#ifndef HAPTOGRAM_HAS_HAND
constexpr auto with_hand = "hand in HAPTOGRAM_EXTENSIONS";
void add_render(CLI::App& app, Action& action) { add_absent(app, action, "render", "hands", with_hand); }
void add_movement(CLI::App& app, Action& action) { add_absent(app, action, "movement", "hands", with_hand); }
void add_interact(CLI::App& app, Action& action) { add_absent(app, action, "interact", "hands", with_hand); }
void add_align(CLI::App& app, Action& action) { add_absent(app, action, "align", "hands", with_hand); }
PathMakers path_makers() {
    return {{}, [](Path& path, const Project& project, const Array& array) {
                return perception::give_magnitude(path, project, array);
            }};
}
std::function<HandSkin(Vec3)> skin_of_hand(const std::string&, const std::string&, std::size_t) {
    throw bad_argument("hand", fmt::format("this build has no hands; build with {}", with_hand));
}
#endif

#ifndef HAPTOGRAM_HAS_SCATTERING
void add_scatter(CLI::App& app, Action& action) {
    add_absent(app, action, "scatter", "scattering", "scattering in HAPTOGRAM_EXTENSIONS");
}
#endif

#ifndef HAPTOGRAM_HAS_LIVE
void add_live(CLI::App& app, Action& action) {
    add_absent(app, action, "live", "live touch", "live in HAPTOGRAM_EXTENSIONS");
}
void add_task(CLI::App& app, Action& action) {
    add_absent(app, action, "task", "live touch", "live in HAPTOGRAM_EXTENSIONS");
}
#endif

#ifndef HAPTOGRAM_HAS_ROBOT
void add_robot(CLI::App& app, Action& action) {
    add_absent(app, action, "robot", "cable robot", "robot in HAPTOGRAM_EXTENSIONS");
}
#endif

}  // namespace haptogram::cli
