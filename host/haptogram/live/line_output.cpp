// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/line_output.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

#include "haptogram/base/error.hpp"
#include "haptogram/base/notice.hpp"

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
