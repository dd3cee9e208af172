// SPDX-License-Identifier: Apache-2.0
#include "answers.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "failure.hpp"
#include "field_request.hpp"
#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/hand/touch.hpp"
#include "haptogram/perception/feel.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/document.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/report_page.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;

constexpr std::chrono::seconds most_trying{2};  ///< of ways to mend a design, while the next one waits

/// Work whose failure is told, unless it was cancelled: then nobody waits for it any more.
template <class Work>
void tell_unless_cancelled(Recipient& page, std::uint32_t n, Work work) {
    tell_failure(page, n, [&] {
        try {
            work();
        } catch (const Error& error) {
            if (error.code() != ErrorCode::cancelled) throw;
        }
    });
}

struct Values {
    std::vector<float> squares;  ///< as mean_square_on() gives them
    std::size_t sets = 0;        ///< of drives
};

/// The field of what plays of a scene: its sequence, or the record that a message names.
template <class FieldOf>
Values field_of(const Scene& scene, const SliceMessage& message, FieldOf field_of_one) {
    if (message.record == 0) return {field_of_one(scene.excitation), scene.excitation.drives.size()};
    return {field_of_one(only(scene.excitation, message.record - 1)), 1};
}

template <class ValuesOf>
void answer_slice(Scenes& scenes, Recipient& page, const SliceMessage& message, ValuesOf values_of) {
    tell_failure(page, message.n, [&] {
        using Clock = std::chrono::steady_clock;
        const auto scene = scenes.find(message.scene);
        const Clock::time_point begun = Clock::now();
        const Values found = values_of(*scene);
        const double ms = std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
        page.send(slice_bytes(message, found.squares, scene->skin_per_square, ms, found.sets));
    });
}

/// A project file's text as a document, for a page that opens one; or a pattern's, whose key frames become a project's.
Answer document_answer(const Scenes& scenes, const std::string& given) {
    const std::string text = is_adaptics(given) ? to_toml(project_from_adaptics(given, "pattern")) : given;
    const Project project = project_from_toml(text, "project.toml");
    return {.body =
                to_text({{"document", document_of(text, "project.toml")}, {"files", scenes.needed_files(project)}})};
}

/// A document as a project file's text, for a page that saves one.
Answer project_answer(const Scenes& scenes, const std::string& body) {
    require_shallow(body, "document");
    const ordered_json document = ordered_json::parse(body, nullptr, false);
    if (document.is_discarded()) throw bad_input("document", "it is no JSON; send the document as the page has it");
    const Project project = project_from_toml(toml_of(document), "project");
    return {.body = to_text({{"text", to_toml(project)}, {"files", scenes.needed_files(project)}})};
}

Answer files_answer(Scenes& scenes, Request request) {
    const std::optional<std::string> name = query_value(request.query, "name");
    if (!name) return error_answer(400, "a file has a name: /api/files?name=NAME");
    if (request.method != "POST") return {.type = "application/octet-stream", .body = scenes.file(*name)};
    scenes.add_file(*name, std::move(request.body));
    return {.body = to_text({{"name", *name}})};
}

std::shared_ptr<const Scene> scene_of(Scenes& scenes, const Request& request) {
    return scenes.find(query_value(request.query, "scene").value_or(""));
}

/// The files that a scene is taken away as.
Answer take_answer(Scenes& scenes, const Request& request) {
    const auto scene = scene_of(scenes, request);
    const Bundle& bundle = scene->compiled.bundle;
    const std::string as = query_value(request.query, "as").value_or("");
    if (as == "manifest") return {.body = to_text(bundle.manifest)};
    const auto text = [](std::string body) -> Answer {
        return {.type = "text/plain; charset=utf-8", .body = std::move(body)};
    };
    if (as == "hex") return text(bundle.hex);
    if (as == "project") return text(scene->project);
    if (as == "primary") return text(primary_readmemh(bundle.image));
    if (as == "sequence") return text(sequence_readmemh(bundle.image));
    if (as == "methods") return text(methods_text(timeline_of(bundle)));
    return error_answer(400, fmt::format("as '{}'; expected hex, manifest, project, primary, sequence or methods", as));
}

/// @param name  of the design
std::string report_of(const Scene& scene, const std::string& name, const ReportPicture& draw,
                      const Progress& progress) {
    Timeline timeline = timeline_of(scene.compiled.bundle);
    if (!name.empty()) timeline.name = name;
    const ImageAnalysis analysis = analyze(timeline, least_felt_n, progress.between(0.0, 0.5));
    std::vector<std::string> findings;
    for (const Finding& finding : findings_of(scene.settings, scene.compiled, analysis))
        findings.push_back(finding.message);
    return report_page(timeline, analysis, findings, draw(timeline, progress.between(0.5, 1.0)), verdict_on(timeline));
}

/// A hand, millimetres, its palm down in the origin, its fingers along y: the edges of its palmar surface as line
/// segments, and the corners of its skin's triangles, coordinates in a row, to 1 µm.
ordered_json hand_outline() {
    const Hand hand = synthetic_hand(HandScript::press, 0.0);
    ordered_json segments = ordered_json::array();
    for (const SkinRegion& region : palmar_surface(hand)) {
        std::vector<Vec3> edge;
        for (std::size_t row = 0; row < region.rows; ++row) edge.push_back(region.point(row, 0));
        for (std::size_t row = region.rows; row-- > 0;) edge.push_back(region.point(row, region.columns - 1));
        for (std::size_t i = 0; i < edge.size(); ++i)
            for (const Vec3& end : {edge[i] - hand.palm, edge[(i + 1) % edge.size()] - hand.palm})
                segments.push_back({end.x / millimetre, end.y / millimetre, end.z / millimetre});
    }
    ordered_json corners = ordered_json::array();
    for (const auto& triangle : drawn_skin(palmar_surface(hand, drawn_skin_options())))
        for (const Vec3& corner : triangle)
            for (const double each : {corner.x - hand.palm.x, corner.y - hand.palm.y, corner.z - hand.palm.z})
                corners.push_back(std::round(each / millimetre * 1e3) / 1e3);
    return {{"segments", segments}, {"skin", corners}};
}

}  // namespace

void answer(Scenes& scenes, Recipient& page, const SceneMessage& message) {
    std::optional<ordered_json> error = error_of([&] {
        const Made made = scenes.compile(message.document);
        page.send(to_text({{"t", "scene"}, {"n", message.n}, {"scene", to_json(*made.scene)}}));
        page.send(shape_bytes(message.n, made.shape));
        if (ordered_json sizes = scenes.sizes_of_files(message.document); !sizes.empty())
            page.send(to_text({{"t", "sizes"}, {"n", message.n}, {"sizes", std::move(sizes)}}));
    });
    if (!error) return;
    page.send(to_text({{"t", "failed"}, {"n", message.n}, {"error", *error}}));
    ordered_json ways = ordered_json::array();
    using Clock = std::chrono::steady_clock;
    const auto over = [until = Clock::now() + most_trying] { return Clock::now() > until; };
    for (const Remedy& way : scenes.ways_out(message.document, over)) ways.push_back(to_json(way));
    page.send(to_text({{"t", "ways"}, {"n", message.n}, {"ways", ways}}));
}

void answer(Scenes& scenes, Recipient& page, const HandMessage& message) {
    tell_failure(page, message.n, [&] {
        const HandScene scene = scenes.hand(message.document);
        const HandView view = hand_view(scene.project, scene.instrument);
        ordered_json found{
            {"t", "hand"}, {"n", message.n}, {"drawn", scene.object->name}, {"array", to_json(scene.instrument.array)}};
        found.update(to_json(view));
        if (message.drawn != scene.object->name)
            page.send(touched_bytes(message.n, scene.object->surface, scene.object->touched->edges));
        page.send(hand_bytes(message.n, view));
        page.send(to_text(found));
    });
}

void answer(Scenes& scenes, Recipient& page, const PathMessage& message, const Progress& progress) {
    tell_unless_cancelled(page, message.n, [&] {
        const HandScene scene = scenes.hand(message.document);
        const Rendered rendered = render(scene.project, scene.instrument, progress);
        ordered_json frames = ordered_json::array();
        for (const FrameReport& report : rendered.frames) frames.push_back(to_json(report));
        page.send(to_text({{"t", "path"},
                           {"n", message.n},
                           {"text", to_json_text(rendered.path, rendered.carrier_hz)},
                           {"frames", frames},
                           {"warnings", rendered.warnings}}));
    });
}

void answer(Scenes& scenes, Recipient& page, const SliceMessage& message) {
    answer_slice(scenes, page, message, [&](const Scene& scene) -> Values {
        return field_of(scene, message, [&](const Excitation& all) { return mean_square_on(all, message.slice); });
    });
}

void answer(Scenes& scenes, Recipient& page, const ReachMessage& message) {
    answer_slice(scenes, page, message.slice, [&](const Scene& scene) -> Values {
        return {reachable_on(scene.excitation.array, message.slice.slice), 1};
    });
}

void answer(Scenes& scenes, Recipient& page, const SkinMessage& message) {
    answer_slice(scenes, page, message.slice, [&](const Scene& scene) -> Values {
        return field_of(scene, message.slice,
                        [&](const Excitation& all) { return mean_square_at(all, message.points); });
    });
}

void answer(Scenes& scenes, Recipient& page, const DrivesMessage& message) {
    tell_failure(page, message.n, [&] {
        ordered_json found{{"t", "drives"}, {"n", message.n}};
        found.update(drives_json(*scenes.find(message.scene), message.record));
        page.send(to_text(found));
    });
}

void answer(Scenes& scenes, Recipient& page, const AnalyzeMessage& message, const Progress& progress) {
    tell_unless_cancelled(page, message.n, [&] {
        const auto scene = scenes.find(message.scene);
        const ImageAnalysis analysis = analyze(timeline_of(scene->compiled.bundle), least_felt_n, progress);
        ordered_json found{{"t", "analysis"}, {"n", message.n}};
        found.update(analysis_json(*scene, analysis));
        page.send(to_text(found));
    });
}

ordered_json hello_json(const Scenes& scenes, const std::string& name) {
    ordered_json algorithms = ordered_json::array();
    for (const AlgorithmName& each : algorithm_names())
        algorithms.push_back({{"letter", std::string(1, each.letter)}, {"about", each.about}});
    ordered_json boards = ordered_json::array();
    for (const std::string& each : shipped_boards()) {
        const Board board = load_board(each);
        boards.push_back({{"name", each}, {"array", board.array}, {"bitstream", bitstream_file(board)}});
    }
    return {{"version", version()},
            {"project", name},
            {"document", scenes.first_document()},
            {"primitives", primitive_kinds()},
            {"arrays", shipped_arrays()},
            {"boards", boards},
            {"touched", object_kinds()},
            {"algorithms", algorithms},
            {"most_file_bytes", serve::most_body_bytes}};
}

std::optional<Answer> answer_at_once(Scenes& scenes, Request request) {
    if (request.path == "/api/document" && request.method == "POST") return document_answer(scenes, request.body);
    if (request.path == "/api/project" && request.method == "POST") return project_answer(scenes, request.body);
    if (request.path == "/api/files") return files_answer(scenes, std::move(request));
    if (request.path == "/api/take") return take_answer(scenes, request);
    if (request.path == "/api/outline") return Answer{.body = to_text(hand_outline())};
    return {};
}

std::optional<Writing> writing_of(Scenes& scenes, const Request& request, const ReportPicture& draw) {
    if (request.path == "/api/field")
        return
            [asked = field_request(request.query, scenes)](const Progress& going) { return field_file(asked, going); };
    if (request.path == "/api/report")
        return [scene = scene_of(scenes, request), name = query_value(request.query, "name").value_or(""),
                draw](const Progress& going) { return report_of(*scene, name, draw, going); };
    return {};
}

}  // namespace haptogram::studio
