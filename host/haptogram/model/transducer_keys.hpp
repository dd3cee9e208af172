// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/base/toml_section.hpp"
#include "haptogram/model/transducer.hpp"

namespace haptogram {

/// Puts a section's keys, which the transducer file and an array file's [transducer] share, over `transducer`.
void read_transducer_keys(Transducer& transducer, const section::Section& section);

}  // namespace haptogram
