// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cctype>
#include <string>

#include "haptogram/base/toml_section.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram {

/// Board files write the names of parameters in upper case, as the Verilog does. Array files write them in lower case,
/// like all their keys.
enum class KeyStyle { verilog, lower_case };

/// Stores those of the core's parameters that a section has in `parameters`, and checks the whole set.
/// @throws Error{bad_input} naming the line, for a value that the Verilog would not take
void read_parameters(interface::CoreParameters& parameters, const section::Section& section, KeyStyle style);

}  // namespace haptogram
