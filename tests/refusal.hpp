// SPDX-License-Identifier: Apache-2.0
// What is said to people is asserted by what it is: an error's code, its place and its remedies. The words stand in
// tests/messages.txt alone, which `make messages` writes: a changed wording fails no case, but the one that is called
// `messages`.
#pragma once
#include <exception>
#include <stdexcept>
#include <string>

#include "haptogram/base/error.hpp"

namespace heard {

/// An error's identity, which a case asserts, and its words, which it only tells.
struct Refusal {
    std::string identity, words;

    Refusal() : identity("no error") {}
    explicit Refusal(const haptogram::Error& error);
    /// Of something that is said without an error: a warning, an explanation.
    static Refusal notice(const std::string& words);
    /// Of the exception that is being handled.
    static Refusal caught();
};

/// What some work ends with.
template <class Work>
[[nodiscard]] Refusal refusal_of(Work work) {
    try {
        work();
    } catch (...) {
        return Refusal::caught();
    }
    return {};
}

/// Tells the words, and compares the identity with that in tests/messages.txt: the next one of the case that runs.
/// @return what is wrong; nothing when all is well, or when that file does not have the message yet
[[nodiscard]] std::string wrong_with(const Refusal& refusal);

/// The digits in the messages of the case that runs are left out from here on: they are other ones in another run.
void loose_numbers();

}  // namespace heard

// The expression throws an error. It may have commas.
#define CHECK_REFUSED(...) HAPTOGRAM_REFUSED(CHECK, __VA_ARGS__)
#define REQUIRE_REFUSED(...) HAPTOGRAM_REFUSED(REQUIRE, __VA_ARGS__)
// The same of an error that was caught: the argument is a Refusal.
#define CHECK_REFUSAL(...) CHECK(heard::wrong_with(__VA_ARGS__) == "")
#define REQUIRE_REFUSAL(...) REQUIRE(heard::wrong_with(__VA_ARGS__) == "")
// The argument is a text for people that is no error's.
#define CHECK_SAID(...) CHECK(heard::wrong_with(heard::Refusal::notice(__VA_ARGS__)) == "")
#define REQUIRE_SAID(...) REQUIRE(heard::wrong_with(heard::Refusal::notice(__VA_ARGS__)) == "")

// No lambda: the expression may have structured bindings, which Clang cannot capture.
#define HAPTOGRAM_REFUSED(assertion, ...)                      \
    do {                                                       \
        heard::Refusal haptogram_refusal;                      \
        try {                                                  \
            static_cast<void>(__VA_ARGS__);                    \
        } catch (...) {                                        \
            haptogram_refusal = heard::Refusal::caught();      \
        }                                                      \
        assertion(heard::wrong_with(haptogram_refusal) == ""); \
    } while (false)
