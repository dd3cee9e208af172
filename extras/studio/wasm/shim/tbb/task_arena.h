// SPDX-License-Identifier: Apache-2.0
#pragma once
namespace tbb {
struct task_arena {
    explicit task_arena(int) {}
    template <class Work>
    void execute(const Work& work) {
        work();
    }
};
namespace this_task_arena {
inline int current_thread_index() { return 0; }
}  // namespace this_task_arena
}  // namespace tbb
