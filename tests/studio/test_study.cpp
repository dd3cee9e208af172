// SPDX-License-Identifier: Apache-2.0
// The way between a page and the runner of studies, by shell scripts in the runner's place; study.test.mjs has the
// runner itself.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "../real_time.hpp"
#include "guest.hpp"
#include "study.hpp"

using namespace haptogram::studio;
using nlohmann::ordered_json;
using std::chrono::seconds;

namespace {

/// What a study tells, for another thread to wait for.
class Heard {
public:
    [[nodiscard]] Guest::Settings settings() {
        return {.shown = [this](ordered_json shown) { put(std::move(shown)); },
                .ended =
                    [this](std::optional<int> code) {
                        put({{"show", "ended"}, {"code", code ? ordered_json(*code) : ordered_json()}});
                    }};
    }
    ordered_json next() {
        std::unique_lock lock(mutex_);
        REQUIRE(changed_.wait_for(lock, seconds(20), [this] { return taken_ < told_.size(); }));
        return told_[taken_++];
    }

private:
    void put(ordered_json shown) {
        {
            const std::lock_guard lock(mutex_);
            told_.push_back(std::move(shown));
        }
        changed_.notify_all();
    }
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<ordered_json> told_;
    std::size_t taken_ = 0;
};

Child::Command shell(const std::string& script) { return {{"/bin/sh", "-c", script}, "/", {"STUDY=one"}}; }

}  // namespace

TEST_CASE("studio study: lines come as they are, words as notes, and the exit code at the end") {
    Heard heard;
    Guest study(shell(R"(echo '{"show":"tell","text":"a"}'; echo "haptogram-study: $STUDY in $PWD" >&2
                         echo '{"no":1}'; printf 'half'; exit 3)"),
                heard.settings());
    CHECK(heard.next() == ordered_json{{"show", "tell"}, {"text", "a"}});
    CHECK(heard.next() == ordered_json{{"show", "note"}, {"text", "one in /"}});
    CHECK(heard.next() == ordered_json{{"show", "note"}, {"text", R"({"no":1})"}});
    CHECK(heard.next() == ordered_json{{"show", "note"}, {"text", "half"}});
    CHECK(heard.next() == ordered_json{{"show", "ended"}, {"code", 3}});
}

TEST_CASE("studio study: answers arrive as lines of JSON") {
    Heard heard;
    Guest study(shell("echo; while read -r line; do printf '%s\\n' \"$line\"; done"), heard.settings());
    CHECK(heard.next()["text"].get<std::string>().empty());
    study.answer(7, "soft\n\"and\" ü");
    CHECK(ordered_json::parse(heard.next()["text"].get<std::string>()) ==
          ordered_json{{"do", "answer"}, {"number", 7}, {"text", "soft\n\"and\" ü"}});
    study.leave();
    CHECK(ordered_json::parse(heard.next()["text"].get<std::string>()) == ordered_json{{"do", "stop"}});
}

TEST_CASE("studio study: end() is heard at once") {
    Heard heard;
    {
        Guest study(shell("exec 2>/dev/null; trap 'echo ending; exit 1' TERM; echo; while :; do sleep 0.05; done"),
                    heard.settings());
        CHECK(heard.next()["text"].get<std::string>().empty());
        study.end();
        CHECK(heard.next()["text"] == "ending");
        CHECK(heard.next()["code"] == 1);
        study.answer(1, "too late");  // does no harm
        study.end();
    }
}

TEST_CASE("studio study: what does not listen is killed when its time is over", "[real-time]") {
    Heard heard;
    const haptogram::test::StopWatch watch;
    {
        Guest deaf(shell("exec 2>/dev/null; trap '' TERM; echo; sleep 60 & wait; sleep 60"), heard.settings());
        CHECK(heard.next()["text"].get<std::string>().empty());
    }
    CHECK(heard.next()["code"].is_null());
    const std::chrono::duration<double> most = Guest::most_ending;
    haptogram::test::compare("a study that does not listen to its end is killed", watch.seconds(), most.count() + 1.0,
                             "s");
}

TEST_CASE("studio study: a program that is not there ends with a code") {
    Heard heard;
    const Guest study({{"/nowhere/python3"}, {}, {}}, heard.settings());
    CHECK(heard.next() == ordered_json{{"show", "ended"}, {"code", 127}});
}

TEST_CASE("studio study: the runner's command has the page's names as words of their own") {
    const StudyMessage asked{1, "small.toml", 3, 7, "out.jsonl", ""};
    const std::vector<std::string> words = study_command(asked, "/folder", {}).words;
    const std::vector<std::string> expected = {"run", "small.toml", "--participant", "3",          "--seed",
                                               "7",   "--output",   "out.jsonl",     "--observer", "page"};
    REQUIRE(words.size() == 4 + expected.size());
    CHECK(std::vector<std::string>(words.begin() + 4, words.end()) == expected);
    const std::vector<std::string> playing = study_command(asked, "/folder", BoardPort{"-port", 115200}).words;
    CHECK(std::find(playing.begin(), playing.end(), "--port=-port") != playing.end());
    CHECK(std::find(playing.begin(), playing.end(), "115200") != playing.end());
}
