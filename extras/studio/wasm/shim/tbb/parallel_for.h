// SPDX-License-Identifier: Apache-2.0
#pragma once
namespace tbb {
template <class Index, class Work>
void parallel_for(Index begin, Index end, const Work& work) {
    for (Index i = begin; i < end; ++i) work(i);
}
}  // namespace tbb
