// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram::cli {

/// From now on Ctrl-C, SIGTERM, SIGQUIT, and the terminal's closing ask to end instead of ending at once.
void catch_interrupts();
/// How often they have asked, up to twice.
[[nodiscard]] unsigned interrupts();
[[nodiscard]] bool interrupted();

}  // namespace haptogram::cli
