// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "haptogram/base/error.hpp"

/// What an error says that some work ends with; "no error" when it does not.
template <class Work>
std::string message_of(Work work) {
    try {
        work();
    } catch (const haptogram::Error& error) {
        return error.what();
    }
    return "no error";
}
