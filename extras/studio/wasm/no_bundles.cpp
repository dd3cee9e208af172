// SPDX-License-Identifier: Apache-2.0
// In the place of base/unzip.cpp: the page unpacks bundles itself.
#include "haptogram/base/bundle.hpp"

namespace haptogram {

std::optional<std::string> read_bundled(const std::filesystem::path&) { return {}; }

}  // namespace haptogram
