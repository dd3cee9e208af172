// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

namespace haptogram {

/// Lines for another program, each as soon as it is there. Nobody who reads them slowly is waited for: what does not go
/// through at once is dropped as a whole line, and counted.
class LineOutput {
public:
    /// @param place  a file or a named pipe; "-", standard output; or udp:ADDRESS:PORT, a line a datagram
    /// @throws Error{bad_input} when it cannot be opened, Error{bad_argument} for an address that is none
    explicit LineOutput(const std::string& place);
    LineOutput(const LineOutput&) = delete;
    LineOutput& operator=(const LineOutput&) = delete;
    ~LineOutput();

    /// @param line  without its end
    void write(const std::string& line);
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    bool send(const std::string& text);

    int descriptor_ = -1;
    bool datagrams_ = false, keep_open_ = false;
    std::string rest_;  ///< of a line that has begun to go
    std::uint64_t dropped_ = 0;
};

}  // namespace haptogram
