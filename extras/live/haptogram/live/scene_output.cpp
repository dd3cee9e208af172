// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/scene_output.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "haptogram/base/error.hpp"
#include "haptogram/base/notice.hpp"
#include "haptogram/verbs/trigger_reader.hpp"

namespace haptogram {
namespace {

constexpr const char* scheme = "udp:";

sockaddr_in address_of(const std::string& place) {
    const std::string name = place.substr(std::strlen(scheme));
    const std::size_t colon = name.rfind(':');
    sockaddr_in address{};
    address.sin_family = AF_INET;
    std::uint16_t port = 0;
    bool good = colon != std::string::npos && inet_pton(AF_INET, name.substr(0, colon).c_str(), &address.sin_addr) == 1;
    if (good) {
        const char* end = name.data() + name.size();
        const auto read = std::from_chars(name.data() + colon + 1, end, port);
        good = read.ec == std::errc() && read.ptr == end && port > 0;
    }
    if (!good)
        throw bad_argument("scene",
                           fmt::format("found \"{}\", expected udp:ADDRESS:PORT, such as udp:127.0.0.1:9000", place));
    address.sin_port = htons(port);
    return address;
}

int opened_socket(const std::string& place) {
    const sockaddr_in address = address_of(place);
    const int descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (descriptor < 0 || connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        throw bad_input(place, std::strerror(errno));
    return descriptor;
}

}  // namespace

LineOutput::LineOutput(const std::string& place) {
    if (place.starts_with(scheme)) {
        descriptor_ = opened_socket(place);
        datagrams_ = true;
    } else if (place == "-") {
        descriptor_ = STDOUT_FILENO;
        keep_open_ = true;
    } else {
        descriptor_ = open(place.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (descriptor_ < 0) throw bad_input(place, std::strerror(errno));
        fcntl(descriptor_, F_SETFL, fcntl(descriptor_, F_GETFL) | O_NONBLOCK);
    }
}

LineOutput::~LineOutput() {
    if (!keep_open_) close(descriptor_);
}

bool LineOutput::send(const std::string& text) {
    const std::size_t sent = write_within(descriptor_, text);
    rest_ = sent == 0 ? "" : text.substr(sent);
    return sent > 0;
}

void LineOutput::write(const std::string& line) {
    if (datagrams_) {
        if (::send(descriptor_, line.data(), line.size(), 0) < 0) ++dropped_;
        return;
    }
    if (!rest_.empty()) {
        const std::string begun = rest_;
        if (!send(begun)) rest_ = begun;
    }
    if (!rest_.empty() || !send(line + "\n")) ++dropped_;
}

}  // namespace haptogram

namespace haptogram::live {
namespace {

using Json = nlohmann::ordered_json;

Json in_mm(Vec3 p) { return {1e3 * p.x, 1e3 * p.y, 1e3 * p.z}; }
Json as_list(Vec3 d) { return {d.x, d.y, d.z}; }

Json in_ms(const Latency& latency) {
    return {{"least", 1e3 * latency.least_s},
            {"median", 1e3 * latency.median_s},
            {"most", 1e3 * latency.most_s},
            {"rings", latency.rings}};
}

Json times_of(const std::vector<SentRing>& rings) {
    Json list = Json::array();
    for (const SentRing& ring : rings) {
        Json one = {{"shot", ring.shot}, {"shot_s", ring.shot_s}, {"pushed_s", ring.pushed_s}};
        if (ring.began_s) {
            one["began_s"] = ring.began_s->middle();
            one["uncertain_s"] = ring.began_s->half();
            one["latency_s"] = ring.began_s->middle() - ring.shot_s;
        }
        list.push_back(std::move(one));
    }
    return list;
}

constexpr std::size_t most_foci_told = 64;  ///< of a path; longer ones are told at even distances

Json hands_of(const Frame& frame) {
    Json hands = Json::array();
    const auto* both = std::get_if<Together>(&frame.seen);
    const auto* seen = both != nullptr ? &both->hands : std::get_if<HandFrame>(&frame.seen);
    if (seen == nullptr) return hands;
    for (const Hand& hand : seen->hands) {
        Json fingers = Json::array();
        for (const auto& finger : hand.fingers) {
            Json joints = Json::array();
            if (finger)
                for (const Vec3& joint : finger->joints) joints.push_back(in_mm(joint));
            fingers.push_back(std::move(joints));
        }
        hands.push_back({{"id", hand.id},
                         {"right", hand.right},
                         {"palm_mm", in_mm(hand.palm)},
                         {"normal", as_list(hand.normal)},
                         {"direction", as_list(hand.direction)},
                         {"fingers_mm", std::move(fingers)}});
    }
    return hands;
}

Json objects_of(const ShotReport& shot) {
    Json objects = Json::array();
    for (const FeltObject& object : shot.objects) {
        Json& one = objects.emplace_back(Json{{"name", object.name}, {"object", object.kind}});
        one["size_mm"] = 1e3 * object.size_m;
        if (object.height_m) one["height_mm"] = 1e3 * *object.height_m;
        one["center_mm"] = in_mm(object.pose.origin);
        one["x"] = as_list(object.pose.x);
        one["z"] = as_list(object.pose.z);
    }
    return objects;
}

/// Where the foci go, and how strong each is: x, y, z in mm and the amplitude.
Json foci_of(const std::optional<Path>& path) {
    Json foci = Json::array();
    if (!path) return foci;
    const std::size_t stride = (path->steps.size() + most_foci_told - 1) / most_foci_told;
    for (std::size_t i = 0; i < path->steps.size(); i += stride)
        for (const Focus& focus : path->steps[i].foci) {
            Json one = in_mm(focus.position);
            one.push_back(focus.amplitude);
            foci.push_back(std::move(one));
        }
    return foci;
}

}  // namespace

Json to_json(const ShotReport& shot, const Frame& frame, const std::optional<Path>& path) {
    Json sections = Json::array();
    for (std::size_t i = 0; i < shot.sections.size(); ++i) {
        const Ellipse& e = shot.sections[i];
        sections.push_back({{"centre_mm", in_mm(e.centre)},
                            {"played_at_mm", in_mm(shot.centres[i])},
                            {"half_axes_mm", {1e3 * e.half_major, 1e3 * e.half_minor}},
                            {"major", as_list(e.major)},
                            {"normal", as_list(e.normal)}});
    }
    Json contacts = Json::array();
    for (const std::vector<Vec3>& line : shot.contacts) {
        Json& points = contacts.emplace_back(Json::array());
        for (const Vec3& p : line) points.push_back(in_mm(p));
    }
    return {{"scene", scene_version},
            {"shot", shot.number},
            {"time_s", shot.time_s},
            {"points", shot.points},
            {"fingers", shot.fingers},
            {"hands", hands_of(frame)},
            {"sections", sections},
            {"contacts_mm", contacts},
            {"foci", foci_of(path)},
            {"objects", objects_of(shot)},
            {"force_n", shot.force_n},
            {"compute_ms", 1e3 * shot.compute_s},
            {"latency_ms", shot.latency_s ? Json(1e3 * *shot.latency_s) : Json()},
            {"troubles", shot.troubles}};
}

Json to_json(const LoopReport& report, const Latency& latency) {
    std::vector<double> compute = report.compute_s;
    std::sort(compute.begin(), compute.end());
    Json json = {{"shots", report.shots},
                 {"with_rings", report.with_rings},
                 {"rings", report.rings.size()},
                 {"lost", report.lost},
                 {"skipped", report.skipped},
                 {"out_of_order", report.out_of_order},
                 {"empty", report.empty},
                 {"blind", report.blind},
                 {"without_camera", report.without_camera},
                 {"without_picture", report.without_picture},
                 {"through", report.through},
                 {"no_section", report.no_section},
                 {"constrained", report.constrained},
                 {"out_of_reach", report.out_of_reach},
                 {"without_magnitude", report.without_magnitude},
                 {"hidden", report.hidden},
                 {"unweighed", report.unweighed},
                 {"missed", report.missed},
                 {"fades", report.fades},
                 {"underruns", report.underruns}};
    if (!compute.empty())
        json["compute_ms"] = {{"least", 1e3 * compute.front()},
                              {"median", 1e3 * compute[compute.size() / 2]},
                              {"most", 1e3 * compute.back()}};
    if (latency.rings > 0) json["latency_ms"] = in_ms(latency);
    if (const Latency stamped = latency_of(report.rings); stamped.rings > 0) {
        json["stamped_latency_ms"] = in_ms(stamped);
        json["stamped_latency_ms"]["uncertain"] = 1e3 * stamped.uncertain_s;
    }
    return json;
}

Json run_to_json(const LoopReport& report, const Latency& latency) {
    Json json = to_json(report, latency);
    json["ring_times"] = times_of(report.rings);
    return json;
}

Json to_json(const LiftOptions& asked, const LiftReport& report) {
    return {{"edge_mm", 1e3 * asked.edge_m},
            {"at_mm", {1e3 * asked.x_m, 1e3 * asked.y_m}},
            {"turn_deg", asked.turn_deg},
            {"done", report.done},
            {"shots", report.shots},
            {"touched_shots", report.touched_shots},
            {"felt_shots", report.felt_shots},
            {"tries", report.tries},
            {"first_touch_s", report.first_touch_s},
            {"time_s", report.time_s},
            {"lifted_mm", 1e3 * report.lifted_m},
            {"mean_force_n", report.mean_force_n},
            {"most_force_n", report.most_force_n},
            {"energy_made_mj", 1e3 * report.energy_made_j},
            {"with_rings", report.counts.with_rings},
            {"through", report.counts.through},
            {"no_section", report.counts.no_section},
            {"out_of_reach", report.counts.out_of_reach}};
}

Json to_json(const SurfaceOptions& asked, const SurfaceReport& report) {
    Json json = {{"asked_deg", asked.angle_deg}, {"asked_mm", 1e3 * asked.height_m},  {"done", report.done},
                 {"shots", report.shots},        {"felt_places", report.felt_places}, {"time_s", report.time_s}};
    json["guessed"] = report.guessed;
    if (report.done || report.guessed) {
        json["answer_deg"] = report.angle_deg;
        json["answer_mm"] = 1e3 * report.height_m;
        json["angle_error_deg"] = report.angle_error_deg;
        json["height_error_mm"] = 1e3 * report.height_error_m;
    }
    json["with_rings"] = report.counts.with_rings;
    json["no_section"] = report.counts.no_section;
    json["out_of_reach"] = report.counts.out_of_reach;
    return json;
}

}  // namespace haptogram::live
