// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "haptogram/base/error.hpp"
#include "haptogram/format/core.hpp"

namespace haptogram {
namespace {

/// Images of a rig are made once for all boards, so what limits an image must be the same on all.
void require_alike(const Rig& rig, const std::vector<Core>& cores) {
    using interface::CoreParameters;
    for (std::size_t i = 1; i < cores.size(); ++i)
        for (const auto& one : interface::core_parameters) {
            if (one.member == &CoreParameters::channels || one.member == &CoreParameters::baud) continue;
            const std::uint32_t here = cores[i].parameters.*one.member, first = cores[0].parameters.*one.member;
            if (here != first)
                throw bad_input(rig.file,
                                fmt::format("the boards of units 1 and {} differ: {} is {} on {}, and {} on "
                                            "{}; a rig is compiled for boards that are alike",
                                            i + 1, one.name, first, cores[0].name, here, cores[i].name),
                                {"board"});
        }
}

/// One board alone need not keep time with others.
void require_together(const Rig& rig, const std::vector<Core>& cores) {
    for (std::size_t i = 0; cores.size() > 1 && i < cores.size(); ++i)
        if (cores[i].parameters.sync == 0 || cores[i].parameters.schedule == 0)
            throw bad_input(rig.file,
                            fmt::format("unit {}: the board {} has {}; boards that play together need both SYNC and "
                                        "SCHEDULE, as tile-100-wide has them: name one with board in the rig's file, "
                                        "or with --board",
                                        i + 1, cores[i].name,
                                        cores[i].parameters.sync != 0       ? "SYNC, but no SCHEDULE"
                                        : cores[i].parameters.schedule != 0 ? "SCHEDULE, but no SYNC"
                                                                            : "neither SYNC nor SCHEDULE"),
                            {"board"});
}

/// Boards with a role play nothing else.
void require_common_period(const Rig& rig, const Timer& timer, const Core& core) {
    constexpr std::uint32_t common_hz = 40'000;
    const std::uint32_t wanted = core.parameters.clock_hz / common_hz, made = timer.prescaler * timer.cycle_ticks;
    if (made != wanted)
        throw bad_input(
            rig.file,
            fmt::format("its carrier period is {} clocks, but boards in step play only records of {}, which "
                        "is a period of {} Hz; take arrays with that carrier",
                        made, wanted, common_hz),
            {"array"});
}

std::vector<TilePart> parts_of(const Rig& rig, const std::vector<Core>& cores) {
    std::vector<TilePart> parts;
    for (std::size_t i = 0; i < cores.size(); ++i) {
        const Array& array = rig.arrays[i].array;
        require_channels(array, cores[i]);
        parts.push_back(
            {array.name, array.elements.size(), cores[i], rig.boards.empty() ? std::string() : rig.boards[i].port});
    }
    return parts;
}

/// @param compile_for  makes the image of all elements
CompiledRig compile_on(const std::string& rig_name, const std::optional<std::string>& board, const std::string& name,
                       bool streamed, const std::function<Compiled(const ProjectInstrument&)>& compile_for) {
    const Rig rig = find_rig(rig_name);
    const std::vector<Core> cores = cores_of(rig, board);
    require_alike(rig, cores);
    require_together(rig, cores);
    const std::vector<TilePart> parts = parts_of(rig, cores);
    // The board with the fewest channels holds the least.
    Core least = *std::ranges::min_element(cores, {}, [](const Core& c) { return c.parameters.channels; });
    if (streamed) least.parameters.sequence_depth = interface::sequence_header_field::length.most() + 1;
    CompiledRig compiled{compile_for({joined(rig), least, cores.size()}), {}};
    if (cores.size() > 1) require_common_period(rig, compiled.whole.bundle.manifest.timer, least);
    if (compiled.whole.bundle.image.foci)
        for (const TilePart& part : parts)
            if (part.elements != part.core.parameters.channels)
                throw bad_input(rig.file,
                                fmt::format("{} has {} elements, but {} computes foci for all of its {} channels; "
                                            "compile records, in which a channel can be silent",
                                            part.array, part.elements, part.core.name, part.core.parameters.channels),
                                {"records"});
    compiled.bundle = split(compiled.whole.bundle, rig.name, parts, name);
    return compiled;
}

CompiledRig compile_on(const Project& project, const std::string& rig, const std::string& name, bool streamed,
                       const Progress& progress) {
    if (project.array)
        throw bad_argument("array", "a rig has arrays of its own; leave out the array, or the rig", {"array", "rig"});
    std::optional<std::string> board = project.board;
    if (board) board = project.beside(*board);
    return compile_on(rig, board, name, streamed, [&](const ProjectInstrument& instrument) {
        return compile(instrument, project, name, progress);
    });
}

}  // namespace

std::vector<Core> cores_of(const Rig& rig, const std::optional<std::string>& board) {
    std::vector<Core> cores;
    for (std::size_t i = 0; i < rig.arrays.size(); ++i) {
        const std::string named = board ? *board : rig.boards.empty() ? std::string() : rig.boards[i].board;
        cores.push_back(named.empty() ? core_of_array(rig.arrays[i].array.file) : find_core(named));
    }
    return cores;
}

RigBundle boards_of(const Rig& rig) {
    RigBundle bundle;
    bundle.rig = bundle.name = rig.name;
    bundle.parts = parts_of(rig, cores_of(rig));
    bundle.tiles.resize(bundle.parts.size());
    return bundle;
}

ProjectInstrument instrument_of_rig(const std::string& name) {
    const Rig rig = find_rig(name);
    const std::vector<Core> cores = cores_of(rig);
    ProjectInstrument found{joined(rig), cores.front()};
    interface::CoreParameters& all = found.core.parameters;
    for (std::size_t i = 1; i < cores.size(); ++i) {
        const interface::CoreParameters& one = cores[i].parameters;
        if (one.clock_hz != all.clock_hz || one.timing_bits != all.timing_bits || one.pulse_bits != all.pulse_bits)
            throw bad_input(rig.file, fmt::format("the boards of {} and {} differ in clock_hz, timing_bits or "
                                                  "pulse_bits, so there are no ticks that both have",
                                                  rig.arrays.front().array.name, rig.arrays[i].array.name));
    }
    all.channels = static_cast<std::uint32_t>(found.array.elements.size());
    return found;
}

CompiledRig compile_rig(const Project& project, const std::string& rig, const std::string& name,
                        const Progress& progress) {
    return compile_on(project, rig, name, false, progress);
}

CompiledRig compile_rig(const Path& path, Method solver, const std::string& quantise, const std::string& rig,
                        const std::string& name) {
    return compile_on(rig, {}, name, false, [&](const ProjectInstrument& instrument) {
        return compile(path, instrument, 0, name, solver, quantise, ImageKind::records);
    });
}

CompiledRig compile_rig_for_stream(const Project& project, const std::string& rig, const std::string& name) {
    return compile_on(project, rig, name, true, {});
}

}  // namespace haptogram
