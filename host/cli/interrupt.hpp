// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram::cli {

/// From now on Ctrl-C and SIGTERM ask to end instead of ending at once.
void catch_interrupts();
/// Whether they have asked.
[[nodiscard]] bool interrupted();

}  // namespace haptogram::cli
