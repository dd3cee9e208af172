// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/analyze.hpp"

namespace haptogram {

/// A paragraph for a paper's section on methods: everything that somebody else needs to make the same image and to know
/// what it is. Of a focal point alone there is no image, and nothing to report. The sources that it names are in
/// docs/references.md.
[[nodiscard]] std::string methods_text(const Timeline& timeline);

/// One HTML file about an image, which needs no others: the paragraph above, the numbers of the image, what its user
/// should know before anyone feels it, a picture of the field and a row for each focus.
/// @param findings  whole sentences; when there are none, the page says so
/// @param picture   PNG; empty: without it
[[nodiscard]] std::string report_page(const Timeline& timeline, const ImageAnalysis& analysis,
                                      const std::vector<std::string>& findings, const std::string& picture);

/// The radiation pressure that the whole sequence makes on average, on the level plane through the foci's mean height,
/// as a PNG. It is drawn by python3 with matplotlib.
/// @throws Error{bad_input} when it cannot be drawn
[[nodiscard]] std::string report_picture(const Timeline& timeline, unsigned threads = 0, const Progress& progress = {});

}  // namespace haptogram
