// SPDX-License-Identifier: Apache-2.0
// What a page and the server say to each other over the WebSocket. The requests, and how each is answered; "failed" can
// replace any answer, and link.ts has the members of answers:
//   scene              scene, the object, binary HOB1, and sizes of its files; or failed, and then ways to mend it
//   hand               the object, unless it is drawn already; skin and lines, binary HHA1; hand
//   path, drives, pulses, studies    an answer of the same name
//   slice, reach, skin               binary HSL1
//   analyze, simulate  analysis; pins; cancel ends either
//   connect, disconnect, intensity   device, to all pages
//   upload, play, stream             progress, also of which scene plays, then done, stopped or failed, to all pages
//   study              study {shown}, repeatedly: begun {n}, the runner's lines, note {text}, ended {code}
//   answer, leave      go to the runner
//   live               live {shown}: begun, note and ended, and scenes, at most 33 a second
//   stop               off {n, confirmed}, once the board has confirmed, or after 2 s without its word
//   modulate, trigger  no answer
//   beat {hidden}      beat; five times a second, so that each side hears of the other
//
// Over HTTP, with the token; errors are {"error": {"message"}} with the usual codes:
//   GET /api/hello                version, first document, lists of shapes, objects, algorithms, arrays, boards, ports
//   POST, GET /api/files?name=N   keeps a file for a project, 64 MiB at most, and gives it back
//   POST /api/document            a project's text, or an AdapTics pattern's: {document, files}
//   POST /api/project             a document: {text, files}
//   GET /api/outline              a hand: {segments, skin}, ends of its outline's lines, corners of its skin
//   GET /api/take?scene=N&as=A    A: hex, manifest, project, primary, sequence or methods
//   GET /api/report?scene=N       HTML
//   GET /api/bitstream?scene=N&autostart=0 (or 1)
//   GET /api/field?scene=N&plane=xy@z=130&x=-80:80&y=-80:80&step=MM&quantity=radiation&as=A    A: png, csv, npy or vti;
//       with &record=R of this record alone
//   GET /api/field?scene=N&x=-80:80&y=-80:80&z=60:200&step=MM&quantity=rms&as=stl&below=DB    the surface at so many
//       decibels below the volume's greatest value
//   POST /api/stop                outputs off, when the WebSocket does not answer
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/shape/shape.hpp"
#include "haptogram/verbs/field.hpp"

namespace haptogram::studio {

/// Compile a project. The answer has the same number.
struct SceneMessage {
    std::uint32_t n = 0;
    nlohmann::ordered_json document;  ///< haptogram/verbs/document.hpp
};
/// Show one frame of the hand that a project has, and what it feels.
struct HandMessage {
    std::uint32_t n = 0;
    nlohmann::ordered_json document;
    std::string drawn;  ///< what the page has drawn of the object, as an answer called it; "": nothing
};
/// Render the hand that a project has: its frame, or, without one, all of them.
struct PathMessage {
    std::uint32_t n = 0;
    nlohmann::ordered_json document;
};
/// Compute a slice of a scene's field.
struct SliceMessage {
    std::uint32_t n = 0;
    std::string scene;
    Slice slice{};             ///< metres; millimetres on the line
    std::uint32_t record = 0;  ///< of this record alone, counted from 1; 0: the mean over the sequence
    std::uint32_t view = 0;    ///< 0 to 3: each of a page's views waits for itself
};
inline constexpr std::uint32_t most_views = 4;
/// Compute a slice whose value at each point is that of a focus placed there. The answer is that of a SliceMessage;
/// the record is 0.
struct ReachMessage {
    SliceMessage slice;
};
/// Compute a scene's field at places, such as those of a hand's skin. The answer is that of a SliceMessage, with all
/// values in one row; origin and edges are not used.
struct SkinMessage {
    SliceMessage slice;
    std::vector<Vec3> points;  ///< metres; millimetres, x, y, z of each in a row, on the line
};
/// Tell the drives of one record.
struct DrivesMessage {
    std::uint32_t n = 0;
    std::string scene;
    std::uint32_t record = 0;  ///< counted from 1
};
/// Find out what each focus is like. Of a page, a newer one ends the older.
struct AnalyzeMessage {
    std::uint32_t n = 0;
    std::string scene;
};
/// Play a scene's image on the Verilated core, and compare its pins with the image. Of a page, a newer one ends the
/// older.
struct SimulateMessage {
    std::uint32_t n = 0;
    std::string scene;
};
/// End what the page's last message of that kind began.
struct CancelMessage {
    enum class What { analyze, simulate };
    std::uint32_t n = 0;
    What what = What::simulate;
};
/// Tell the pulses that were measured at the pins, from the first of a record on.
struct PulsesMessage {
    std::uint32_t n = 0;
    std::uint32_t index = 0;    ///< of the record on the board
    std::uint32_t periods = 1;  ///< of the carrier
};
/// Connect to a port. "virtual" starts a reference board that can play the scene, "virtual-rtl" the simulated Verilog.
struct ConnectMessage {
    std::uint32_t n = 0;
    std::string port, scene;
    std::uint32_t baud = 0;  ///< 0: it is found
};
struct DisconnectMessage {
    std::uint32_t n = 0;
};
/// Bring a scene's image into the board's memories.
struct UploadMessage {
    std::uint32_t n = 0;
    std::string scene;
};
/// The same, and play it, or the parts of it that triggers start.
struct PlayMessage {
    std::uint32_t n = 0;
    std::string scene;
    std::vector<TriggeredPart> triggers;  ///< as the scene's answer has them; none: all of it, at once
    std::string lines{};                  ///< a named pipe whose lines fire them, too; "": none
};
/// Start such a part.
struct TriggerMessage {
    std::uint32_t n = 0;
    std::uint32_t number = 0;  ///< from 0 on
};
inline constexpr std::size_t most_triggers = 100;
/// Bring the image, and play one record until the next such message names another: the page's scrubber moves.
struct StreamMessage {
    std::uint32_t n = 0;
    std::string scene;
    std::uint32_t index = 0;  ///< of a record, from 1 on
};
/// Play everything so strong from now on, also what plays already.
struct IntensityMessage {
    std::uint32_t n = 0;
    double value = 1.0;  ///< 0…1
};
/// Modulate what plays as another scene is, of which all else is the same.
struct ModulateMessage {
    std::uint32_t n = 0;
    std::string scene;
};
/// Tell which studies there are.
struct StudiesMessage {
    std::uint32_t n = 0;
};
/// Run a participant's session, or go on with it. The names are of files in the project's folder, without a path.
struct StudyMessage {
    std::uint32_t n = 0;
    std::string protocol;  ///< a shipped one, or a file
    std::uint32_t participant = 1, seed = 1;
    std::string results;  ///< a file that ends in .jsonl
    std::string port;     ///< that plays the stimuli; "studio": the one the studio is connected to; "": none
};
/// Let a hand feel a document's object as it comes, on the board that the studio is connected to.
struct LiveMessage {
    std::uint32_t n = 0;
    nlohmann::ordered_json document;
    std::string from;  ///< a tracker's named pipe; "": the document's recording
};
/// What a person did where the session waits.
struct AnswerMessage {
    std::uint32_t n = 0;
    std::uint32_t number = 0;  ///< of what was waited for
    std::string text;
};
/// Stop the session where it is; it goes on later.
struct LeaveMessage {
    std::uint32_t n = 0;
};
inline constexpr std::size_t longest_answer = 4000, longest_name = 100, longest_port = 200;  ///< bytes
inline constexpr std::uint32_t most_participant = 100'000;
/// Outputs off, ahead of everything.
struct StopMessage {
    std::uint32_t n = 0;
};
/// The page is alive.
struct BeatMessage {
    bool hidden = false;  ///< the page is not visible
};

using Message =
    std::variant<SceneMessage, HandMessage, PathMessage, SliceMessage, ReachMessage, SkinMessage, DrivesMessage,
                 AnalyzeMessage, SimulateMessage, CancelMessage, PulsesMessage, ConnectMessage, DisconnectMessage,
                 UploadMessage, PlayMessage, TriggerMessage, StreamMessage, IntensityMessage, ModulateMessage,
                 StudiesMessage, StudyMessage, LiveMessage, AnswerMessage, LeaveMessage, StopMessage, BeatMessage>;

inline constexpr std::size_t most_members = 4000;  ///< of a message and all objects in it; a shape has ten at most

/// Reads a message. A member that is missing, of another type, or unknown is an error, because page and server are
/// always of one version.
/// @throws Error{bad_input} naming the message and the member
[[nodiscard]] Message read_message(std::string_view text);

/// A message as text. Messages quote what stands in files; bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string to_text(const nlohmann::ordered_json& message);

/// An error as a page shows it: {"where", "message", "remedies"}.
[[nodiscard]] nlohmann::ordered_json to_json(const Error& error);

/// A slice as bytes, little-endian: a header of 64 bytes, so that what follows is aligned for typed arrays, then
/// width × height values of float32, the mean square pressure in Pa², rows of v = 0 first.
///
/// | at | type | what |
/// |----|------|------|
/// | 0  | u8[4] | "HSL1" |
/// | 4  | u32 | number of the request |
/// | 8, 12 | u32 | width, height |
/// | 16, 20 | f32 | least and greatest value |
/// | 24 | f32 | radiation pressure on skin over mean square, 1/Pa |
/// | 28 | f32 | time that it took, ms |
/// | 32 | u32 | sets of foci that were averaged |
/// | 36 | u8[28] | the first characters of the scene's name |
[[nodiscard]] std::vector<std::uint8_t> slice_bytes(const SliceMessage& asked, const std::vector<float>& values,
                                                    double skin_per_square, double took_ms, std::size_t sets);

inline constexpr std::size_t most_drawn_triangles = 10'000, most_drawn_points = 50'000;

/// A shape as bytes for drawing, little-endian, millimetres: a header of 64 bytes, then float32 x, y, z of the
/// vertices; u32 numbers of the vertices of triangles (three each); float32 x, y, z of the ends of line segments (two
/// each) and of points. Larger meshes are sent coarser: vertices in one cell of a grid become one, which leaves no
/// holes. Of larger clouds every n-th point is sent. The header says how many points there are.
///
/// | at | type | what |
/// |----|------|------|
/// | 0  | u8[4] | "HOB1" |
/// | 4  | u32 | number of the request |
/// | 8, 12, 16, 20 | u32 | vertices, triangles, line segments, points that follow |
/// | 24, 28 | u32 | triangles and points that the shape has |
[[nodiscard]] std::vector<std::uint8_t> shape_bytes(std::uint32_t n, const Shape& shape);

/// The same of an object that a hand feels: its surface, and its edges as line segments.
[[nodiscard]] std::vector<std::uint8_t> touched_bytes(std::uint32_t n, const Mesh& surface,
                                                      const std::vector<Edge>& edges);

/// A frame of a hand as bytes for drawing, little-endian, millimetres: a header of 64 bytes, then float32 x, y, z of
/// the corners of the skin's triangles (three each), of line segments that can be felt and of those that are too weak
/// (two each), and of the focal points of the pass.
///
/// | at | type | what |
/// |----|------|------|
/// | 0  | u8[4] | "HHA1" |
/// | 4  | u32 | number of the request |
/// | 8, 12, 16, 20 | u32 | triangles, felt segments, weak segments, focal points that follow |
[[nodiscard]] std::vector<std::uint8_t> hand_bytes(std::uint32_t n, const HandView& view);

/// The same in numbers: {"frame", "frames", "time_s", "end_s", "pass_s", "lines": [{"kind", "length_mm"}], "report",
/// "warnings", "nothing"}. `report` is null when the frame has no lines, and `nothing`, else null, is the error that
/// says why.
[[nodiscard]] nlohmann::ordered_json to_json(const HandView& view);

}  // namespace haptogram::studio
