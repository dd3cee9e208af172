// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/depth_source.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram {
namespace {

/// libpng leaves its functions by longjmp, over frames in which no destructor may wait. So the functions that it is
/// called from hold plain pointers, and what it said is kept here.
struct Trouble {
    std::string said;
};

void fail(png_structp png, png_const_charp message) {
    static_cast<Trouble*>(png_get_error_ptr(png))->said = message;
    png_longjmp(png, 1);
}
void ignore(png_structp, png_const_charp) {}

struct Bytes {
    const char* next;
    std::size_t left;
};

void take(png_structp png, png_bytep into, std::size_t count) {
    auto* bytes = static_cast<Bytes*>(png_get_io_ptr(png));
    if (count > bytes->left) png_error(png, "the file ends too early");
    std::memcpy(into, bytes->next, count);
    bytes->next += count;
    bytes->left -= count;
}

void append(png_structp png, png_bytep from, std::size_t count) {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(from), count);
}
void flush(png_structp) {}

struct Header {
    std::uint32_t width = 0, height = 0;
    int depth = 0, colour = 0;
};

bool read_header(png_structp png, png_infop info, Header& header) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_info(png, info);
    header.width = png_get_image_width(png, info);
    header.height = png_get_image_height(png, info);
    header.depth = png_get_bit_depth(png, info);
    header.colour = png_get_color_type(png, info);
    return true;
}

bool read_rows(png_structp png, std::uint16_t* counts, std::uint32_t width, std::uint32_t height) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    const int passes = png_set_interlace_handling(png);
    png_set_swap(png);  // a PNG has the high byte first
    for (int pass = 0; pass < passes; ++pass)
        for (std::uint32_t v = 0; v < height; ++v)
            png_read_row(png, reinterpret_cast<png_bytep>(counts + std::size_t{v} * width), nullptr);
    png_read_end(png, nullptr);
    return true;
}

bool write_rows(png_structp png, png_infop info, const std::uint16_t* counts, std::uint32_t width,
                std::uint32_t height) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_IHDR(png, info, width, height, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 3);
    png_write_info(png, info);
    png_set_swap(png);
    for (std::uint32_t v = 0; v < height; ++v)
        png_write_row(png, reinterpret_cast<png_const_bytep>(counts + std::size_t{v} * width));
    png_write_end(png, nullptr);
    return true;
}

}  // namespace

DepthPicture depth_from_png(std::string_view bytes, const std::string& where, const DepthCamera& camera) {
    Trouble trouble;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &trouble, fail, ignore);
    png_infop info = png_create_info_struct(png);
    Bytes left{bytes.data(), bytes.size()};
    png_set_read_fn(png, &left, take);
    Header header;
    DepthPicture picture;
    bool good = read_header(png, info, header);
    std::string wrong;
    if (good && (header.depth != 16 || header.colour != PNG_COLOR_TYPE_GRAY))
        wrong = fmt::format("a PNG of {} bits and colour type {}; expected 16 bits of one grey channel", header.depth,
                            header.colour);
    else if (good && (header.width != camera.width || header.height != camera.height))
        wrong = fmt::format("a picture of {} x {}; expected the camera's {} x {}", header.width, header.height,
                            camera.width, camera.height);
    if (good && wrong.empty()) {
        picture.resize(std::size_t{header.width} * header.height);
        good = read_rows(png, picture.data(), header.width, header.height);
    }
    png_destroy_read_struct(&png, &info, nullptr);
    if (!wrong.empty()) throw bad_input(where, wrong);
    if (!good) throw bad_input(where, fmt::format("no usable PNG: {}; write the file again", trouble.said));
    return picture;
}

std::string depth_to_png(const DepthPicture& picture, const DepthCamera& camera) {
    if (picture.size() != std::size_t{camera.width} * camera.height)
        throw bad_argument("picture",
                           fmt::format("{} counts; expected {} x {}", picture.size(), camera.width, camera.height));
    Trouble trouble;
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &trouble, fail, ignore);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &bytes, append, flush);
    const bool good = write_rows(png, info, picture.data(), camera.width, camera.height);
    png_destroy_write_struct(&png, &info);
    if (!good) throw bad_argument("picture", trouble.said);
    return bytes;
}

namespace {

namespace fs = std::filesystem;
using section::number_text;

constexpr const char* format_name = "haptogram-depth-1";

Vec3 direction(const section::Section& keys, const char* key) {
    const auto numbers = keys.required(keys.numbers(key, 3), key, "a list of 3 numbers");
    return {numbers[0], numbers[1], numbers[2]};
}

DepthCamera read_camera(const section::Section& keys) {
    keys.only({"folder", "width", "height", "focal_px", "centre_px", "unit_mm", "baseline_mm", "position_mm", "right",
               "forward"});
    DepthCamera camera;
    camera.width = keys.required(keys.whole("width", 1, 65535), "width", "pixels");
    camera.height = keys.required(keys.whole("height", 1, 65535), "height", "pixels");
    const auto focal = keys.required(keys.numbers("focal_px", 2), "focal_px", "a list of 2 numbers");
    const auto centre = keys.required(keys.numbers("centre_px", 2), "centre_px", "a list of 2 numbers");
    camera.focal_x_px = focal[0];
    camera.focal_y_px = focal[1];
    camera.centre_x_px = centre[0];
    camera.centre_y_px = centre[1];
    if (!(focal[0] > 0.0 && focal[1] > 0.0)) throw bad_input(keys.at("focal_px"), "focal_px must be more than 0");
    camera.unit_m = keys.required(keys.number("unit_mm", 1e-6, 1e3), "unit_mm", "the length of a count") * millimetre;
    camera.baseline_m = keys.number("baseline_mm", 1e-3, 1e6).value_or(50.0) * millimetre;
    const Vec3 place = direction(keys, "position_mm");
    camera.pose.origin = from_mm(place.x, place.y, place.z);
    camera.pose.x = direction(keys, "right");
    camera.pose.z = direction(keys, "forward");
    constexpr double slack = 1e-6;
    if (std::abs(norm(camera.pose.x) - 1.0) > slack || std::abs(norm(camera.pose.z) - 1.0) > slack ||
        std::abs(dot(camera.pose.x, camera.pose.z)) > slack)
        throw bad_input(keys.at("forward"),
                        fmt::format("right and forward must have length 1 and be at right angles, found lengths of {} "
                                    "and {}, and a product of {}",
                                    norm(camera.pose.x), norm(camera.pose.z), dot(camera.pose.x, camera.pose.z)));
    camera.pose.y = cross(camera.pose.z, camera.pose.x);
    return camera;
}

/// The number that a picture's name is. Other files than .png are none of ours.
std::optional<std::uint64_t> number_of(const fs::path& file) {
    if (file.extension() != ".png") return {};
    const std::string stem = file.stem().string();
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (error != std::errc{} || end != stem.data() + stem.size())
        throw bad_input(file.string(), "the name of a picture must be the number of its shot, such as 0130.png");
    return number;
}

}  // namespace

DepthCameras cameras_from_toml(std::string_view text, const std::string& where) {
    const toml::table root = section::parse_text(text, where);
    const section::Section keys(where, root);
    keys.only({"format", "rate_hz", "camera"});
    const auto format = keys.required(keys.text("format"), "format", fmt::format("\"{}\"", format_name));
    if (format != format_name)
        throw bad_input(keys.at("format"), fmt::format("format must be \"{}\", found \"{}\"", format_name, format));
    DepthCameras found;
    found.rate_hz = keys.required(keys.number("rate_hz", 0.1, 10e3), "rate_hz", "shots a second");
    const toml::array* list = root["camera"].as_array();
    if (list == nullptr || list->empty() || !list->is_array_of_tables())
        throw bad_input(where, "there is no camera; expected a table [[camera]] for each");
    for (const toml::node& entry : *list) {
        const section::Section camera(where, *entry.as_table());
        found.cameras.push_back(read_camera(camera));
        found.folders.push_back(camera.text("folder"));
        found.lines.push_back(camera.at(found.folders.back() ? "folder" : "width"));
    }
    return found;
}

DepthFolder::DepthFolder(const fs::path& folder) {
    const fs::path file = folder / "cameras.toml";
    const DepthCameras found = cameras_from_toml(read_file(file), file.string());
    rate_hz_ = found.rate_hz;
    cameras_ = found.cameras;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
        if (!found.folders[i])
            throw bad_input(found.lines[i], fmt::format("camera {} has no folder, in which its pictures are", i + 1));
        const fs::path pictures = folder / *found.folders[i];
        std::error_code error;
        auto& numbered = pictures_.emplace_back();
        for (const auto& entry : fs::directory_iterator(pictures, error))
            if (const auto number = number_of(entry.path())) numbered.push_back({*number, entry.path()});
        if (error)
            throw bad_input(found.lines[i], fmt::format("{} cannot be read: {}", pictures.string(), error.message()));
        std::sort(numbered.begin(), numbered.end(),
                  [](const Picture& a, const Picture& b) { return a.number < b.number; });
    }
    if (std::all_of(pictures_.begin(), pictures_.end(), [](const auto& of_camera) { return of_camera.empty(); }))
        throw bad_input(folder.string(), "there are no pictures in it; expected files such as 0001.png");
    next_.assign(cameras_.size(), 0);
}

std::optional<DepthShot> DepthFolder::next() {
    std::optional<std::uint64_t> first;
    for (std::size_t i = 0; i < cameras_.size(); ++i)
        if (next_[i] < pictures_[i].size()) first = std::min(first.value_or(UINT64_MAX), pictures_[i][next_[i]].number);
    if (!first) return {};
    DepthShot shot{*first, static_cast<double>(*first) / rate_hz_, {}};
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
        shot.pictures.emplace_back();
        if (next_[i] == pictures_[i].size() || pictures_[i][next_[i]].number != *first) continue;
        const fs::path& file = pictures_[i][next_[i]++].file;
        shot.pictures.back() = depth_from_png(read_file(file), file.string(), cameras_[i]);
    }
    return shot;
}

std::string cameras_to_toml(const std::vector<DepthCamera>& cameras, double rate_hz) {
    std::string text = fmt::format("format = \"{}\"\nrate_hz = {}\n", format_name, number_text(rate_hz));
    const auto list = [](std::initializer_list<double> numbers) {
        std::string all;
        for (const double each : numbers) all += (all.empty() ? "" : ", ") + number_text(each);
        return "[" + all + "]";
    };
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const DepthCamera& c = cameras[i];
        const Vec3 &place = c.pose.origin, &right = c.pose.x, &forward = c.pose.z;
        text += fmt::format(
            "\n[[camera]]\nfolder = \"camera{}\"\nwidth = {}\nheight = {}\nfocal_px = {}\ncentre_px = {}\n"
            "unit_mm = {}\nbaseline_mm = {}\nposition_mm = {}\nright = {}\nforward = {}\n",
            i + 1, c.width, c.height, list({c.focal_x_px, c.focal_y_px}), list({c.centre_x_px, c.centre_y_px}),
            number_text(exact_mm(c.unit_m)), number_text(exact_mm(c.baseline_m)),
            list({exact_mm(place.x), exact_mm(place.y), exact_mm(place.z)}), list({right.x, right.y, right.z}),
            list({forward.x, forward.y, forward.z}));
    }
    return text;
}

DepthRecorder::DepthRecorder(fs::path folder, const std::vector<DepthCamera>& cameras, double rate_hz)
    : folder_(std::move(folder)), cameras_(cameras) {
    if (fs::exists(folder_ / "cameras.toml"))
        throw bad_input(folder_.string(), "it holds a recording already; name another folder");
    std::error_code error;
    for (std::size_t i = 0; i < cameras_.size() && !error; ++i)
        fs::create_directories(folder_ / fmt::format("camera{}", i + 1), error);
    if (error) throw bad_input(folder_.string(), fmt::format("cannot be made: {}", error.message()));
    write_file(folder_ / "cameras.toml", cameras_to_toml(cameras_, rate_hz));
}

void DepthRecorder::write(const DepthShot& shot) const {
    for (std::size_t i = 0; i < cameras_.size(); ++i)
        if (shot.pictures.at(i))
            write_file(folder_ / fmt::format("camera{}/{:06}.png", i + 1, shot.number),
                       depth_to_png(*shot.pictures[i], cameras_[i]));
}

namespace {

constexpr std::string_view magic = "SHOT";
constexpr std::size_t head_bytes = 24;
constexpr std::size_t most_text = 1U << 16U;
constexpr std::chrono::milliseconds pause{100};

// The machines that the project is built for keep numbers as the pipe has them.
static_assert(std::endian::native == std::endian::little);

template <class Number>
Number number_at(const std::string& bytes, std::size_t at) {
    Number number{};
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

template <class Number>
void append(std::string& bytes, Number number) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof number);
    std::memcpy(bytes.data() + at, &number, sizeof number);
}

std::size_t bytes_of(const DepthCamera& camera) {
    return std::size_t{camera.width} * camera.height * sizeof(DepthPicture::value_type);
}

}  // namespace

DepthPipe::DepthPipe(const std::string& path) : input_(path) {
    std::size_t end = std::string::npos;
    while ((end = bytes_.find('\0')) == std::string::npos) {
        if (bytes_.size() > most_text || input_.ended())
            throw bad_input(input_.name(),
                            fmt::format("expected cameras.toml and a byte of 0 behind it; {}",
                                        input_.ended() ? "it ended before that byte" : "there is none in 64 KiB"));
        (void)input_.read(bytes_, pause);
    }
    DepthCameras found = cameras_from_toml(std::string_view(bytes_).substr(0, end), input_.name());
    if (found.cameras.size() > depth_pipe_cameras)
        throw bad_input(input_.name(), fmt::format("found {} cameras; a pipe has at most {}", found.cameras.size(),
                                                   depth_pipe_cameras));
    bytes_.erase(0, end + 1);
    cameras_ = std::move(found.cameras);
    rate_hz_ = found.rate_hz;
}

/// Why no shot begins at a place, behind which there is a whole head; empty when one may.
std::string DepthPipe::flaw_of(std::size_t at) const {
    if (std::string_view(bytes_).substr(at, magic.size()) != magic)
        return "it must begin with \"SHOT\"; a picture before it has not its camera's size, or bytes were lost";
    const auto seen = number_at<std::uint32_t>(bytes_, at + 4);
    if (cameras_.size() < depth_pipe_cameras && seen >> cameras_.size() != 0)
        return fmt::format("it has pictures by the mask {:#x}, but there are {} cameras", seen, cameras_.size());
    if (!std::isfinite(number_at<double>(bytes_, at + 16))) return "its time is not a finite number";
    return {};
}

/// Goes to the next place at which a shot may begin.
void DepthPipe::skip(const std::string& why) {
    if (!searching_ && junk_++ == 0) why_ = fmt::format("shot {} of the pipe: {}", shots_ + 1, why);
    const std::size_t next = bytes_.find(magic, 1);
    // The beginning of the word may be there, and the rest still come.
    bytes_.erase(0, std::min(next, bytes_.size() - std::min(bytes_.size(), magic.size() - 1)));
    searching_ = true;
}

/// Until a shot may begin with the first byte. @return whether one may
bool DepthPipe::take_head() {
    while (bytes_.size() >= head_bytes) {
        const std::string flaw = flaw_of(0);
        if (flaw.empty()) return true;
        skip(flaw);
    }
    return false;
}

void DepthPipe::take_shot() {
    while (take_head()) {
        const auto seen = number_at<std::uint32_t>(bytes_, 4);
        DepthShot shot{number_at<std::uint64_t>(bytes_, 8), number_at<double>(bytes_, 16), {}};
        std::size_t end = head_bytes;
        for (std::size_t i = 0; i < cameras_.size(); ++i) end += (seen >> i & 1U) != 0 ? bytes_of(cameras_[i]) : 0;
        // A later shot that begins within this one: the writer has lost the rest of this one.
        const std::size_t most = std::min(end, bytes_.size() - head_bytes + 1);
        std::size_t other = bytes_.find(magic, head_bytes);
        while (other < most && !(flaw_of(other).empty() && number_at<std::uint64_t>(bytes_, other + 8) > shot.number &&
                                 number_at<double>(bytes_, other + 16) > shot.time_s))
            other = bytes_.find(magic, other + 1);
        if (other < most) {
            bytes_.erase(0, other - 1);  // so that it is what the search finds
            skip("the next one begins within it");
            continue;
        }
        if (bytes_.size() < end) return;
        std::size_t at = head_bytes;
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
            shot.pictures.emplace_back();
            if ((seen >> i & 1U) == 0) continue;
            DepthPicture picture(std::size_t{cameras_[i].width} * cameras_[i].height);
            std::memcpy(picture.data(), bytes_.data() + at, bytes_of(cameras_[i]));
            at += bytes_of(cameras_[i]);
            shot.pictures.back() = std::move(picture);
        }
        bytes_.erase(0, end);
        shot_ = std::move(shot);
        ++shots_;
        searching_ = false;
        return;
    }
}

bool DepthPipe::ready() {
    using namespace std::chrono_literals;
    take_in(0ms);
    return shot_.has_value() || input_.ended();
}

std::optional<DepthShot> DepthPipe::next() {
    while (!shot_ && !input_.ended()) take_in(pause);
    return std::exchange(shot_, std::nullopt);
}

void DepthPipe::take_in(std::chrono::milliseconds patience) {
    if (!shot_) take_shot();
    while (!shot_ && !input_.ended() && input_.read(bytes_, patience)) take_shot();
    if (!shot_ && input_.ended() && !bytes_.empty()) {
        skip(fmt::format("the pipe ended within it, after {} bytes", bytes_.size()));
        bytes_.clear();
    }
}

std::string depth_pipe_head(const std::vector<DepthCamera>& cameras, double rate_hz) {
    if (cameras.empty() || cameras.size() > depth_pipe_cameras)
        throw bad_argument("cameras", fmt::format("found {}, expected 1 to {}", cameras.size(), depth_pipe_cameras));
    std::string head = cameras_to_toml(cameras, rate_hz);
    head += '\0';
    return head;
}

std::string depth_pipe_shot(const DepthShot& shot, const std::vector<DepthCamera>& cameras) {
    std::string bytes(magic);
    std::uint32_t seen = 0;
    std::string pictures;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const std::optional<DepthPicture>& picture = shot.pictures.at(i);
        if (!picture) continue;
        const std::size_t size = picture->size() * sizeof(DepthPicture::value_type), at = pictures.size();
        if (size != bytes_of(cameras[i]))
            throw bad_argument("shot", fmt::format("the picture of camera {} has {} pixels, expected {} x {}", i + 1,
                                                   picture->size(), cameras[i].width, cameras[i].height));
        seen |= std::uint32_t{1} << i;
        pictures.resize(at + size);
        std::memcpy(pictures.data() + at, picture->data(), size);
    }
    append(bytes, seen);
    append(bytes, shot.number);
    append(bytes, shot.time_s);
    return bytes + pictures;
}

}  // namespace haptogram
