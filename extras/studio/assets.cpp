// SPDX-License-Identifier: Apache-2.0
#include "assets.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram::studio {
namespace {

/// What gzip has packed. @param bytes  that it has unpacked
/// @return none when it is damaged, or has another number of bytes
std::optional<std::string> unpacked(std::string& packed, std::size_t bytes) {
    std::string plain(bytes + 1, '\0');  // room to see that there is more
    z_stream stream{};
    constexpr int with_gzip_header = 16 + MAX_WBITS;
    if (inflateInit2(&stream, with_gzip_header) != Z_OK) return {};
    stream.next_in = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(plain.data());
    stream.avail_out = static_cast<uInt>(plain.size());
    const bool whole = inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.total_out == bytes;
    inflateEnd(&stream);
    if (!whole) return {};
    plain.resize(bytes);
    return plain;
}

}  // namespace

Assets load_assets(const std::filesystem::path& folder) {
    const std::filesystem::path list_path = folder / "page.json";
    nlohmann::json list;
    try {
        list = nlohmann::json::parse(read_file(list_path));
        Assets assets;
        for (const nlohmann::json& each : list.at("files")) {
            const std::string name = each.at("name");
            if (name.find('/') != std::string::npos)
                throw bad_input(list_path.string(), fmt::format("'{}' is no name of a file beside it", name));
            const std::filesystem::path path = folder / (name + ".gz");
            std::string gzip = read_file(path);
            std::optional<std::string> plain = unpacked(gzip, each.at("bytes"));
            if (!plain || sha256(*plain) != each.at("sha256").get<std::string>())
                throw bad_input(path.string(), "is not the file that page.json lists; build the page again");
            assets["/" + name] = {each.at("type"), *std::move(plain), std::move(gzip)};
        }
        const auto index = assets.find("/index.html");
        if (index == assets.end()) throw bad_input(list_path.string(), "lists no index.html; build the page again");
        assets["/"] = index->second;
        return assets;
    } catch (const nlohmann::json::exception& error) {
        throw bad_input(list_path.string(), fmt::format("{}; build the page again", error.what()));
    }
}

Assets assets_without_page(const std::string& looked_in) {
    const std::string text = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Haptogram studio</title></head><body>"
        "<h1>Haptogram studio: the page was not built</h1>"
        "<p>This server works, but its page is missing. It is built when node and the packages of "
        "<code>extras/studio/web</code> are there: run <code>tools/setup</code>, then <code>make build</code>.</p>"
        "<p>Looked in: {}</p></body></html>\n",
        looked_in);
    const Asset page{"text/html; charset=utf-8", text, {}};
    return {{"/", page}, {"/index.html", page}};
}

}  // namespace haptogram::studio
