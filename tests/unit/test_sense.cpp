// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <thread>

#include "../refusal.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/live/cluster.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/depth_source.hpp"
#include "recorded_depth.hpp"

using namespace haptogram;

namespace {

std::string left_why(const std::filesystem::path& file) {
    DepthPipe pipe(file.string());
    while (pipe.next()) {
    }
    return pipe.junk().second;
}

/// The largest set of pixels that touch each other at their sides; the others become 0.
DepthPicture largest_component(const DepthPicture& picture, std::uint32_t width) {
    std::vector<std::uint32_t> label(picture.size(), 0);
    std::uint32_t labels = 0, best = 0;
    std::size_t most = 0;
    for (std::size_t start = 0; start < picture.size(); ++start) {
        if (picture[start] == 0 || label[start] != 0) continue;
        std::vector<std::size_t> waiting{start};
        label[start] = ++labels;
        std::size_t count = 0;
        while (!waiting.empty()) {
            const std::size_t at = waiting.back();
            waiting.pop_back();
            ++count;
            const auto visit = [&](bool inside, std::size_t other) {
                if (!inside || picture[other] == 0 || label[other] != 0) return;
                label[other] = labels;
                waiting.push_back(other);
            };
            visit(at % width > 0, at - 1);
            visit((at + 1) % width > 0, at + 1);
            visit(at >= width, at - width);
            visit(at + width < picture.size(), at + width);
        }
        if (count > most) {
            most = count;
            best = labels;
        }
    }
    DepthPicture kept(picture.size(), 0);
    for (std::size_t i = 0; i < picture.size(); ++i)
        if (label[i] == best) kept[i] = picture[i];
    return kept;
}

}  // namespace

TEST_CASE("sense: a recorded hand has as many points and cells as numpy finds (F2)") {
    const auto folder = recorded_depth();
    if (folder.empty()) {
        WARN("skipped: there are no recorded depth frames in ../shared/data/depth");
        return;
    }
    const DepthCamera camera;
    DepthPicture picture = depth_from_png(read_file(folder / "130.png"), "130.png", camera);
    for (auto& count : picture)
        if (count * camera.unit_m >= 0.6) count = 0;
    picture = largest_component(picture, camera.width);
    CloudOptions options;
    options.low = {-1, -1, 0.001};
    options.high = {1, 1, 0.6};
    options.window_px = 1;
    CloudMaker maker(options);
    const std::vector<Vec3> points = maker.points(camera, picture);
    CHECK(points.size() == 20'360);
    double nearest = 1.0, farthest = 0.0;
    for (const Vec3& p : points) {
        nearest = std::min(nearest, p.z);
        farthest = std::max(farthest, p.z);
    }
    CHECK(nearest == Approx(0.4725).margin(5e-5));
    CHECK(farthest == Approx(0.5990).margin(5e-5));
    CHECK(voxel_grid(points, 0.5e-3).size() == 20'360);
    CHECK(voxel_grid(points, 1e-3).size() == 20'350);
    CHECK(voxel_grid(points, 2e-3).size() == 8'202);
}

TEST_CASE("sense: simulated cameras see a ball where it is, from four sides") {
    const Vec3 middle{0.01, -0.02, 0.2};
    const std::vector<RoundedBody> ball{{middle, {}, {}, 0.02}};
    std::vector<DepthCamera> cameras = cameras_around(middle, 0.35, 4);
    for (DepthCamera& camera : cameras) camera.unit_m = 1e-6 * 10;  // finer than real ones, to see the geometry
    CloudOptions options;
    options.window_px = 1;
    options.cell_m = 0.0;
    CloudMaker maker(options);
    DepthShot shot;
    for (const DepthCamera& camera : cameras) shot.pictures.emplace_back(render_depth(ball, camera));
    const std::vector<Vec3> points = maker.cloud(cameras, shot);
    REQUIRE(points.size() > 4000);
    double worst = 0.0;
    Vec3 low = middle, high = middle;
    for (const Vec3& p : points) {
        worst = std::max(worst, std::abs(distance(p, middle) - 0.02));
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    CHECK(worst < 2e-5);  // half a count along a ray that grazes the ball
    CHECK(high.x - low.x == Approx(0.04).margin(1e-4));
    CHECK(high.y - low.y == Approx(0.04).margin(1e-4));
    CHECK(high.z - low.z > 0.036);
}

TEST_CASE("sense: the noise of simulated depth is that of a stereo camera, and pixels at edges are missing") {
    // A wall in front of the camera: a plate of 5 mm at 0.4 m.
    DepthCamera camera = wide_depth_camera();
    camera.unit_m = 1e-5;
    const std::vector<RoundedBody> wall{{{0, 0, 0.405}, {0.05, 0, 0}, {0, 0.05, 0}, 0.005}};
    DepthNoise noise;
    noise.seed = Catch::rngSeed();
    const DepthPicture clean = render_depth(wall, camera), noisy = render_depth(wall, camera, noise);
    double sum = 0.0, squares = 0.0;
    std::size_t flat = 0, lost = 0, seen = 0;
    for (std::size_t i = 0; i < clean.size(); ++i) {
        if (clean[i] == 0) continue;
        ++seen;
        if (noisy[i] == 0) ++lost;
        if (noisy[i] == 0 || clean[i] != 40'000) continue;
        const double off = (noisy[i] - clean[i]) * camera.unit_m;
        sum += off;
        squares += off * off;
        ++flat;
    }
    REQUIRE(flat > 8000);
    CHECK(std::sqrt(squares / static_cast<double>(flat)) == Approx(0.57e-3).epsilon(0.05));  // that of a D435 at 0.4 m
    CHECK(std::abs(sum / static_cast<double>(flat)) < 5.0 * 0.57e-3 / std::sqrt(static_cast<double>(flat)));
    CHECK(lost > 100);
    CHECK(lost < seen / 20);
}

TEST_CASE("sense: the bilateral filter smooths a noisy wall and keeps an edge") {
    DepthCamera camera = wide_depth_camera();
    const std::vector<RoundedBody> walls{{{-0.03, 0, 0.405}, {0.028, 0, 0}, {0, 0.05, 0}, 0.005},
                                         {{0.03, 0, 0.445}, {0.028, 0, 0}, {0, 0.05, 0}, 0.005}};
    DepthNoise noise;
    noise.edge_loss = 0.0;
    CloudOptions options;
    options.low = {-1, -1, 0.1};
    options.high = {1, 1, 1};
    options.cell_m = 0.0;
    CloudMaker filtering(options);
    options.window_px = 1;
    CloudMaker plain(options);
    const DepthPicture picture = render_depth(walls, camera, noise);
    const auto spread = [](const std::vector<Vec3>& points, double z) {
        double squares = 0.0;
        std::size_t count = 0;
        for (const Vec3& p : points)
            if (std::abs(p.z - z) < 5e-3 && std::abs(p.y) < 0.04 && std::abs(std::abs(p.x) - 0.03) < 0.025) {
                squares += (p.z - z) * (p.z - z);
                ++count;
            }
        return std::sqrt(squares / static_cast<double>(count));
    };
    const std::vector<Vec3> rough = plain.points(camera, picture), smooth = filtering.points(camera, picture);
    CHECK(rough.size() == smooth.size());
    // White noise through a window of 5 × 5 with σ = 2 px keeps √(Σw²)/Σw = 0.22 of its amplitude.
    CHECK(spread(smooth, 0.4) < 0.3 * spread(rough, 0.4));
    CHECK(spread(smooth, 0.44) < 0.3 * spread(rough, 0.44));
    std::size_t between = 0;
    for (const Vec3& p : smooth)
        if (p.z > 0.41 && p.z < 0.43 && std::abs(p.y) < 0.045) ++between;
    CHECK(between < smooth.size() / 50);
}

TEST_CASE("sense: a recording gives back its shots, and says what is lost and what is damaged") {
    const TemporaryFolder folder;
    std::vector<DepthCamera> cameras = cameras_around({0, 0, 0.2}, 0.35, 2);
    for (DepthCamera& camera : cameras) {
        camera.width = 64;
        camera.height = 48;
    }
    std::mt19937 random(Catch::rngSeed());
    std::vector<DepthShot> shots;
    {
        const DepthRecorder recorder(folder.path() / "hand", cameras, 30.0);
        for (const std::uint64_t number : {3U, 4U, 7U}) {
            DepthShot shot{number, static_cast<double>(number) / 30.0, {}};
            for (const DepthCamera& camera : cameras) {
                DepthPicture picture(std::size_t{camera.width} * camera.height);
                for (auto& count : picture) count = static_cast<std::uint16_t>(random());
                shot.pictures.emplace_back(std::move(picture));
            }
            if (number == 4) shot.pictures[1].reset();
            recorder.write(shot);
            shots.push_back(std::move(shot));
        }
    }
    DepthFolder read(folder.path() / "hand");
    REQUIRE(read.cameras().size() == 2);
    CHECK(read.cameras()[1].pose.origin == cameras[1].pose.origin);
    CHECK(read.cameras()[1].pose.z == cameras[1].pose.z);
    for (const DepthShot& shot : shots) {
        const auto again = read.next();
        REQUIRE(again.has_value());
        CHECK(again->number == shot.number);
        CHECK(again->time_s == Approx(shot.time_s));
        CHECK(again->pictures == shot.pictures);
    }
    CHECK_FALSE(read.next().has_value());
    CHECK_REFUSED(DepthRecorder(folder.path() / "hand", cameras, 30.0));

    const auto first = folder.path() / "hand/camera1/000003.png";
    const std::string good = read_file(first);
    const auto says = [&](const std::string& content) {
        write_file(first, content);
        return heard::refusal_of([&] { (void)DepthFolder(folder.path() / "hand").next(); });
    };
    CHECK_REFUSAL(says(good.substr(0, good.size() / 2)));
    CHECK_REFUSAL(says("no picture"));
    DepthCamera other = cameras[0];
    other.width = 32;
    CHECK_REFUSAL(says(depth_to_png(DepthPicture(std::size_t{32} * 48), other)));
    write_file(folder.path() / "hand/camera1/hand.png", good);
    CHECK_REFUSED(DepthFolder(folder.path() / "hand"));
}

TEST_CASE("sense: what is written to a pipe is read back, also in pieces, and a file of it is a recording") {
    const TemporaryFolder folder;
    std::vector<DepthCamera> cameras(2);
    for (DepthCamera& camera : cameras) camera.width = 64, camera.height = 48;
    cameras[1].width = 32;
    cameras[1].pose = looking_at({0.1, 0.2, 0.3}, {0, 0, 0.2});
    std::string bytes = depth_pipe_head(cameras, 60.0);
    std::vector<DepthShot> shots;
    std::mt19937 random(Catch::rngSeed());
    for (const std::uint64_t number : {0U, 1U, 2U, 5U}) {
        DepthShot& shot = shots.emplace_back();
        shot.number = number;
        shot.time_s = 7.0 + static_cast<double>(number) / 60.0;
        for (const DepthCamera& camera : cameras) {
            DepthPicture picture(std::size_t{camera.width} * camera.height);
            for (auto& count : picture) count = static_cast<std::uint16_t>(random());
            shot.pictures.emplace_back(std::move(picture));
        }
        if (number == 1) shot.pictures[0].reset();
        if (number == 5) shot.pictures = {{}, {}};
        bytes += depth_pipe_shot(shot, cameras);
    }
    const auto file = folder.path() / "shots";
    write_file(file, bytes);
    const auto same = [&](DepthPipe& pipe, std::thread* writer = nullptr) {
        REQUIRE(pipe.cameras().size() == 2);
        CHECK(pipe.rate_hz() == 60.0);
        CHECK(pipe.cameras()[1].pose.z == cameras[1].pose.z);
        for (const DepthShot& shot : shots) {
            const auto again = pipe.next();
            REQUIRE(again.has_value());
            CHECK(again->number == shot.number);
            CHECK(again->time_s == shot.time_s);
            CHECK(again->pictures == shot.pictures);
        }
        if (writer != nullptr) writer->join();  // who has closed the pipe then
        CHECK(pipe.ready());
        CHECK_FALSE(pipe.next().has_value());
    };
    DepthPipe recording(file.string());
    CHECK_FALSE(recording.live());
    same(recording);

    const auto pipe_file = folder.path() / "pipe";
    REQUIRE(::mkfifo(pipe_file.c_str(), 0600) == 0);
    std::thread writer([&] {
        std::ofstream to(pipe_file, std::ios::binary);
        for (std::size_t at = 0; at < bytes.size(); at += 997)
            to.write(bytes.data() + at, static_cast<std::streamsize>(std::min<std::size_t>(997, bytes.size() - at)))
                .flush();
    });
    {
        DepthPipe pipe(pipe_file.string());
        CHECK(pipe.live());
        same(pipe, &writer);
    }

    const auto says = [&](const std::string& content) {
        write_file(file, content);
        return heard::refusal_of([&] { DepthPipe pipe(file.string()); });
    };
    // What is no shot is counted, said once, and the next one is searched for.
    const auto left = [&](const std::string& content, std::uint64_t junk = 1) {
        write_file(file, content);
        DepthPipe pipe(file.string());
        std::vector<std::uint64_t> numbers;
        while (const auto shot = pipe.next()) {
            numbers.push_back(shot->number);
            const auto of_number = [&](const DepthShot& one) { return one.number == shot->number; };
            const auto sent = std::find_if(shots.begin(), shots.end(), of_number);
            REQUIRE(sent != shots.end());
            CHECK(shot->pictures == sent->pictures);
        }
        CHECK(pipe.junk().first == junk);
        CHECK_SAID(pipe.junk().second);
        return numbers;
    };
    using Numbers = std::vector<std::uint64_t>;
    const std::size_t head = bytes.find('\0') + 1;
    CHECK_REFUSAL(says(bytes.substr(0, head - 1)));
    CHECK_REFUSAL(says(std::string(70'000, ' ')));
    CHECK(left(bytes.substr(0, bytes.size() - 1)) == Numbers{0, 1, 2});
    CHECK(left(bytes + "SH") == Numbers{0, 1, 2, 5});
    std::string odd = bytes;
    odd[head] = 'X';
    CHECK(left(odd) == Numbers{1, 2, 5});
    odd = bytes;
    odd[head + 4] = 7;
    CHECK(left(odd) == Numbers{1, 2, 5});
    CHECK_SAID(left_why(file));
    odd = bytes;
    odd.replace(head + 16, 8, std::string(8, '\xff'));
    CHECK(left(odd) == Numbers{1, 2, 5});
    const std::size_t second = head + depth_pipe_shot(shots[0], cameras).size();
    CHECK(left(odd.erase(head + 1000, 2000)) == Numbers{1, 2, 5});
    for (const std::size_t lost : {std::size_t{1}, std::size_t{1234}, std::size_t{5000}}) {
        odd = bytes;
        CHECK(left(odd.erase(second - lost, lost)) == Numbers{1, 2, 5});
        odd = bytes;
        CHECK(left(odd.insert(second, std::string(lost, 'S'))) == Numbers{0, 1, 2, 5});
        if (lost > 3000) continue;  // with the next head, too: then nothing tells which shot the rest is of
        odd = bytes;
        odd.erase(second + 30, lost).insert(head, std::string(lost, '\0'));
        CHECK(left(odd, 2) == Numbers{0, 2, 5});
    }
    CHECK_REFUSED(depth_pipe_head({}, 30.0));
    CHECK_REFUSED(depth_pipe_head(std::vector<DepthCamera>(33), 30.0));
    std::string many = cameras_to_toml(std::vector<DepthCamera>(33), 30.0);
    many += '\0';
    CHECK_REFUSAL(says(many));
    shots[0].pictures[0]->pop_back();
    CHECK_REFUSED(depth_pipe_shot(shots[0], cameras));
}

TEST_CASE("sense: cameras.toml that cannot be used is refused with its line") {
    const TemporaryFolder folder;
    const std::string good = cameras_to_toml({DepthCamera{}}, 30.0);
    const auto says = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        text.replace(text.find(from), from.size(), to);
        write_file(folder.path() / "cameras.toml", text);
        return heard::refusal_of([&] { DepthFolder(folder.path()); });
    };
    CHECK_REFUSAL(says("haptogram-depth-1", "depth"));
    CHECK_REFUSAL(says("width = 640", "width = 0"));
    CHECK_REFUSAL(says("right = [1.0, 0.0, 0.0]", "right = [0, 0, 1]"));
    CHECK_REFUSAL(says("unit_mm", "unit"));
    CHECK_REFUSAL(says("[[camera]]", "[camera]"));
    CHECK_REFUSAL(says("rate_hz = 30.0", "rate_hz = 30"));
    CHECK_REFUSAL(says("folder = \"camera1\"", ""));
    const std::string bare = std::string(good).replace(good.find("folder"), 18, "");
    CHECK(cameras_from_toml(bare, "pipe").cameras.size() == 1);
}

TEST_CASE("sense: every number of cameras.toml is read back as it was written, to the sign of nothing") {
    DepthCamera camera;
    camera.pose.origin = {-0.0, 1.0 / 3.0, 1e17};
    camera.pose.x = {1.0, -0.0, 0.0};
    camera.centre_x_px = -1e300;
    camera.unit_m = 1.7e-4;
    const std::string text = cameras_to_toml({camera}, 30.0);
    const DepthCameras read = cameras_from_toml(text, "cameras.toml");
    REQUIRE(read.cameras.size() == 1);
    CHECK(std::signbit(read.cameras[0].pose.origin.x));
    CHECK(std::signbit(read.cameras[0].pose.x.y));
    CHECK(read.cameras[0].pose.origin == camera.pose.origin);
    CHECK(read.cameras[0].centre_x_px == camera.centre_x_px);
    CHECK(cameras_to_toml(read.cameras, read.rate_hz) == text);
}

TEST_CASE("sense: a simulated hand is as large as its skin") {
    const Hand hand = synthetic_hand(HandScript::press, 0.0, 0.2);
    const std::vector<RoundedBody> bodies = bodies_of(hand);
    DepthCamera camera = wide_depth_camera();
    camera.pose = looking_at({0, 0, -0.15}, {0, 0, 0.2});
    CloudOptions options;
    options.window_px = 1;
    CloudMaker maker(options);
    const std::vector<Vec3> points = maker.points(camera, render_depth(bodies, camera));
    REQUIRE(points.size() > 10'000);
    const std::vector<SkinRegion> skin = palmar_surface(hand);
    double worst = 0.0;
    for (std::size_t i = 0; i < points.size(); i += 97) {
        double least = 1.0;
        for (const SkinRegion& region : skin)
            least = std::min(least, distance(region.nearest(points[i]).position, points[i]));
        worst = std::max(worst, least);
    }
    // The simulated camera looks at the palm's side; the rounded rim of the palm and of tips is not in the skin.
    CHECK(worst < 15e-3);
    const auto tip = hand.fingers[1]->joints[3];
    double highest_y = 0.0;
    for (const Vec3& p : points)
        if (std::abs(p.x - tip.x) < 3e-3) highest_y = std::max(highest_y, p.y);
    CHECK(highest_y == Approx(tip.y + 7.5e-3).margin(1e-3));
}
