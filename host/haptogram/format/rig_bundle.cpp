// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/rig_bundle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view format = "haptogram-rig-manifest-1";

template <class T>
std::vector<T> part_of(const std::vector<T>& all, std::size_t first, std::size_t count) {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
    return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from, std::size_t count) {
    to.insert(to.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
}

/// The text of a tile's manifest and back, which rounds, so that a tile is the same in memory and from its files.
Bundle finished(Image image, Manifest manifest, const std::string& name) {
    std::string hex = to_intel_hex(image);
    manifest.image_sha256 = sha256(hex);
    return bundle_of(std::move(hex), manifest_from_json(to_text(manifest), name), name, name);
}

/// @param number  of the tile, counted from 0
Bundle tile_of(const Bundle& whole, std::size_t number, std::size_t first, const TilePart& part,
               const std::string& name) {
    const interface::CoreParameters& core = part.core.parameters;
    Image image = whole.image;
    image.channels = core.channels;
    for (Record& record : image.records) {
        record.timings = part_of(record.timings, first, part.elements);
        record.timings.resize(core.channels, interface::silent_timing);
    }
    if (image.foci) {
        image.foci->engine.geometry = part_of(image.foci->engine.geometry, first, part.elements);
        // Images of foci differ only in their geometry, which no board gives back. The place of their records tells
        // which tile holds what.
        image.foci->gap = static_cast<std::uint32_t>(number);
        if (const std::size_t room = std::size_t{core.records} * record_words(core.channels),
            needed = primary_words(image).size();
            needed > room)
            throw bad_input(name,
                            fmt::format("its foci need {} words of primary memory, the board has {}; take fewer points",
                                        needed, room),
                            {"points"});
    }
    Manifest manifest = whole.manifest;
    manifest.array.name = part.array;
    manifest.array.elements = part_of(whole.manifest.array.elements, first, part.elements);
    manifest.core = part.core;
    return finished(std::move(image), std::move(manifest), name);
}

/// What must be alike in all tiles, as text: all that is not of single elements.
std::string common_of(const Bundle& tile) {
    Manifest manifest = tile.manifest;
    manifest.array.name.clear();
    manifest.array.elements.clear();
    manifest.core = {};
    manifest.image_sha256.clear();
    std::string text = to_text(manifest);
    for (const SequenceEntry& entry : tile.image.sequence) text += fmt::format("{} {}\n", entry.index, entry.dwell);
    for (const Record& r : tile.image.records)
        text += fmt::format("{} {} {}\n", r.cycle_length, r.prescaler, r.pulse_length);
    return text;
}

ordered_json elements_of(const Manifest& manifest) { return to_json(manifest).at("array").at("elements_mm"); }

/// Of every element's place, in the order of tiles.
std::string hash_of_places(const RigBundle& bundle) {
    std::string text;
    for (const Bundle& tile : bundle.tiles) text += elements_of(tile.manifest).dump();
    return sha256(text);
}

std::string text_member(const ordered_json& json, const char* key, const std::string& where) {
    const auto member = json.is_object() ? json.find(key) : json.end();
    if (member == json.end() || !member->is_string())
        throw bad_input(where, fmt::format("{} must be a text, found {}; compile the rig again", key,
                                           member == json.end() ? "nothing" : member->dump()));
    return member->get<std::string>();
}

bool has_format(const ordered_json& json) { return json.is_object() && json.value("format", ordered_json()) == format; }

ordered_json parsed(const std::string& path) {
    const std::string text = read_file(path);
    require_shallow(text, path);
    ordered_json json = ordered_json::parse(text, nullptr, false);
    if (!has_format(json))
        throw bad_input(path,
                        fmt::format("it is no rig manifest, whose format is {}; give the .json file that haptogram "
                                    "compile --rig has written, not a tile's",
                                    format));
    return json;
}

void read_tile(RigBundle& bundle, const ordered_json& json, const std::string& path) {
    const std::string where = fmt::format("{}: tile {}", path, bundle.tiles.size() + 1);
    const std::string image = (std::filesystem::path(path).parent_path() / text_member(json, "image", where)).string();
    Bundle tile = load_bundle(image);
    if (tile.manifest.image_sha256 != text_member(json, "image_sha256", where))
        throw bad_input(where, fmt::format("{} is another image than the one that was compiled with it; compile the "
                                           "rig again",
                                           image));
    bundle.parts.push_back({tile.manifest.array.name, tile.manifest.array.elements.size(), tile.manifest.core,
                            json.contains("port") ? text_member(json, "port", where) : ""});
    bundle.tiles.push_back(std::move(tile));
}

}  // namespace

std::string tile_image_path(const std::string& rig_manifest, std::size_t tile) {
    return std::filesystem::path(rig_manifest).replace_extension(fmt::format(".tile-{}.hex", tile)).string();
}

RigBundle split(const Bundle& whole, const std::string& rig, std::span<const TilePart> parts, const std::string& name) {
    RigBundle bundle{rig, name, {parts.begin(), parts.end()}, {}, whole};
    std::size_t elements = 0;
    for (const TilePart& part : parts) elements += part.elements;
    if (elements != whole.manifest.array.elements.size())
        throw bad_input(name, fmt::format("{} elements, but the boards of the rig {} drive {}",
                                          whole.manifest.array.elements.size(), rig, elements));
    std::size_t first = 0;
    for (const TilePart& part : parts) {
        const std::size_t number = bundle.tiles.size();
        bundle.tiles.push_back(tile_of(whole, number, first, part, tile_image_path(name, number + 1)));
        first += part.elements;
    }
    return bundle;
}

Bundle joined(std::span<const Bundle> tiles, const std::string& name) {
    if (tiles.empty()) throw bad_input(name, "it has no tiles; compile the rig again");
    Image image = tiles.front().image;
    Manifest manifest = tiles.front().manifest;
    manifest.array.elements.clear();
    for (Record& record : image.records) record.timings.clear();
    if (image.foci) {
        image.foci->engine.geometry.clear();
        image.foci->gap = 0;
    }
    const std::string common = common_of(tiles.front());
    for (const Bundle& tile : tiles) {
        if (common_of(tile) != common)
            throw bad_input(tile.name, fmt::format("its sequence, timer or foci are not those of {}; compile all "
                                                   "tiles of the rig together",
                                                   tiles.front().name));
        const std::size_t elements = tile.manifest.array.elements.size();
        append(manifest.array.elements, tile.manifest.array.elements, elements);
        for (std::size_t i = 0; i < image.records.size(); ++i)
            append(image.records[i].timings, tile.image.records[i].timings, elements);
        if (image.foci) append(image.foci->engine.geometry, tile.image.foci->engine.geometry, elements);
    }
    image.channels = manifest.core.parameters.channels = static_cast<std::uint32_t>(manifest.array.elements.size());
    return finished(std::move(image), std::move(manifest), name);
}

std::string to_text(const RigBundle& bundle) {
    ordered_json json;
    json["format"] = format;
    json["tool"] = {{"name", "haptogram"}, {"version", version()}};
    json["rig"] = {{"name", bundle.rig}, {"elements_sha256", hash_of_places(bundle)}};
    for (std::size_t i = 0; i < bundle.tiles.size(); ++i) {
        const Bundle& tile = bundle.tiles[i];
        ordered_json one{{"image", std::filesystem::path(tile.name).filename().string()},
                         {"image_sha256", tile.manifest.image_sha256},
                         {"array", tile.manifest.array.name},
                         {"elements", tile.manifest.array.elements.size()}};
        if (!bundle.parts[i].port.empty()) one["port"] = bundle.parts[i].port;
        json["tiles"].push_back(std::move(one));
    }
    return json.dump(1) + "\n";
}

std::vector<std::pair<std::filesystem::path, std::string>> files_of(const RigBundle& bundle) {
    std::vector<std::pair<std::filesystem::path, std::string>> files;
    for (const Bundle& tile : bundle.tiles) {
        files.emplace_back(tile.name, tile.hex);
        files.emplace_back(manifest_path(tile.name), to_text(tile.manifest));
    }
    files.emplace_back(bundle.name, to_text(bundle));  // last, so that it never names images that are not there yet
    return files;
}

bool is_rig_manifest(std::string_view text) {
    return is_shallow(text) && has_format(ordered_json::parse(text, nullptr, false));
}

RigBundle load_rig_bundle(const std::string& path) {
    const ordered_json json = parsed(path);
    const ordered_json rig = json.value("rig", ordered_json());
    const ordered_json tiles = json.value("tiles", ordered_json());
    if (!tiles.is_array() || tiles.empty())
        throw bad_input(path, "tiles must be a list with at least one in it; compile the rig again");
    RigBundle bundle{text_member(rig, "name", path), path, {}, {}, {}};
    for (const ordered_json& tile : tiles) read_tile(bundle, tile, path);
    if (hash_of_places(bundle) != text_member(rig, "elements_sha256", path))
        throw bad_input(path,
                        "its tiles do not stand where they stood when it was written, or in another order; "
                        "compile the rig again");
    bundle.whole = joined(bundle.tiles, path);
    bundle.whole.manifest.array.name = bundle.rig;
    return bundle;
}

}  // namespace haptogram
