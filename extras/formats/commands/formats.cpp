// SPDX-License-Identifier: Apache-2.0
#include "extras.hpp"
#include "haptogram/formats/readers.hpp"

namespace haptogram::cli {

void register_formats(Extras& extras) { extras.makers.readers = formats::readers(); }

}  // namespace haptogram::cli
