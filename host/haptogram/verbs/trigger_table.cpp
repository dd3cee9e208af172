// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/trigger_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/base/toml_value.hpp"

namespace haptogram {
namespace {

using section::assign;
using section::number_text;
using section::Section;

constexpr std::string_view key_prefix = "key:", line_prefix = "line:";

bool is_word(std::string_view word) {
    return !word.empty() && word.front() != '{' && word.front() != ' ' && word.back() != ' ' &&
           std::ranges::all_of(word, [](char c) { return c >= ' ' && c <= '~'; });
}

bool is_on(const std::string& text) {
    if (text.starts_with(key_prefix))
        return text.size() == key_prefix.size() + 1 && is_word(text.substr(key_prefix.size()));
    if (text.starts_with(line_prefix)) return is_word(text.substr(line_prefix.size()));
    return text == "pin" || text == "region";
}

Trigger read_trigger(const std::string& file, const toml::table& table) {
    const Section section(file, table);
    section.only({"on", "center_mm", "size_mm", "from_s", "to_s", "loops"});
    constexpr const char* expected = "\"pin\", \"region\", \"key:\" and a character, or \"line:\" and a word";
    const std::optional<std::string> given = section.text("on", expected, is_on);
    if (!given) throw bad_input(section::place(file, table), fmt::format("a [[trigger]] has 'on': {}", expected));
    const std::string& on = *given;
    Trigger trigger;
    if (on.starts_with(key_prefix)) {
        trigger.on = Trigger::On::key;
        trigger.word = on.substr(key_prefix.size());
    } else if (on.starts_with(line_prefix)) {
        trigger.on = Trigger::On::line;
        trigger.word = on.substr(line_prefix.size());
    } else if (on == "region") {
        trigger.on = Trigger::On::region;
    }
    const auto centre = section.numbers("center_mm", 3);
    const auto size = section.number("size_mm", 1e-3, 1e6);
    if ((centre || size) != (trigger.on == Trigger::On::region) || centre.has_value() != size.has_value())
        throw bad_input(section::place(file, table),
                        "center_mm and size_mm are those of a region, a ball, which needs both; others have neither");
    if (centre) trigger.centre = from_mm((*centre)[0], (*centre)[1], (*centre)[2]);
    if (size) trigger.diameter_m = *size * millimetre;
    assign(trigger.from_s, section.number("from_s", 0.0, 1e6));
    trigger.to_s = section.number("to_s", 0.0, 1e6);
    if (trigger.to_s && *trigger.to_s <= trigger.from_s)
        throw section.wrong(*section.find("to_s"), "to_s", fmt::format("more than from_s, {:g}", trigger.from_s));
    if (const auto loops = section.whole("loops", 0, 65535)) trigger.loops = static_cast<std::uint16_t>(*loops);
    return trigger;
}

/// What a line says to fire it.
bool are_same(const Trigger& a, const Trigger& b) {
    return a.word == b.word && (!a.word.empty() || (a.on == b.on && a.on == Trigger::On::pin));
}

}  // namespace

std::string name_of(const Trigger& trigger) {
    switch (trigger.on) {
        case Trigger::On::key: return std::string(key_prefix) + trigger.word;
        case Trigger::On::line: return std::string(line_prefix) + trigger.word;
        case Trigger::On::region: return "region";
        case Trigger::On::pin: break;
    }
    return "pin";
}

std::vector<Trigger> triggers_from_toml(std::string_view text, const std::string& where) {
    const toml::table root = section::parse_text(text, where);
    std::vector<Trigger> triggers;
    const toml::node* tables = root.get("trigger");
    if (tables == nullptr) return triggers;
    const toml::array* list = tables->as_array();
    if (list == nullptr || !list->is_array_of_tables())
        throw bad_input(section::place(where, *tables), "triggers are tables of their own, each under [[trigger]]");
    for (const toml::node& table : *list) {
        Trigger trigger = read_trigger(where, *table.as_table());
        if (std::ranges::any_of(triggers, [&](const Trigger& other) { return are_same(trigger, other); }))
            throw bad_input(
                section::place(where, table),
                trigger.word.empty()
                    ? std::string("a second trigger of the pin; a board has one")
                    : fmt::format("a second trigger on '{}'; a key and a line are told apart by their words",
                                  trigger.word));
        triggers.push_back(std::move(trigger));
    }
    return triggers;
}

std::string to_toml(std::span<const Trigger> triggers) {
    std::string text;
    const auto in_mm = [](double metres) { return number_text(exact_mm(metres)); };
    for (const Trigger& trigger : triggers) {
        text += fmt::format("\n[[trigger]]\non = {}\n", section::quoted_text(name_of(trigger)));
        if (trigger.on == Trigger::On::region)
            text += fmt::format("center_mm = [{}, {}, {}]\nsize_mm = {}\n", in_mm(trigger.centre.x),
                                in_mm(trigger.centre.y), in_mm(trigger.centre.z), in_mm(trigger.diameter_m));
        if (trigger.from_s != 0.0) text += fmt::format("from_s = {}\n", number_text(trigger.from_s));
        if (trigger.to_s) text += fmt::format("to_s = {}\n", number_text(*trigger.to_s));
        if (trigger.loops != 1) text += fmt::format("loops = {}\n", trigger.loops);
    }
    return text;
}

std::vector<TriggeredPart> parts_of(std::span<const Trigger> triggers, std::span<const SequenceEntry> sequence,
                                    double carrier_hz) {
    std::vector<double> begins{0.0};  // of entries, and of what is behind the last, in carrier periods
    for (const SequenceEntry& entry : sequence) begins.push_back(begins.back() + entry.dwell);
    const double all = begins.back();
    const auto entry_at = [&](double periods) {  // that begins then or is the next to begin
        return static_cast<std::size_t>(std::lower_bound(begins.begin(), begins.end(), periods - 0.5) - begins.begin());
    };
    std::vector<TriggeredPart> parts;
    for (std::size_t i = 0; i < triggers.size(); ++i) {
        const Trigger& trigger = triggers[i];
        const double from = trigger.from_s * carrier_hz, to = trigger.to_s ? *trigger.to_s * carrier_hz : all;
        if (from >= all || to > all + 0.5)
            throw bad_input("trigger",
                            fmt::format("number {}, {}, plays from {:g} to {:g} s, and a pass lasts {:g} s", i + 1,
                                        name_of(trigger), trigger.from_s, to / carrier_hz, all / carrier_hz));
        const std::size_t first = entry_at(from), end = entry_at(to);
        if (first >= end)
            throw bad_input("trigger",
                            fmt::format("number {}, {}, plays from {:g} to {:g} s, in which no focal point begins; "
                                        "give it longer",
                                        i + 1, name_of(trigger), trigger.from_s, to / carrier_hz));
        parts.push_back({static_cast<std::uint16_t>(first + 1), static_cast<std::uint16_t>(end - first), trigger.loops,
                         trigger.on == Trigger::On::pin});
    }
    return parts;
}

void require_pin(std::span<const Trigger> triggers, const Core& core) {
    if (core.parameters.trigger == 0 &&
        std::ranges::any_of(triggers, [](const Trigger& trigger) { return trigger.on == Trigger::On::pin; }))
        throw bad_input("trigger", fmt::format("a pin starts what is played, and {} has none; take a board with the "
                                               "parameter TRIGGER, or a key",
                                               core.name));
}

}  // namespace haptogram
