// SPDX-License-Identifier: Apache-2.0
#include "computing.hpp"

#include <fmt/format.h>

#include <chrono>
#include <string_view>
#include <utility>
#include <vector>

#include "failure.hpp"
#include "field_request.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/findings.hpp"
#include "haptogram/verbs/hand_project.hpp"
#include "haptogram/verbs/patch.hpp"
#include "haptogram/verbs/report_page.hpp"
#include "haptogram/verbs/slice.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

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

void Computing::field(const Request& request, const Reply& reply) {
    write(reply,
          [asked = field_request(request.query, scenes_)](const Progress& going) { return field_file(asked, going); });
}

void Computing::report(const Request& request, const Reply& reply) {
    write(reply, [scene = scenes_.find(query_value(request.query, "scene").value_or(""))](const Progress& going) {
        const Timeline timeline = timeline_of(scene->compiled.bundle);
        const ImageAnalysis analysis = analyze(timeline, least_felt_n, going.between(0.0, 0.5));
        std::vector<std::string> findings;
        for (const Finding& finding : findings_of(scene->settings, scene->compiled, analysis))
            findings.push_back(finding.message);
        return report_page(timeline, analysis, findings, report_picture(timeline, 1, going.between(0.5, 1.0)));
    });
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

void Computing::write(const Reply& reply, std::function<std::string(const Progress&)> content_of) {
    // Owners differ, so that none is dropped for a newer one: each has a client who waits.
    files_.ask(++file_number_, [this, reply, content_of = std::move(content_of)] {
        const Progress going([this](double, std::string_view) { return !over_; });
        std::string content;
        const auto error = error_of([&] { content = content_of(going); });
        reply(error ? error_answer(422, error->at("message"))
                    : Answer{.type = "application/octet-stream", .body = std::move(content)});
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const SceneMessage& message) {
    compilers_.ask(page->number(), [this, page, message] {
        tell_failure(*page, message.n, [&] {
            const Made made = scenes_.compile(message.document);
            page->send(to_text({{"t", "scene"}, {"n", message.n}, {"scene", to_json(*made.scene)}}));
            page->send(shape_bytes(message.n, made.shape));
        });
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const HandMessage& message) {
    hands_.ask(page->number(), [this, page, message] {
        tell_failure(*page, message.n, [&] {
            const HandScene scene = scenes_.hand(message.document);
            const HandView view = hand_view(scene.project, scene.instrument);
            ordered_json answer{{"t", "hand"},
                                {"n", message.n},
                                {"drawn", scene.object->name},
                                {"array", to_json(scene.instrument.array)}};
            answer.update(to_json(view));
            if (message.drawn != scene.object->name)
                page->send(touched_bytes(message.n, scene.object->surface, scene.object->touched->edges));
            page->send(hand_bytes(message.n, view));
            page->send(to_text(answer));
        });
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const PathMessage& message) {
    Wanted& rendering = askers_[page->number()].rendering;
    *rendering = false;
    rendering = std::make_shared<std::atomic<bool>>(true);
    renderers_.ask(page->number(), [this, page, wanted = rendering, message] {
        tell_failure(*page, message.n, [&] {
            if (!*wanted) return;
            unless_cancelled([&] {
                const HandScene scene = scenes_.hand(message.document);
                const Rendered rendered = render(scene.project, scene.instrument, going_while(wanted));
                ordered_json frames = ordered_json::array();
                for (const FrameReport& report : rendered.frames) frames.push_back(to_json(report));
                page->send(to_text({{"t", "path"},
                                    {"n", message.n},
                                    {"text", to_json_text(rendered.path, rendered.carrier_hz)},
                                    {"frames", frames},
                                    {"warnings", rendered.warnings}}));
            });
        });
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const SliceMessage& message) {
    slice(page, message, [message](const Scene& scene) -> Values {
        if (message.record == 0)
            return {mean_square_on(scene.excitation, message.slice), scene.excitation.drives.size()};
        return {mean_square_on(only(scene.excitation, message.record - 1), message.slice), 1};
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const ReachMessage& message) {
    slice(page, message.slice, [asked = message.slice.slice](const Scene& scene) -> Values {
        return {reachable_on(scene.excitation.array, asked), 1};
    });
}

void Computing::slice(const std::shared_ptr<Page>& page, const SliceMessage& message,
                      const std::function<Values(const Scene&)>& values_of) {
    slices_.ask(most_views * page->number() + message.view, [this, page, message, values_of] {
        tell_failure(*page, message.n, [&] {
            const auto scene = scenes_.find(message.scene);
            const Clock::time_point begun = Clock::now();
            const Values found = values_of(*scene);
            const double ms = std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
            page->send(slice_bytes(message, found.squares, scene->skin_per_square, ms, found.sets));
        });
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const DrivesMessage& message) {
    tell_failure(*page, message.n, [&] {
        ordered_json answer{{"t", "drives"}, {"n", message.n}};
        answer.update(drives_json(*scenes_.find(message.scene), message.record));
        page->send(to_text(answer));
    });
}

void Computing::ask(const std::shared_ptr<Page>& page, const AnalyzeMessage& message) {
    Wanted& analyzing = askers_[page->number()].analyzing;
    *analyzing = false;
    analyzing = std::make_shared<std::atomic<bool>>(true);
    analyses_.ask(page->number(), [this, page, wanted = analyzing, message] {
        tell_failure(*page, message.n, [&] {
            if (!*wanted) return;
            unless_cancelled([&] {
                const auto scene = scenes_.find(message.scene);
                const ImageAnalysis found =
                    analyze(timeline_of(scene->compiled.bundle), least_felt_n, going_while(wanted));
                ordered_json answer{{"t", "analysis"}, {"n", message.n}};
                answer.update(analysis_json(*scene, found));
                page->send(to_text(answer));
            });
        });
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
