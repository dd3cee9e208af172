// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cctype>
#include <string>

#include "haptogram/base/toml_section.hpp"
#include "haptogram/boards/interface.hpp"

namespace haptogram {

/// Board files write the parameters as the Verilog does, array files as everything else in them.
enum class KeyStyle { verilog, lower_case };

/// Puts those of the core's parameters that a section has over `parameters`, and checks the whole set.
/// @throws Error{bad_input} naming the line, for a value that the Verilog would not take
void read_parameters(interface::CoreParameters& parameters, const section::Section& section, KeyStyle style);

}  // namespace haptogram
