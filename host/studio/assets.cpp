// SPDX-License-Identifier: Apache-2.0
#include "assets.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram::studio {

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
            Asset asset{each.at("type"), read_file(folder / name), {}};
            if (sha256(asset.plain) != each.at("sha256").get<std::string>())
                throw bad_input((folder / name).string(), "is not the file that page.json lists; build the page again");
            if (each.at("gzip")) asset.gzip = read_file(folder / (name + ".gz"));
            assets["/" + name] = std::move(asset);
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
        "<code>host/studio/web</code> are there: run <code>tools/setup</code>, then <code>make build</code>.</p>"
        "<p>Looked in: {}</p></body></html>\n",
        looked_in);
    const Asset page{"text/html; charset=utf-8", text, {}};
    return {{"/", page}, {"/index.html", page}};
}

}  // namespace haptogram::studio
