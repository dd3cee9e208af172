// SPDX-License-Identifier: Apache-2.0
#include "computing.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "failure.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/verbs/patch.hpp"
#include "haptogram/verbs/report_page.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;

/// Work that ends early when nobody waits for it any more, and then has nothing to tell.
template <class Work>
void unless_cancelled(Work work) {
    try {
        work();
    } catch (const Error& error) {
        if (error.code() != ErrorCode::cancelled) throw;
    }
}

}  // namespace

Computing::Computing(Scenes& scenes, std::function<void(std::function<void()>)> post)
    : scenes_(scenes), post_(std::move(post)) {}

Progress Computing::going_while(Wanted wanted) const {
    return Progress([this, wanted = std::move(wanted)](double, std::string_view) { return !over_ && *wanted; });
}

bool Computing::write(const Request& request, const Reply& reply) {
    const ReportPicture draw = [](const Timeline& timeline, const Progress& going) {
        return report_picture(timeline, 1, going);
    };
    std::optional<Writing> writing = writing_of(scenes_, request, draw);
    if (writing) write(reply, *std::move(writing));
    return writing.has_value();
}

void Computing::bitstream(const Request& request, const Reply& reply, const std::filesystem::path& placed) {
    const auto scene = scenes_.find(query_value(request.query, "scene").value_or(""));
    const std::string autostart = query_value(request.query, "autostart").value_or("0");
    if (autostart != "0" && autostart != "1")
        throw bad_argument("autostart", fmt::format("found '{}', expected 0 or 1", autostart));
    if (!scene->settings.board)
        throw bad_argument("board", "the project names none; a bitstream is one board's, so choose one");
    write(reply, [scene, placed, autostart](const Progress& going) {
        const TemporaryFolder folder;
        const std::filesystem::path image = folder.path() / "image.hex";
        write_file(image, scene->compiled.bundle.hex);
        PatchOptions options{.board = scene->settings.beside(*scene->settings.board), .image = image.string()};
        options.autostart = autostart == "1";
        options.placed = placed;
        return patch(options, going).bitstream;
    });
}

void Computing::write(const Reply& reply, Writing writing) {
    // Owners differ, so that none is dropped for a newer one: each has a client who waits.
    files_.ask(++file_number_, [this, reply, writing = std::move(writing)] {
        const Progress going([this](double, std::string_view) { return !over_; });
        std::string content;
        const auto error = error_of([&] { content = writing(going); });
        reply(error ? error_answer(422, error->at("message"))
                    : Answer{.type = "application/octet-stream", .body = std::move(content)});
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const SceneMessage& message) {
    compilers_.ask(page->number(), [this, page, message] { answer(scenes_, *page, message); });
}

void Computing::ask(const std::shared_ptr<Page>& page, const HandMessage& message) {
    hands_.ask(page->number(), [this, page, message] { answer(scenes_, *page, message); });
}

void Computing::ask(const std::shared_ptr<Page>& page, const PathMessage& message) {
    Wanted& rendering = askers_[page->number()].rendering;
    *rendering = false;
    rendering = std::make_shared<std::atomic<bool>>(true);
    renderers_.ask(page->number(), [this, page, wanted = rendering, message] {
        if (*wanted) answer(scenes_, *page, message, going_while(wanted));
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const SliceMessage& message) {
    slice(page, message.view, [this, page, message] { answer(scenes_, *page, message); });
}

void Computing::ask(const std::shared_ptr<Page>& page, const ReachMessage& message) {
    slice(page, message.slice.view, [this, page, message] { answer(scenes_, *page, message); });
}

void Computing::ask(const std::shared_ptr<Page>& page, const SkinMessage& message) {
    slice(page, message.slice.view, [this, page, message] { answer(scenes_, *page, message); });
}

void Computing::slice(const std::shared_ptr<Page>& page, std::uint32_t view, std::function<void()> work) {
    slices_.ask(most_views * page->number() + view, std::move(work));
}

void Computing::ask(const std::shared_ptr<Page>& page, const DrivesMessage& message) {
    answer(scenes_, *page, message);
}

void Computing::ask(const std::shared_ptr<Page>& page, const AnalyzeMessage& message) {
    Wanted& analyzing = askers_[page->number()].analyzing;
    *analyzing = false;
    analyzing = std::make_shared<std::atomic<bool>>(true);
    analyses_.ask(page->number(), [this, page, wanted = analyzing, message] {
        if (*wanted) answer(scenes_, *page, message, going_while(wanted));
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const SimulateMessage& message) {
    Wanted& simulating = askers_[page->number()].simulating;
    *simulating = false;
    simulating = std::make_shared<std::atomic<bool>>(true);
    simulations_.ask(page->number(), [this, page, wanted = simulating, message] {
        tell_failure(*page, message.n, [&] {
            if (!*wanted) return;
            unless_cancelled([&] {
                const auto pins =
                    std::make_shared<const Pins>(simulate_pins(*scenes_.find(message.scene), going_while(wanted)));
                post_([this, n = message.n, page, pins] {
                    const auto asker = askers_.find(page->number());
                    if (asker == askers_.end()) return;
                    asker->second.pins = pins;
                    page->send(to_text({{"t", "pins"}, {"n", n}, {"report", pins->report}}));
                });
            });
        });
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const CancelMessage& message) {
    const Asker& asker = askers_[page->number()];
    *(message.what == CancelMessage::What::analyze ? asker.analyzing : asker.simulating) = false;
}

void Computing::ask(const std::shared_ptr<Page>& page, const PulsesMessage& message) {
    tell_failure(*page, message.n, [&] {
        const std::shared_ptr<const Pins> pins = askers_[page->number()].pins;
        if (!pins) throw bad_argument("pulses", "nothing was simulated yet; ask for that first");
        ordered_json answer{{"t", "pulses"}, {"n", message.n}};
        answer.update(pulses_json(*pins, message.index, message.periods));
        page->send(to_text(answer));
    });
}

void Computing::forget(const Page& page) {
    for (std::uint32_t view = 0; view < most_views; ++view) slices_.forget(most_views * page.number() + view);
    compilers_.forget(page.number());
    hands_.forget(page.number());
    renderers_.forget(page.number());
    analyses_.forget(page.number());
    simulations_.forget(page.number());
    const auto asker = askers_.find(page.number());
    if (asker == askers_.end()) return;
    *asker->second.analyzing = *asker->second.simulating = *asker->second.rendering = false;
    askers_.erase(asker);
}

}  // namespace haptogram::studio
