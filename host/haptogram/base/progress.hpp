// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {

/// How long work tells how far it has come, and how its caller ends it early. Every function that takes one can be
/// called without it. The callback runs in the caller's own thread.
class Progress {
public:
    /// @param fraction  0…1, of the present stage
    /// @param stage     what is being done, such as "upload"; empty when there is only one stage
    /// @return false to end the work; it then throws Error{cancelled} and leaves nothing half-written
    using Callback = std::function<bool(double fraction, std::string_view stage)>;

    Progress() = default;
    template <class F>
    requires std::is_invocable_r_v<bool, F&, double, std::string_view> Progress(F callback)
        : callback_(std::move(callback)) {}

    /// @throws Error{cancelled} when the caller wants the work to end
    void operator()(double fraction, std::string_view stage = {}) const {
        if (callback_ && !callback_(fraction, stage)) throw Error(ErrorCode::cancelled, {}, "cancelled");
    }

    /// For work that is one stage of larger work: its progress is told under the name of that stage.
    [[nodiscard]] Progress in_stage(std::string_view stage) const {
        if (!callback_) return {};
        return Progress(
            [callback = callback_, stage](double fraction, std::string_view) { return callback(fraction, stage); });
    }

    /// For work that is a part of a stage: while it goes from 0 to 1, the stage goes from `from` to `to`.
    [[nodiscard]] Progress between(double from, double to) const {
        if (!callback_) return {};
        return Progress([callback = callback_, from, to](double fraction, std::string_view stage) {
            return callback(from + (to - from) * fraction, stage);
        });
    }

private:
    Callback callback_;
};

}  // namespace haptogram
