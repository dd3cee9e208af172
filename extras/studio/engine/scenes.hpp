// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/base/process.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/report_page.hpp"
#include "haptogram/verbs/timeline.hpp"

namespace haptogram::studio {

/// A project that was compiled: what the page shows, plays and takes away.
struct Scene {
    std::string name;     ///< a hash of the document and its files, so that equal projects are one scene
    std::string project;  ///< text of the project file
    Project settings;     ///< the same; the contents of its files are left out
    Compiled compiled;
    Excitation excitation;   ///< of the image
    double skin_per_square;  ///< radiation pressure on skin over the mean square pressure, 1/Pa
};

/// A scene together with its object at its place, metres; empty for a path.
struct Made {
    std::shared_ptr<const Scene> scene;
    Shape shape;
};

/// An object that hands touch, and how it is drawn.
struct DrawnObject {
    std::string name;  ///< a hash of its settings and its file
    std::shared_ptr<const TouchObject> touched;
    Mesh surface;
};

/// A document's hand, with recording and object opened.
struct HandScene {
    Project project;
    ProjectInstrument instrument;
    std::shared_ptr<const DrawnObject> object;
};

/// An array for drawing, millimetres: {"name", "radius_mm", "elements"}.
[[nodiscard]] nlohmann::ordered_json to_json(const Array& array);

/// What a scene is in numbers, millimetres and seconds, for the page.
[[nodiscard]] nlohmann::ordered_json to_json(const Scene& scene);

/// The drives of one record: {"record", "index", "phases_deg", "amplitudes"}, an entry a channel. Phases are those of
/// the elements' waves, 0 to 360°; amplitudes are shares of an element's full strength.
/// @param record  counted from 1
/// @throws Error{bad_argument} when there is no such record
[[nodiscard]] nlohmann::ordered_json drives_json(const Scene& scene, std::uint32_t record);

/// What the analysis of each focus came to, and all findings: {"foci": [{"record", "radiation_pa", "width_mm",
/// "depth_mm", "side_lobe", "force_mn"}], "places": [{"at", "over_db", "least_db", "most_db"}], "at_300_mm_db",
/// "most_at_300_mm_db", "verdict", "findings"}. The verdict is the sentence of `haptogram compile`; the places, mm, are
/// those that it is of, with decibels over what is just felt: expected, and with what is not known; null is nothing.
[[nodiscard]] nlohmann::ordered_json analysis_json(const Scene& scene, const ImageAnalysis& analysis);

/// The files that pages sent, the project that the studio was started with, and the scenes that were compiled last. All
/// functions may be called from any thread.
class Scenes {
public:
    static constexpr std::size_t most_file_bytes = 512 * 1024 * 1024;  ///< of all files together
    static constexpr std::size_t most_scenes = 16;
    static constexpr std::size_t most_opened = 4;  ///< recordings, and objects that they touch

    /// Reads the files of a project or a bundle, so that the page can refer to them by the names that the project has
    /// for them; or the file of a shape, which then begins a project.
    /// @throws Error as load_project() and read_file()
    void open(const std::filesystem::path& project);
    /// The document that a page begins with: the project that was opened, or a hemisphere.
    [[nodiscard]] nlohmann::ordered_json first_document() const;

    /// Keeps a file under a name, in place of an older one of that name.
    /// @throws Error{bad_input} for a name that no file of a project can have, or when all files are too large
    void add_file(const std::string& name, std::string content);
    /// A file that was opened or sent, as it is.
    /// @throws Error{bad_input} when there is none of that name
    [[nodiscard]] std::string file(const std::string& name) const;

    /// The files that a project needs: those that it names, and the array that its calibration names.
    [[nodiscard]] std::vector<std::string> needed_files(const Project& project) const;

    /// Compiles a document, unless it is one of the scenes already.
    /// @throws Error naming what is wrong with the document; a shape file must have been sent, or be the project's, and
    /// an array or a board must be shipped, or be the project's: a page cannot name other files of this machine
    Made compile(const nlohmann::ordered_json& document);
    /// How large the shapes are that a document's files have: [{"name", "extent", "own_unit"}], in the numbers of the
    /// file, or in millimetres when it says its unit.
    [[nodiscard]] nlohmann::ordered_json sizes_of_files(const nlohmann::ordered_json& document);
    /// What mends a document that compile() refuses (ways_out.hpp).
    /// @param over  whether no more is to be tried
    [[nodiscard]] std::vector<Remedy> ways_out(
        const nlohmann::ordered_json& document, const std::function<bool()>& over = [] { return false; });
    /// Opens what a document's hand names, unless it is open already.
    /// @throws Error as compile()
    HandScene hand(const nlohmann::ordered_json& document);
    /// A scene that is asked for is kept as if it was compiled just now.
    /// @throws Error{bad_argument} when there is no such scene
    [[nodiscard]] std::shared_ptr<const Scene> find(const std::string& name);

private:
    struct File {
        std::string content, hash;
    };
    template <class What>
    using Opened = std::list<std::pair<std::string, std::shared_ptr<const What>>>;  // the one used last in front

    [[nodiscard]] Project project_of(const std::string& text, std::string& identity) const;
    [[nodiscard]] const File& file_of(const std::string& name) const;
    /// Where a file that a project names is read from: what was sent, else what was opened.
    void find_file(std::string& name, const std::string& opened, std::string& identity) const;
    [[nodiscard]] std::string hash_of(const std::string& name) const;
    /// The array file that an array file names, if it is a calibration that is known.
    [[nodiscard]] std::optional<std::string> array_behind(const std::string& name) const;
    std::shared_ptr<const DrawnObject> open_hand(Project& project, std::string& identity);
    template <class What, class Open>
    std::shared_ptr<const What> opened(Opened<What>& known, const std::string& name, const Open& open);

    mutable std::mutex mutex_;
    std::map<std::string, File> files_;
    TemporaryFolder scratch_;
    // Of files that are read by name: arrays, boards, paths, waveforms. Called like a bundle, so that they name no
    // other files of this machine.
    std::filesystem::path sent_ = scratch_.path() / "page.haptogram";
    Opened<HandRecording> hands_;
    Opened<DrawnObject> objects_;
    std::map<std::string, nlohmann::ordered_json> sizes_;  // by the file's hash
    nlohmann::ordered_json first_;
    Project opened_;
    std::list<std::shared_ptr<const Scene>> scenes_;  // the one used last in front
};

}  // namespace haptogram::studio
