// SPDX-License-Identifier: Apache-2.0
// What the sources use of zlib: its CRC-32, which is also Boost's.
#pragma once
#include <boost/crc.hpp>
#include <cstdlib>

inline unsigned long crc32(unsigned long before, const unsigned char* bytes, unsigned size) {
    if (before != 0) std::abort();  // nothing goes on with a sum
    boost::crc_32_type crc;
    if (bytes != nullptr) crc.process_bytes(bytes, size);
    return crc.checksum();
}
