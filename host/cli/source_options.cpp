// SPDX-License-Identifier: Apache-2.0
#include "source_options.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram::cli {

CLI::Option* add_source_file(CLI::App& command, Source& source, const std::string& what) {
    return command.add_option(
        "source", source.file,
        what +
            "Intel HEX image, with its manifest beside it; a rig's manifest (.json); or what is compiled first: a "
            "project (.toml, .haptogram), a path (.json, .csv, .adaptics), or a shape (.ply, .obj, .stl, .off, "
            ".pcd, .3mf, .gltf, .glb, .svg, .xyz, .csv)");
}

void add_array_and_board(CLI::App& command, Source& source) {
    command.add_option(
        "--array", source.array,
        "Array file or shipped array for a path, a shape or --focus (default: tile-10x10). A compiled image "
        "must have been made for it");
    command.add_option("--board", source.board,
                       "Board file, shipped board or configuration for a path, a shape or --focus");
}

void add_source(CLI::App& command, SourceOptions& options) {
    Source& source = options.source;
    CLI::Option* const file = add_source_file(command, source,
                                              "What is looked at. A manifest alone (.json) has exact phases, an image "
                                              "those of the board. One of: manifest; ");
    CLI::Option* const focus = command
                                   .add_option("--focus", options.focus,
                                               "One focus at x,y,z (mm) in place of a file; its phases are not rounded")
                                   ->excludes(file);
    add_array_and_board(command, source);
    command.add_option("--rig", source.rig, "Rig of --focus, instead of an array: several arrays, each in its place")
        ->needs(focus)
        ->excludes(command.get_option("--array"));
    add_quantise(command, options.quantise)->needs(focus);
    CLI::Option* const pulses =
        command.add_option("--pulses", source.pulses, "Pulse file from simulate or board run instead")
            ->excludes(file)
            ->excludes(focus);
    CLI::Option* const manifest = command.add_option("--manifest", source.manifest,
                                                     "Manifest of the image, or of the rig's images, that was played");
    manifest->excludes(focus);
    pulses->needs(manifest);
}

Source source_of(const SourceOptions& options, const std::string& command) {
    Source source = options.source;
    if (!options.focus.empty()) source.focus = parse_point_mm("focus", options.focus);
    source.quantise = options.quantise.value_or("");
    source.makers = path_makers();
    if (source.file.empty() && !source.focus && source.pulses.empty())
        throw bad_argument(command, fmt::format("expected an image or another file, --focus or --pulses; see "
                                                "haptogram {} --help",
                                                command));
    return source;
}

std::vector<NamedPath> files_of(const Source& source) {
    std::vector<NamedPath> files = {
        {"the file", source.file}, {"--pulses", source.pulses}, {"--manifest", source.manifest}};
    if (source.manifest.empty() && source.file.ends_with(".hex"))
        files.push_back({"its manifest", manifest_path(source.file)});
    for (const auto& [option, name] : {std::pair{"--array", source.array}, {"--board", source.board}})
        if (name && name->ends_with(".toml")) files.push_back({option, *name});
    return files;
}

}  // namespace haptogram::cli
