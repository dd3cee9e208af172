// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

/// The folder tests/data. One source knows where it is, so that all others compile alike in every checkout.
[[nodiscard]] std::string test_data();
