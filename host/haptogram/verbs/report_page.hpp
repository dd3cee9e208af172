// SPDX-License-Identifier: Apache-2.0
// What a user should know of an image before anyone feels it, in words, and what would mend it.
#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

/// A change of the project after which a finding is gone or smaller.
struct Remedy {
    std::string label;               ///< what it does, as a button says it
    nlohmann::ordered_json changes;  ///< keys of the project file (project.hpp) with other values, as document.hpp has
                                     ///< them; of a table, the keys that change
};

/// One thing that is not as a user may expect.
struct Finding {
    std::string kind;     ///< one word or two with a hyphen, such as "short-dwell": the same for the same rule
    std::string message;  ///< a whole sentence: what was found and what it should be
    std::vector<std::size_t> records{};  ///< where it is, places in the manifest from 0 on; empty: it is of the whole
    std::vector<Remedy> remedies{};
};

/// A point that has less than this share of the strongest one's force over time feels much weaker than it.
inline constexpr double least_even_share = 0.5;
/// A side lobe of more than this share of the focus's radiation pressure may be felt as a second point.
inline constexpr double most_side_lobe = 0.5;
/// An object smaller than this many widths of a focus feels like a point.
inline constexpr double least_widths = 2.0;

/// What compiling alone tells, the gravest first:
///
/// | kind | rule |
/// |------|------|
/// | `out-of-reach` | sampled points were left out because the array cannot reach them |
/// | `short-dwell`  | a focus is left before its full pressure is there (Haptogram eq. 12) |
/// | `steady`       | one focus that never changes: skin feels changes, and hardly a steady pressure |
/// | `bandwidth`    | the transducers' bandwidth leaves some foci less than half of their pressure |
/// | `duplicates`   | points that lie on others were left out |
/// | `warning`      | any other sentence of Compiled::warnings |
[[nodiscard]] std::vector<Finding> findings_of(const Project& project, const Compiled& compiled);

/// The same with what the analysis of each focus adds. `short-dwell` then names the foci that are left too early, each
/// by its own formation time and load.
///
/// | kind | rule |
/// |------|------|
/// | `weak`      | less force in the focus than a palm is known to feel |
/// | `uneven`    | some points have less than half of the strongest one's pressure on skin, weighted by their dwells |
/// | `side-lobe` | more than half of the focus's radiation pressure stands beside it |
/// | `small`     | the foci lie within two widths of a focus, so that their shape is not felt |
///
/// Also the findings of findings_of(Loudness).
[[nodiscard]] std::vector<Finding> findings_of(const Project& project, const Compiled& compiled,
                                               const ImageAnalysis& analysis);

/// | kind | rule |
/// |------|------|
/// | `loud`    | more than the level that is recommended for ears, at 300 mm; a model, and no certificate |
/// | `intense` | more intensity than is known to be safe inside tissue |
[[nodiscard]] std::vector<Finding> findings_of(const Loudness& loudness);

/// {"label", "changes"}
[[nodiscard]] nlohmann::ordered_json to_json(const Remedy& remedy);
/// {"kind", "message", "records", "remedies"}, records counted from 1.
[[nodiscard]] nlohmann::ordered_json to_json(const Finding& finding);

/// A paragraph for a paper's section on methods: everything that somebody else needs to make the same image and to know
/// what it is. Of a focal point alone there is no image, and nothing to report. The sources that it names are in
/// docs/references.md.
[[nodiscard]] std::string methods_text(const Timeline& timeline);

/// One HTML file about an image, which needs no others: the paragraph above, the numbers of the image, what its user
/// should know before anyone feels it, a picture of the field and a row for each focus.
/// @param findings  whole sentences; when there are none, the page says so
/// @param picture   PNG; empty: without it
/// @param verdict   whether it is felt; empty: nobody knows
[[nodiscard]] std::string report_page(const Timeline& timeline, const ImageAnalysis& analysis,
                                      const std::vector<std::string>& findings, const std::string& picture,
                                      const std::string& verdict = "");

/// The radiation pressure that the whole sequence makes on average, on the level plane through the foci's mean height,
/// as a PNG. It is drawn by python3 with matplotlib.
/// @throws Error{bad_input} when it cannot be drawn
[[nodiscard]] std::string report_picture(const Timeline& timeline, unsigned threads = 0, const Progress& progress = {});

}  // namespace haptogram
