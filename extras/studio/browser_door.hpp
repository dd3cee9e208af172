// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace haptogram::studio {

/// Opens an address in the user's browser, by a file that only the user can read: the token is in no list of processes.
class BrowserDoor {
public:
    /// Does nothing when there is no display or no xdg-open.
    explicit BrowserDoor(const std::string& address);
    BrowserDoor(const BrowserDoor&) = delete;
    BrowserDoor& operator=(const BrowserDoor&) = delete;
    ~BrowserDoor();

private:
    std::filesystem::path file_;
};

}  // namespace haptogram::studio
