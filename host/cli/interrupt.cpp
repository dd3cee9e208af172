// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <csignal>

namespace haptogram::cli {
namespace {

volatile std::sig_atomic_t asked = 0;

}  // namespace

void catch_interrupts() {
    struct sigaction act {};
    act.sa_handler = [](int) {
        if (asked < 2) asked = asked + 1;
    };
    // Without SA_RESTART, so that a question at the terminal ends, too.
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
        struct sigaction before {};
        sigaction(signal, nullptr, &before);
        const bool kept = signal == SIGHUP && before.sa_handler == SIG_IGN;  // by nohup
        if (!kept) sigaction(signal, &act, nullptr);
    }
}

unsigned interrupts() { return static_cast<unsigned>(asked); }

bool interrupted() { return asked != 0; }

}  // namespace haptogram::cli
