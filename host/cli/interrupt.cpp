// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <csignal>

namespace haptogram::cli {
namespace {

volatile std::sig_atomic_t asked = 0;

}  // namespace

void catch_interrupts() {
    const auto ask = [](int) { asked = 1; };
    std::signal(SIGINT, ask);
    std::signal(SIGTERM, ask);
}

bool interrupted() { return asked != 0; }

}  // namespace haptogram::cli
