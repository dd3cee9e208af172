// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "haptogram/link/clock.hpp"
#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// A source and a feeler in threads of their own, so that neither the computing nor the line to a board keeps the other
/// waiting. Between them the newest frame, and the newest path, wins. To the loop it is a source whose frames were
/// felt.
class Pipeline final : public FrameSource, public Feeler {
public:
    /// @param clock  of the machine, which all threads read
    Pipeline(FrameSource& source, Feeler& feeler, link::Clock& clock);
    ~Pipeline() override;

    [[nodiscard]] double rate_hz() const override { return rate_hz_; }
    [[nodiscard]] bool live() const override { return true; }
    [[nodiscard]] bool ready() override;
    /// @throws what a thread has thrown
    [[nodiscard]] std::optional<Frame> next() override;
    [[nodiscard]] std::optional<Path> feel(const Frame& frame, ShotReport& report) override;
    [[nodiscard]] ShotCounts counts() const override;

private:
    struct Felt {
        Frame frame;
        ShotReport report;
        std::optional<Path> path;
    };
    void track();
    void compute();
    bool wait_until(double time_s);
    template <class Work>
    void guarded(Work work);

    FrameSource& source_;
    Feeler& feeler_;
    link::Clock& clock_;
    std::atomic<double> rate_hz_;
    std::atomic<bool> end_ = false;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Frame> seen_;  ///< the newest that is not computed yet
    std::optional<Felt> felt_;   ///< the newest that the loop has not taken yet
    std::optional<Felt> taken_;  ///< the one that it has taken
    bool tracked_ = false;       ///< the source has ended
    bool computed_ = false;      ///< and all that came of it is computed
    std::exception_ptr trouble_;
    ShotCounts counts_;
    std::vector<std::string> news_;  ///< also of frames that a newer one has replaced
    std::thread tracking_, computing_;
};

}  // namespace haptogram::live
