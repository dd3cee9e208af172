// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::link {

/// A device for callers that look after their own signals while they wait: what is asked goes on in a thread here, one
/// thing at a time, and wait() tells when it has ended. Nothing is said to the device but what is asked, so its
/// watchdog watches the caller. All functions but interrupt() are for one thread at a time.
class AskedDevice {
public:
    /// Opens nothing yet.
    explicit AskedDevice(PortSettings settings);
    AskedDevice(const AskedDevice&) = delete;
    AskedDevice& operator=(const AskedDevice&) = delete;
    /// What goes on is interrupted.
    ~AskedDevice();

    /// These return at once. What went on before is interrupted.
    /// Opens the port, if it is not open, and begins a session; the reply has the identity block.
    void identify();
    /// @param when  of a single request
    void ask(std::vector<Request> requests, When when);
    /// Turns the outputs off, whatever came before; it needs no session. Fails when the device does not confirm it.
    void shut_off();

    /// What goes on ends soon, and has failed with Interrupted.
    void interrupt() { interrupts_ = 1; }
    /// @return whether it goes on  @throws what ended it, once
    bool wait(std::chrono::milliseconds patience);
    /// Of what was asked last, in order. @throws Error{bad_argument} while it goes on
    [[nodiscard]] const std::vector<Reply>& replies() const;

    /// Sends patterns, of a word for each channel, for this carrier period and those after it, as many in a frame as
    /// the device takes; nothing is answered.
    void stream(std::uint64_t period, const std::uint16_t* words, std::size_t patterns);
    /// While something is asked, something new is said at least so often, until shut_off(); 0: no more.
    void keep_alive_every(std::chrono::milliseconds pause);

    [[nodiscard]] std::uint64_t retransmissions() const { return device_ ? device_->retransmissions() : 0; }
    /// The rate at which the device answers, if it had to be looked for.
    [[nodiscard]] std::uint32_t found_baud() const { return found_baud_; }

private:
    void run();
    [[nodiscard]] bool busy() const;
    void finish();
    void begin(std::function<void()> work);
    void be_patient();
    void turn_off();
    [[nodiscard]] Client& identified() const;
    void note(const Request& request);

    PortSettings settings_;
    std::unique_ptr<Client> device_;
    std::vector<Reply> replies_;
    std::optional<std::uint16_t> watchdog_ms_{};  // of the device, if it is known
    std::atomic<unsigned> interrupts_ = 0;
    std::atomic<std::uint32_t> found_baud_ = 0;
    mutable std::mutex mutex_;
    std::condition_variable news_;
    std::function<void()> work_;  // that was not taken up yet
    bool busy_ = false, ending_ = false;
    std::exception_ptr trouble_;
    std::thread thread_;  // the same for all work: a new one would wait for its turn on a busy machine
};

}  // namespace haptogram::link
