// SPDX-License-Identifier: Apache-2.0
#include "ways_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "haptogram/format/board.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_ways = 4;
constexpr std::size_t fewest_points = 5;  ///< that still are a shape

/// Of a number, with two digits.
double brief(double value) { return std::stod(fmt::format("{:.2g}", value)); }

class Search {
public:
    Search(const ordered_json& document, const std::function<bool(const ordered_json&)>& can_be_made)
        : document_(document), can_be_made_(can_be_made) {}

    std::vector<Remedy> run(const std::vector<std::string>& named) {
        if (of_reach()) return found_;  // nothing else was wrong
        const auto is_pace = [](const std::string& name) {
            return name == "rate" || name == "speed" || name == "frequency";
        };
        // A waveform and a movement take records by the pace, too.
        const bool paced = document_.contains("am") || document_.contains("keyframe");
        if (paced || named.empty() || std::ranges::any_of(named, is_pace)) other_pace();
        fewer_points();
        modulation();
        other_board();
        if (found_.empty()) few_points();
        if (found_.empty()) smaller();
        return found_;
    }

private:
    [[nodiscard]] bool works(const ordered_json& changes) const {
        ordered_json changed = document_;
        changed.merge_patch(changes);
        return can_be_made_(changed);
    }

    bool offer(const std::string& label, const ordered_json& changes) {
        if (found_.size() >= most_ways || !works(changes)) return false;
        found_.push_back({label, changes});
        return true;
    }

    [[nodiscard]] double number(const char* key, double otherwise) const {
        const auto found = document_.find(key);
        return found != document_.end() && found->is_number() ? found->get<double>() : otherwise;
    }

    [[nodiscard]] std::string word(const char* key, const char* otherwise) const {
        const auto found = document_.find(key);
        return found != document_.end() && found->is_string() ? found->get<std::string>() : otherwise;
    }

    /// Only what is out of reach is mended by where and how large it is.
    bool of_reach() {
        offer("Leave out what is out of reach", {{"clip", true}});
        offer("Put it over the array", {{"place", {{"center_mm", {0, 0, 130}}}}});
        if (!found_.empty()) smaller();
        return !found_.empty();
    }

    void smaller() {
        for (const int size_mm : {100, 80, 60, 40, 20})
            if (offer(fmt::format("Make it {} mm large", size_mm), {{"place", {{"size_mm", size_mm}}}})) return;
    }

    /// So few that they are hardly a shape any more: for when nothing else helps.
    void few_points() {
        for (std::size_t few = fewest_points; few-- > 1;)
            if (offer(fmt::format("Take {} point{}", few, few == 1 ? "" : "s"), {{"points", few}})) return;
    }

    /// The most that can be made and still are a shape.
    void fewer_points() {
        const auto with = [](std::size_t points) { return ordered_json{{"points", points}}; };
        const auto now = static_cast<std::size_t>(number("points", static_cast<double>(Project{}.points)));
        std::size_t good = 0, bad = now;
        for (std::size_t some = now; good == 0 && some > fewest_points;) {
            some = std::max(fewest_points, std::min(some - 1, some * 9 / 10));
            (works(with(some)) ? good : bad) = some;
        }
        while (good > 0 && bad - good > 1 + good / 32) {
            const std::size_t middle = good + (bad - good) / 2;
            (works(with(middle)) ? good : bad) = middle;
        }
        if (good > 0) offer(fmt::format("Take {} points", good), with(good));
    }

    void modulation() {
        for (const char* const am : {"square:200", "sine:200"})
            if (const std::string now = word("am", "");
                !now.empty() && now != am &&
                offer(fmt::format("Modulate by a {} of 200 Hz", am[1] == 'q' ? "square" : "sine"), {{"am", am}}))
                return;
    }

    /// The nearest of whatever says how fast it is played.
    void other_pace() {
        struct Pace {
            const char *key, *label;
        };
        constexpr Pace paces[] = {{"speed_m_s", "Draw it at {:g} m/s"},
                                  {"frequency_hz", "Draw it {:g} times a second"},
                                  {"rate_hz", "Make {:g} passes a second"}};
        for (const auto& [key, label] : paces) {
            if (!document_.contains(key) && std::string(key) != "rate_hz") continue;
            const double now = number(key, Project{}.rate_hz);
            if (!(now > 0.0)) return;
            std::vector<double> values{1,  2,  2.5, 4,  5,   8,  10,
                                       20, 25, 40,  50, 100, 200};  // of these a waveform is a multiple
            for (double factor = 1.25; factor < 2000.0; factor *= 1.25)
                values.insert(values.end(), {brief(now / factor), brief(now * factor)});
            std::ranges::stable_sort(values, {}, [now](double value) { return std::abs(std::log(value / now)); });
            for (const double value : values)
                if (value != now && offer(fmt::format(fmt::runtime(label), value), {{key, value}})) return;
            return;
        }
    }

    /// Of the same array: another board may hold more.
    void other_board() {
        const std::string array = word("array", "tile-10x10");
        for (const std::string& name : shipped_boards())
            if (word("board", "") != name && load_board(name).array == array &&
                offer(fmt::format("Make it for the board {}", name), {{"board", name}, {"array", array}}))
                return;
    }

    const ordered_json& document_;
    const std::function<bool(const ordered_json&)>& can_be_made_;
    std::vector<Remedy> found_;
};

}  // namespace

std::vector<Remedy> ways_out(const ordered_json& document, const std::function<bool(const ordered_json&)>& can_be_made,
                             const std::vector<std::string>& named) {
    return Search(document, can_be_made).run(named);
}

}  // namespace haptogram::studio
