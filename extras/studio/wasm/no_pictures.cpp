// SPDX-License-Identifier: Apache-2.0
// In the place of base/picture.cpp: no Python draws in a browser.
#include "haptogram/base/error.hpp"
#include "haptogram/base/picture.hpp"

namespace haptogram {

Picture::Picture(const std::string&) {
    throw Error(ErrorCode::failed, "picture",
                "pictures are drawn by Python, which a page without a program does not have; take another kind of file "
                "here, or start 'haptogram studio'");
}

void Picture::add(const std::string&, std::string_view) {}
void Picture::draw(const std::string&, const std::string&) const {}

}  // namespace haptogram
