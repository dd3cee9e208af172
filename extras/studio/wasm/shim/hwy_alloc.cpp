// SPDX-License-Identifier: Apache-2.0
// Highway's memory, which its compiled library has elsewhere.
#include <hwy/aligned_allocator.h>

#include <cstdlib>

namespace hwy {
void* AllocateAlignedBytes(std::size_t bytes, AllocPtr, void*) {
    return std::aligned_alloc(64, (bytes + 63) / 64 * 64);
}
void FreeAlignedBytes(const void* memory, FreePtr, void*) { std::free(const_cast<void*>(memory)); }
void AlignedDeleter::DeleteAlignedArray(void* memory, FreePtr, void*, ArrayDeleter deleter) {
    if (memory == nullptr) return;
    deleter(memory, 1);
    std::free(memory);
}
}  // namespace hwy
