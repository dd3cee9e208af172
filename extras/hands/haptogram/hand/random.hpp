// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <initializer_list>

namespace haptogram {

/// Random numbers from a key of whole numbers, the same on every machine: splitmix64 (Steele, Lea and Flood 2014).
class KeyedRandom {
public:
    KeyedRandom(std::initializer_list<std::int64_t> key) {
        for (const std::int64_t part : key) {
            state_ ^= static_cast<std::uint64_t>(part);
            state_ = next();
        }
    }

    /// In [low, high).
    double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(next() >> 11U) * 0x1p-53;
    }

private:
    std::uint64_t next() {
        std::uint64_t mixed = state_ += 0x9e3779b97f4a7c15U;
        mixed = (mixed ^ (mixed >> 30U)) * 0xbf58476d1ce4e5b9U;
        mixed = (mixed ^ (mixed >> 27U)) * 0x94d049bb133111ebU;
        return mixed ^ (mixed >> 31U);
    }

    std::uint64_t state_ = 0;
};

}  // namespace haptogram
