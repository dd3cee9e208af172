// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/depth_png.hpp"

#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstring>

#include "haptogram/base/error.hpp"

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

}  // namespace haptogram
