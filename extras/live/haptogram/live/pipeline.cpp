// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/pipeline.hpp"

#include <pthread.h>

#include <algorithm>
#include <ctime>
#include <iterator>

namespace haptogram::live {
namespace {

constexpr double look_s = 0.5e-3;
constexpr std::chrono::hours long_wait{1};  // for what is told of when it comes

/// Of this thread.
double thread_processor_s() {
    std::timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Pipeline::Pipeline(FrameSource& source, Feeler& feeler, link::Clock& clock)
    : source_(source), feeler_(feeler), clock_(clock), rate_hz_(source.rate_hz()) {
    tracking_ = clock_.begin([this] { guarded([this] { track(); }); });
    computing_ = clock_.begin([this] { guarded([this] { compute(); }); });
}

Pipeline::~Pipeline() {
    {
        const std::lock_guard lock(mutex_);
        end_ = true;
    }
    changed_.notify_all();
    clock_.join(tracking_);
    clock_.join(computing_);
}

template <class Work>
void Pipeline::guarded(Work work) {
    try {
        work();
    } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!trouble_) trouble_ = std::current_exception();
        end_ = true;
    }
    changed_.notify_all();
}

bool Pipeline::wait_until(double time_s) {
    std::unique_lock lock(mutex_);
    clock_.wait_until(lock, changed_, link::Clock::time(time_s), [this] { return end_.load(); });
    return !end_;
}

void Pipeline::track() {
    std::optional<double> begin_s;
    while (!end_) {
        if (!source_.ready()) {
            clock_.rest_until_s(clock_.now_s() + look_s);
            continue;
        }
        std::optional<Frame> frame = source_.next();
        if (!frame) break;
        if (!source_.live()) {  // a recording's frame is due at its time
            if (!begin_s) begin_s = clock_.now_s() - frame->time_s;
            if (!wait_until(*begin_s + frame->time_s)) break;
        }
        frame->came_s = clock_.now_s();
        rate_hz_ = source_.rate_hz();
        {
            const std::lock_guard lock(mutex_);
            seen_ = std::move(frame);
        }
        changed_.notify_all();
    }
    const std::lock_guard lock(mutex_);
    tracked_ = true;
}

void Pipeline::compute() {
    for (;;) {
        Felt felt;
        {
            std::unique_lock lock(mutex_);
            if (!clock_.wait_for(lock, changed_, long_wait, [this] { return end_ || seen_ || tracked_; })) continue;
            if (end_ || !seen_) break;
            felt.frame = *std::exchange(seen_, std::nullopt);
        }
        felt.report.number = felt.frame.number;
        felt.report.time_s = felt.frame.time_s;
        const double began_s = thread_processor_s();
        felt.path = feeler_.feel(felt.frame, felt.report);
        felt.report.compute_s = thread_processor_s() - began_s;
        const std::lock_guard lock(mutex_);
        counts_ = feeler_.counts();
        std::ranges::move(felt.report.news, std::back_inserter(news_));
        felt_ = std::move(felt);
    }
    const std::lock_guard lock(mutex_);
    computed_ = true;
}

bool Pipeline::ready() {
    const std::lock_guard lock(mutex_);
    return felt_ || computed_ || trouble_;
}

std::optional<Frame> Pipeline::next() {
    while (!ready()) clock_.rest_until_s(clock_.now_s() + look_s);
    const std::lock_guard lock(mutex_);
    if (trouble_) std::rethrow_exception(trouble_);
    taken_ = std::exchange(felt_, std::nullopt);
    if (!taken_) return {};
    return std::move(taken_->frame);
}

std::optional<Path> Pipeline::feel(const Frame& /*frame*/, ShotReport& report) {
    // The loop's own troubles, of frames that were lost, come first.
    ShotReport felt = std::move(taken_->report);
    felt.troubles.insert(felt.troubles.begin(), report.troubles.begin(), report.troubles.end());
    report = std::move(felt);
    const std::lock_guard lock(mutex_);
    report.news = std::exchange(news_, {});
    return std::move(taken_->path);
}

ShotCounts Pipeline::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

}  // namespace haptogram::live
