// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

#include "haptogram/base/process.hpp"

namespace haptogram {

/// A picture that a script draws: python3 SCRIPT FOLDER PICTURE, where the folder holds what it needs.
class Picture {
public:
    /// @param script  as read_file() takes it
    explicit Picture(const std::string& script);
    void add(const std::string& name, std::string_view content);
    /// @param others  the endings of files that need no Python, for the message
    /// @throws Error{bad_input} when it cannot be drawn, or not be written to `path`
    void draw(const std::string& path, const std::string& others) const;

private:
    TemporaryFolder folder_;
};

}  // namespace haptogram
