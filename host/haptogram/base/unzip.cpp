// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>
#include <unzip.h>

#include <cstdio>
#include <memory>
#include <type_traits>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

struct Close {
    void operator()(unzFile file) const { unzClose(file); }
};
using Archive = std::unique_ptr<std::remove_pointer_t<unzFile>, Close>;

struct Place {
    std::filesystem::path bundle, inside;
};

/// The bundle that a path leads into, if it does.
std::optional<Place> place_in_bundle(const std::filesystem::path& path) {
    Place place;
    for (auto part = path.begin(); part != path.end(); ++part) {
        place.bundle /= *part;
        std::error_code ignored;  // what cannot be asked for cannot be opened either
        if (!is_bundle(*part) || !std::filesystem::is_regular_file(place.bundle, ignored)) continue;
        for (++part; part != path.end(); ++part) place.inside /= *part;
        return place;
    }
    return {};
}

std::string unpacked(unzFile archive, const std::string& where) {
    unz_file_info64 info = {};
    if (unzGetCurrentFileInfo64(archive, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK ||
        unzOpenCurrentFile(archive) != UNZ_OK)
        throw bad_input(where, "cannot be unpacked; make the zip file again, without a password");
    if (info.uncompressed_size > most_bundled_bytes)
        throw bad_input(where, fmt::format("{} bytes are more than the {} that a file in a zip file may have; bring "
                                           "it unpacked",
                                           info.uncompressed_size, most_bundled_bytes));
    // One byte more than it should have, to see whether there is more than the bundle says.
    std::string content(static_cast<std::size_t>(info.uncompressed_size) + 1, '\0');
    std::size_t size = 0;
    for (int count = 1; count > 0 && size < content.size(); size += static_cast<std::size_t>(count)) {
        count = unzReadCurrentFile(archive, content.data() + size, static_cast<unsigned>(content.size() - size));
        if (count < 0) throw bad_input(where, "its packed bytes are damaged; make the zip file again");
    }
    if (size != info.uncompressed_size || unzCloseCurrentFile(archive) != UNZ_OK)
        throw bad_input(where, fmt::format("it has other bytes than the {} that the zip file says; make that again",
                                           info.uncompressed_size));
    content.resize(size);
    return content;
}

}  // namespace

std::optional<std::string> read_bundled(const std::filesystem::path& path) {
    const std::optional<Place> place = place_in_bundle(path);
    if (!place || place->inside.empty()) return {};
    const Archive archive(unzOpen64(place->bundle.c_str()));
    if (!archive)
        throw bad_input(place->bundle.string(),
                        "it is no bundle, or a damaged one; a bundle is a zip file with a project.toml and its files");
    constexpr int with_case = 1;
    if (unzLocateFile(archive.get(), place->inside.c_str(), with_case) != UNZ_OK)
        throw bad_input(path.string(), fmt::format("there is no '{}' in the bundle; a bundle has its project.toml at "
                                                   "the top, and all files that it names",
                                                   place->inside.string()));
    return unpacked(archive.get(), path.string());
}

std::optional<std::string> read_zipped(std::string_view zip, const std::string& inside, const std::string& where) {
    std::FILE* const file = std::tmpfile();  // which the archive closes
    if (file == nullptr || std::fwrite(zip.data(), 1, zip.size(), file) != zip.size() || std::fflush(file) != 0) {
        if (file != nullptr) std::fclose(file);
        throw bad_input(
            where, fmt::format("no room for {} bytes in the folder of temporary files; make room there", zip.size()));
    }
    std::rewind(file);
    zlib_filefunc64_def files{};
    fill_fopen64_filefunc(&files);
    files.opaque = file;
    files.zopen64_file = [](voidpf opened, const void*, int) { return opened; };
    const Archive archive(unzOpen2_64(where.c_str(), &files));
    if (!archive) throw bad_input(where, "it is no zip file, or a damaged one; export or download it again");
    constexpr int without_case = 2;
    if (unzLocateFile(archive.get(), inside.c_str(), without_case) != UNZ_OK) return {};
    return unpacked(archive.get(), where + "/" + inside);
}

}  // namespace haptogram
