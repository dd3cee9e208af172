// SPDX-License-Identifier: Apache-2.0
// Every reader of foreign bytes, for libFuzzer: one executable a target, named by HAPTOGRAM_TARGET. A reader may refuse
// with an Error; any other exception, a crash, a leak or a hang is a finding. What is taken must come through its own
// writer.
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/pulses.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/formats/parts.hpp"
#include "haptogram/hand/joints.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/link/frame.hpp"
#include "haptogram/live/depth_source.hpp"
#include "haptogram/shape/adaptics.hpp"
#include "haptogram/shape/adaptics_frames.hpp"
#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/document.hpp"
#include "haptogram/verbs/project.hpp"
#include "messages.hpp"

namespace haptogram::fuzz {

void require(bool holds) {
    if (!holds) std::abort();
}

void frame(const std::string& content) {
    const link::Bytes bytes(content.begin(), content.end());
    link::ReplyDecoder decoder;
    std::vector<link::Reply> replies;
    decoder.feed(bytes, replies);
    for (std::size_t i = 0; i < bytes.size(); i += 7)
        decoder.feed(std::span(bytes).subspan(i, std::min<std::size_t>(7, bytes.size() - i)), replies);
    require(link::cobs_decode(link::cobs_encode(bytes)) == bytes);
    if (const auto decoded = link::cobs_decode(bytes); decoded && std::ranges::find(bytes, 0) == bytes.end())
        require(link::cobs_decode(link::cobs_encode(*decoded)) == decoded);
}

void intel_hex(const std::string& content) {
    const Image image = from_intel_hex(content, "fuzz");
    static_cast<void>(problems(image));
    require(from_intel_hex(to_intel_hex(image), "fuzz") == image);
}

void pulses(const std::string& content) {
    const std::vector<Pulse> found = pulses_from_csv(content, "fuzz");
    require(pulses_from_csv(to_csv(found), "fuzz") == found);
}

void manifest(const std::string& content) { static_cast<void>(to_text(manifest_from_json(content, "fuzz"))); }

void ply(const std::string& content) { static_cast<void>(as_shape(read_ply(content, "fuzz"), "fuzz")); }
void obj(const std::string& content) { static_cast<void>(as_shape(read_obj(content, "fuzz"), "fuzz")); }
void stl(const std::string& content) { static_cast<void>(as_shape(read_stl(content, "fuzz"), "fuzz")); }
void off(const std::string& content) {
    static_cast<void>(as_shape(formats::read_off({content, "fuzz", false}), "fuzz"));
}
void pcd(const std::string& content) {
    static_cast<void>(as_shape(formats::read_pcd({content, "fuzz", false}), "fuzz"));
}
void gltf(const std::string& content) {
    static_cast<void>(as_shape(formats::read_gltf({content, "fuzz", false}), "fuzz"));
}
void svg(const std::string& content) {
    static_cast<void>(as_shape(formats::read_svg({content, "fuzz", false}), "fuzz"));
}

void three_mf(const std::string& content) {
    static_cast<void>(as_shape(formats::read_three_mf({content, "fuzz", false}), "fuzz"));
}
/// As each of the models in one.
void three_mf_model(const std::string& content) {
    const formats::Parts part = [&content](const std::string& name) -> std::optional<std::string> {
        return name == "_rels/.rels" ? "<r><r Type='/3dmodel' Target='a'/></r>" : content;
    };
    static_cast<void>(as_shape(formats::read_three_mf_parts(part, "fuzz"), "fuzz"));
}
void xyz(const std::string& content) { static_cast<void>(as_shape(read_rows(content, "fuzz", false), "fuzz")); }
void csv(const std::string& content) { static_cast<void>(as_shape(read_rows(content, "fuzz", true), "fuzz")); }

/// For those that read files only.
std::string as_file(const std::string& content) {
    static const std::string path = "/dev/shm/haptogram-fuzz-" + std::to_string(::getpid()) + ".toml";
    std::ofstream(path, std::ios::binary) << content;
    return path;
}

void array(const std::string& content) { static_cast<void>(load_array(as_file(content))); }
void board(const std::string& content) { static_cast<void>(load_board(as_file(content))); }

void project(const std::string& content) {
    const Project found = project_from_toml(content, "fuzz");
    const std::string written = to_toml(found);
    require(to_toml(project_from_toml(written, "fuzz")) == written);
}

constexpr double carrier_hz = 40e3;

void path(const std::string& content) {
    const Path found = path_from_json(content, "fuzz", carrier_hz);
    const std::string written = to_json_text(found, carrier_hz);
    require(to_json_text(path_from_json(written, "fuzz", carrier_hz), carrier_hz) == written);
}

void path_csv(const std::string& content) { require_sound(path_from_csv(content, "fuzz", carrier_hz)); }
void adaptics(const std::string& content) {
    require_sound(path_from_adaptics(content, "fuzz", carrier_hz, 20));
    (void)frames_from_adaptics(content, "fuzz");
}
void wav(const std::string& content) { static_cast<void>(wave_from_wav(content, "fuzz")); }
void leap(const std::string& content) { static_cast<void>(recording_from_leap(content, "fuzz")); }
void joints(const std::string& content) { static_cast<void>(recording_from_joints(content, "fuzz")); }
void leap_message(const std::string& content) { static_cast<void>(frame_from_leap_message(content, "fuzz")); }

/// What a writer wrote, read again: to refuse that is a finding.
template <class Read>
auto again(Read read) {
    try {
        return read();
    } catch (const Error&) {
        std::abort();
    }
}

/// A PNG whose chunks all have the CRC of what they hold, so that what is behind them is reached.
std::string with_good_checks(std::string png) {
    const auto word = [&png](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i) value = value << 8U | static_cast<std::uint8_t>(png[at + i]);
        return value;
    };
    constexpr std::size_t signature = 8, around = 12;  // length, type and CRC
    for (std::size_t at = signature; at + around <= png.size();) {
        const std::size_t length = word(at);
        if (length > png.size() - at - around) break;
        const auto* typed = reinterpret_cast<const Bytef*>(png.data() + at + 4);
        const auto sum = static_cast<std::uint32_t>(::crc32(0, typed, static_cast<uInt>(length + 4)));
        for (unsigned i = 0; i < 4; ++i) png[at + 8 + length + i] = static_cast<char>(sum >> (24 - 8 * i));
        at += around + length;
    }
    return png;
}

void depth_png(const std::string& content) {
    DepthCamera camera;
    camera.width = 4;
    camera.height = 3;
    const DepthPicture picture = depth_from_png(with_good_checks(content), "fuzz", camera);
    const std::string written = depth_to_png(picture, camera);
    require(again([&] { return depth_from_png(written, "fuzz", camera); }) == picture);
}

void cameras(const std::string& content) {
    const DepthCameras found = cameras_from_toml(content, "fuzz");
    const std::string written = cameras_to_toml(found.cameras, found.rate_hz);
    const DepthCameras same = again([&] { return cameras_from_toml(written, "fuzz"); });
    require(cameras_to_toml(same.cameras, same.rate_hz) == written);
}

/// All shots of a pipe, which are written as they were read; what lies between them is counted.
void depth_pipe(const std::string& content) {
    static const int file = ::memfd_create("pipe", 0);
    require(::ftruncate(file, 0) == 0 &&
            ::pwrite(file, content.data(), content.size(), 0) == static_cast<ssize_t>(content.size()));
    DepthPipe pipe(fmt::format("/proc/self/fd/{}", file));
    std::size_t at = content.find('\0') + 1;
    while (const auto shot = pipe.next()) {
        const std::string written = again([&] { return depth_pipe_shot(*shot, pipe.cameras()); });
        at = content.find(written, at);
        require(at != std::string::npos);
        at += written.size();
    }
    require(at == content.size() || pipe.junk().first > 0);
}

/// A name of a file that can only be in the folder where it is looked for, and that no program takes for an option.
bool is_plain_name(const std::string& name) {
    return !name.empty() && name.find_first_of("/\\") == std::string::npos && name[0] != '.' && name[0] != '-';
}

/// What a page may send to the studio. What is refused is told to the page, and so must be text whatever was found; a
/// document that is taken for a project must come through its own writer.
void message(const std::string& content) {
    studio::Message found;
    try {
        found = studio::read_message(content);
    } catch (const Error& error) {
        require(error.code() == ErrorCode::bad_input);
        require(nlohmann::json::accept(studio::to_text(studio::to_json(error))));
        throw;
    }
    if (const auto* const study = std::get_if<studio::StudyMessage>(&found))
        require(is_plain_name(study->protocol) && is_plain_name(study->results) && study->participant >= 1);
    if (const auto* const slice = std::get_if<studio::SliceMessage>(&found)) require(slice->view < studio::most_views);
    if (const auto* const answer = std::get_if<studio::AnswerMessage>(&found))
        require(nlohmann::json::accept(nlohmann::json(answer->text).dump()));
    const auto* const scene = std::get_if<studio::SceneMessage>(&found);
    const auto* const hand = std::get_if<studio::HandMessage>(&found);
    const auto* const rendered = std::get_if<studio::PathMessage>(&found);
    if (scene == nullptr && hand == nullptr && rendered == nullptr) return;
    const auto& document = scene != nullptr ? scene->document : (hand != nullptr ? hand->document : rendered->document);
    const Project project = project_from_toml(toml_of(document), "fuzz");
    const std::string written = to_toml(project);
    require(to_toml(again([&] { return project_from_toml(written, "fuzz"); })) == written);
    const std::string as_document = toml_of(again([&] { return document_of(written, "fuzz"); }));
    require(toml_of(again([&] { return document_of(as_document, "fuzz"); })) == as_document);
}

const std::map<std::string, void (*)(const std::string&)> targets = {{"frame", frame},
                                                                     {"intel_hex", intel_hex},
                                                                     {"pulses", pulses},
                                                                     {"manifest", manifest},
                                                                     {"ply", ply},
                                                                     {"obj", obj},
                                                                     {"stl", stl},
                                                                     {"off", off},
                                                                     {"pcd", pcd},
                                                                     {"gltf", gltf},
                                                                     {"svg", svg},
                                                                     {"three_mf", three_mf},
                                                                     {"three_mf_model", three_mf_model},
                                                                     {"xyz", xyz},
                                                                     {"csv", csv},
                                                                     {"array", array},
                                                                     {"board", board},
                                                                     {"project", project},
                                                                     {"path", path},
                                                                     {"path_csv", path_csv},
                                                                     {"adaptics", adaptics},
                                                                     {"wav", wav},
                                                                     {"leap", leap},
                                                                     {"joints", joints},
                                                                     {"depth_png", depth_png},
                                                                     {"cameras", cameras},
                                                                     {"message", message},
                                                                     {"leap_message", leap_message},
                                                                     {"depth_pipe", depth_pipe}};
void (*target)(const std::string&) = nullptr;

}  // namespace haptogram::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    const char* name = std::getenv("HAPTOGRAM_FUZZ");
    haptogram::fuzz::target = haptogram::fuzz::targets.at(name == nullptr ? "" : name);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        haptogram::fuzz::target({reinterpret_cast<const char*>(data), size});
    } catch (const haptogram::Error&) {
    }
    return 0;
}
