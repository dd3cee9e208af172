// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/trigger_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/live_scene.hpp"

namespace haptogram {
namespace {

/// Whether any joint or palm of a scene's hands is in a ball.
bool has_entered(const nlohmann::json& hands, const Trigger& trigger) {
    const auto inside = [&](const nlohmann::json& place) {
        const Vec3 at = from_mm(place.at(0).get<double>(), place.at(1).get<double>(), place.at(2).get<double>());
        return norm(at - trigger.centre) <= trigger.diameter_m / 2;
    };
    return std::ranges::any_of(hands, [&](const nlohmann::json& hand) {
        return inside(hand.at("palm_mm")) ||
               std::ranges::any_of(hand.at("fingers_mm"),
                                   [&](const nlohmann::json& joints) { return std::ranges::any_of(joints, inside); });
    });
}

}  // namespace

std::vector<std::size_t> TriggerLines::fired(std::string_view line, const std::string& where) {
    std::vector<std::size_t> numbers;
    require_shallow(line, where);
    if (line.starts_with('{')) try {
            const nlohmann::json scene = nlohmann::json::parse(line);
            const nlohmann::json& version = scene.at("scene");
            if (!version.is_number_integer() || version < oldest_scene_version || version > scene_version)
                throw bad_input(where, fmt::format("found a scene of version {}, expected {} to {}", version.dump(),
                                                   oldest_scene_version, scene_version));
            for (std::size_t i = 0; i < triggers_.size(); ++i) {
                if (triggers_[i].on != Trigger::On::region) continue;
                const bool before = inside_[i];
                inside_[i] = has_entered(scene.at("hands"), triggers_[i]);
                if (inside_[i] && !before) numbers.push_back(i);
            }
            return numbers;
        } catch (const nlohmann::json::exception& error) {
            throw bad_input(where, fmt::format("no scene of a live session: {}", error.what()));
        }
    for (std::size_t i = 0; i < triggers_.size(); ++i)
        if (!triggers_[i].word.empty() && triggers_[i].word == line) numbers.push_back(i);
    if (!numbers.empty()) return numbers;
    std::string words;
    for (const Trigger& trigger : triggers_)
        if (!trigger.word.empty()) words += (words.empty() ? "'" : "', '") + trigger.word;
    throw bad_input(where, fmt::format("found '{}', expected {}{}a scene of a live session", line.substr(0, 40), words,
                                       words.empty() ? "" : "' or "));
}

TriggerReader::TriggerReader(std::vector<Trigger> triggers, std::optional<LiveText> lines, Told told,
                             link::Clock& clock)
    : triggers_(std::move(triggers)),
      fired_by_(triggers_),
      text_(std::move(lines)),
      told_(std::move(told)),
      clock_(clock) {}

std::optional<std::size_t> TriggerReader::next(std::chrono::milliseconds patience) {
    constexpr std::chrono::milliseconds look{1};
    const link::Clock::Time until = clock_.now() + patience;
    while (fired_.empty()) {
        const auto line = ended() ? std::nullopt : text_->next(std::chrono::milliseconds(0));
        if (line) try {
                for (const std::size_t number : fired_by_.fired(*line, text_->where())) fired_.push_back(number);
            } catch (const Error& error) {
                told_(error.what());
            }
        const link::Clock::Time now = clock_.now();
        if (now >= until) break;
        if (!line) clock_.rest_until(ended() ? until : std::min<link::Clock::Time>(until, now + look));
    }
    if (fired_.empty()) return {};
    const std::size_t first = fired_.front();
    fired_.pop_front();
    return first;
}

bool TriggerReader::ended() const { return fired_.empty() && (!text_ || text_->ended()); }

}  // namespace haptogram
