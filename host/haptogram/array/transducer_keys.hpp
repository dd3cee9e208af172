// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/array/transducer.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram {

/// Reads the keys that a transducer file shares with the table [transducer] of an array file, and stores their values
/// in `transducer`. Members without a key keep their values.
void read_transducer_keys(Transducer& transducer, const section::Section& section);

}  // namespace haptogram
