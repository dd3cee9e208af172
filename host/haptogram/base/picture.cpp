// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/picture.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram {

Picture::Picture(const std::string& script) { add("draw.py", read_file(script)); }

void Picture::add(const std::string& name, std::string_view content) { write_file(folder_.path() / name, content); }

void Picture::draw(const std::string& path, const std::string& others) const {
    StagedFile staged(path);
    const std::string target = staged.beside().empty() ? path : staged.beside().string();
    const auto drawn = [&] {
        try {
            return run_process(
                std::filesystem::current_path(),
                {python_program(), (folder_.path() / "draw.py").string(), folder_.path().string(), target});
        } catch (const Error& error) {
            return ProcessResult{false, error.what()};
        }
    }();
    if (!drawn.succeeded) {
        // Of a Python traceback the last line says what happened.
        std::string_view why = drawn.said;
        while (why.ends_with('\n')) why.remove_suffix(1);
        why.remove_prefix(why.rfind('\n') + 1);
        throw bad_input(path,
                        fmt::format("the picture could not be drawn{}{}; it needs python3 with matplotlib "
                                    "(HAPTOGRAM_PYTHON names another one), and room for the file; {} need neither",
                                    why.empty() ? "" : ": ", why, others));
    }
    staged.commit();
}

}  // namespace haptogram
