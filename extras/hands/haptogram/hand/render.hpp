// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/hand/touch.hpp"
#include "haptogram/perception/feel.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

/// The palmar skin of all hands of a recording's frame.
/// @param frame  from 1
/// @throws Error{bad_argument} naming "hand-frame" when there is no such frame; Error{bad_input} when no hand is in it;
/// and as palmar_surface() does, naming the frame
[[nodiscard]] std::vector<SkinRegion> skin_of(const HandRecording& hands, std::size_t frame,
                                              const SkinOptions& options = {});

/// Of all these, the place of the skin nearest to a point, as feel() asks for it.
[[nodiscard]] std::function<HandSkin(Vec3)> nearest_skin(std::vector<SkinRegion> skin);

struct RenderOptions {
    Algorithm algorithm = Algorithm::intersection;
    TouchOptions touch;
    SkinOptions skin;
    std::optional<std::size_t> frame;    ///< only this one, from 1: one pass, which can be repeated
    std::optional<std::uint32_t> dwell;  ///< carrier periods of a step; by default usual_dwell()
    std::optional<std::size_t> points;   ///< of the pass of one frame, instead of the dwell
    std::string am;  ///< waveform of the amplitude, as modulation_of() reads it; empty: the algorithm's own, if any
    std::filesystem::path am_folder;  ///< that relative names of files in it start from
    AmplitudeLaw am_law = AmplitudeLaw::pressure;
    std::optional<double> magnitude;  ///< how strong each focus feels under that waveform (perception/magnitude.hpp)
    double amplitude = 1.0;           ///< of all foci, of the most that the array can make: above 0, at most 1
    double least_force_n = 0.63e-3;   ///< below which a place counts as not felt: what a palm needs (Multimodal, Table
                                      ///< III, for a hand that holds 1 N)
};

/// What became of one frame.
struct FrameReport {
    std::size_t frame = 0;  ///< its number in the recording, from 1
    double time_s = 0.0;
    std::size_t hands = 0, lines = 0, foci = 0;  ///< foci: at the same time
    double length_m = 0.0;                       ///< of all lines
    double draw_hz = 0.0;                        ///< passes of the first focus a second
    double focus_pa = 0.0;  ///< radiation pressure of one focus alone, in the middle of the lines, on skin that faces
                            ///< the sound
    double width_m = 0.0;   ///< of this focus: full width at half maximum of the radiation pressure
    double strength_pa = 0.0;  ///< estimate of the mean over time on the lines: focus_pa · width / length of the first
                               ///< focus' lines, over the number of foci, without tilt; of K and L focus_pa over the
                               ///< number of foci, as they are felt where the foci are
    double tilt = 0.0;         ///< mean of cos²θ along the lines, θ between the sound's way and the skin's normal; 0
                               ///< where the skin faces away
    double weak = 0.0;         ///< the share of the length where strength · tilt · width² is below the least force
    double out_of_reach = 0.0;     ///< the share of the time at which a focus is out of the array's reach, and silent
    std::string why;               ///< the first focus is
    std::size_t lines_missed = 0;  ///< by the steps, in the pass of one frame
    double compute_s = 0.0;        ///< processor time that skin, lines and path took
};

/// A frame's report, millimetres, pascals and shares from 0 to 1, as `haptogram render --report --json` prints it.
[[nodiscard]] nlohmann::ordered_json to_json(const FrameReport& report);

struct Rendered : RenderedPath {
    std::optional<Touch> touch;  ///< of one frame: what is drawn
    std::vector<FrameReport> frames;
};

/// A path that lets hands feel an object. A recording's frame lasts until the next one; the foci go on where they are
/// in their pass. What the array cannot reach, and frames that touch nothing, are silent.
/// @param carrier_hz  in whose periods the path counts
/// @throws Error{bad_input} when no frame touches the object, saying how far it is, or when nothing that is touched can
/// be reached; Error{bad_argument} for options that make no sense, hands that are not finite, a waveform beside the
/// algorithm's own, and naming "magnitude" where the array or the tables do not have it
[[nodiscard]] Rendered render(const TouchObject& object, const HandRecording& hands, const Array& array,
                              double carrier_hz, const RenderOptions& options, const Progress& progress = {});

/// Whether a part of a line is estimated to press on the skin with less than the least force, by the frame's strength,
/// the skin's tilt there, and the focus' width.
[[nodiscard]] bool is_weak(const Leg& leg, const FrameReport& report, double least_force_n);

/// Draws up to six frames, evenly chosen of those that touch the object: hand, object, lines, and the radiation
/// pressure on the skin, averaged over a pass and with the skin's tilt.
/// @param path  .png
/// @throws Error{bad_input} when it cannot be drawn
void draw_render(const std::string& path, const TouchObject& object, const HandRecording& hands, const Array& array,
                 double carrier_hz, const RenderOptions& options, const Rendered& rendered);

}  // namespace haptogram
