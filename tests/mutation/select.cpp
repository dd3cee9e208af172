// SPDX-License-Identifier: Apache-2.0
// Which mutant is active in this process: asked once by the package that netlist.py writes.
#include <cstdlib>

extern "C" int haptogram_mutant();
extern "C" int haptogram_mutant() {
    const char* number = std::getenv("HAPTOGRAM_MUTANT");
    return number == nullptr ? 0 : std::atoi(number);
}
