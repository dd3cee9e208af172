// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {

/// How long work says how far it has come, and how its caller ends it early. Every function that takes one may be
/// called without; all of them tell it from the caller's own thread.
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

    /// The same work as one stage of larger work.
    [[nodiscard]] Progress in_stage(std::string_view stage) const {
        if (!callback_) return {};
        return Progress(
            [callback = callback_, stage](double fraction, std::string_view) { return callback(fraction, stage); });
    }

    /// The same work as a part of its stage, which it brings from one fraction to another.
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
