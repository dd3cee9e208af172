// SPDX-License-Identifier: Apache-2.0
#include "ways_out.hpp"

#include <fmt/format.h>

#include <string>

#include "haptogram/format/board.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_ways = 4;

/// Of a number, with two digits.
double brief(double value) { return std::stod(fmt::format("{:.2g}", value)); }

class Search {
public:
    Search(const ordered_json& document, const std::function<bool(const ordered_json&)>& can_be_made)
        : document_(document), can_be_made_(can_be_made) {}

    std::vector<Remedy> run() {
        offer("Leave out what is out of reach", {{"clip", true}});
        offer("Put it over the array", {{"place", {{"center_mm", {0, 0, 130}}}}});
        for (const int size_mm : {100, 80, 60, 40, 20})
            if (offer(fmt::format("Make it {} mm large", size_mm), {{"place", {{"size_mm", size_mm}}}})) break;
        if (!found_.empty()) return found_;  // nothing else was wrong
        fewer_points();
        other_pace();
        for (const char* const am : {"square:200", "sine:200"})
            if (const std::string now = word("am", "");
                !now.empty() && now != am &&
                offer(fmt::format("Modulate by a {} of 200 Hz", am[1] == 'q' ? "square" : "sine"), {{"am", am}}))
                break;
        other_board();
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

    /// The most that can be made.
    void fewer_points() {
        const auto with = [](std::size_t points) { return ordered_json{{"points", points}}; };
        auto good = std::size_t{0},
             bad = static_cast<std::size_t>(number("points", static_cast<double>(Project{}.points)));
        if (bad > 1 && works(with(1))) good = 1;
        while (good > 0 && bad - good > 1 + good / 32) {
            const std::size_t middle = good + (bad - good) / 2;
            (works(with(middle)) ? good : bad) = middle;
        }
        if (good > 0) offer(fmt::format("Take {} point{}", good, good == 1 ? "" : "s"), with(good));
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
            for (double factor = 1.25; factor < 2000.0; factor *= 1.25)
                for (const double value : {brief(now / factor), brief(now * factor)})
                    if (offer(fmt::format(fmt::runtime(label), value), {{key, value}})) return;
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

std::vector<Remedy> ways_out(const ordered_json& document,
                             const std::function<bool(const ordered_json&)>& can_be_made) {
    return Search(document, can_be_made).run();
}

}  // namespace haptogram::studio
