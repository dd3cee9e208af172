// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/device_state.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

struct DeviceSettings {
    /// Opens the port; called by who steps, again after a loss.
    std::function<std::unique_ptr<Transport>()> open;
    /// Told by who steps, without a lock held, of each status and each change; it must return soon. When it throws,
    /// the outputs are shut off and the message becomes the state's trouble.
    std::function<void(const DeviceState&)> told{};
    std::chrono::milliseconds reconnect_pause{200};
    Clock& clock = machine_clock();  ///< of the line
};

/// The work of a DeviceThread, a step at a time. All functions but step() and run() may be called in any thread.
class DeviceSteps : public std::enable_shared_from_this<DeviceSteps> {
public:
    explicit DeviceSteps(DeviceSettings settings);
    DeviceSteps(const DeviceSteps&) = delete;
    DeviceSteps& operator=(const DeviceSteps&) = delete;
    ~DeviceSteps();

    /// Does what is due. It waits for nothing but `open`, and some milliseconds for what arrives on the line.
    /// @return when to be called again, unless there is something to do before; nothing: the end
    std::optional<Clock::Time> step();
    /// Steps and waits until the end.
    void run();

    /// As those of DeviceThread. The outputs are off, and the port is closed, when step() has said that it is the end.
    void end();
    [[nodiscard]] std::unique_ptr<Commands> channel(std::chrono::milliseconds patience);
    std::uint64_t shut_off();
    bool wait_off(std::uint64_t shut_off, std::chrono::milliseconds patience);
    [[nodiscard]] DeviceState state() const;
    [[nodiscard]] Clock& clock() const { return settings_.clock; }

private:
    class Channel;
    struct Item;
    struct Mailbox;
    enum class Phase { closed, open, turns_off, begins, serves };

    std::shared_ptr<Mailbox> open(std::chrono::milliseconds patience, Identity& identity);
    void close(const std::shared_ptr<Mailbox>& box);
    void close_all(const std::exception_ptr& why);
    template <class Change>
    void tell(Change change);
    [[nodiscard]] bool ending() const;
    [[nodiscard]] bool has_work() const;
    void lose(const std::string& trouble);
    void open_port();
    void turn_off();
    void begin();
    [[nodiscard]] Clock::Time serve();
    void tell_requests();
    void take_requests();
    void hand_over(const std::shared_ptr<Mailbox>& box, Item item);
    void ask_for_status();

    DeviceSettings settings_;
    mutable std::mutex mutex_;
    std::condition_variable work_;  // for who steps
    std::condition_variable news_;  // for who waits for a connection or a confirmation
    DeviceState state_;
    std::vector<std::shared_ptr<Mailbox>> boxes_;
    bool ending_ = false;
    std::atomic<bool> urgent_ = false;
    std::atomic<std::uint64_t> retransmissions_ = 0;
    // Of who steps alone:
    std::unique_ptr<Transport> port_;
    std::optional<Client> client_;
    Phase phase_ = Phase::closed;
    bool lost_ = false, had_session_ = false, asking_ = false;
    Clock::Time open_at_{0}, next_status_{0};
    std::uint64_t asked_off_ = 0;
    std::uint16_t watchdog_ms_ = 500;
};

}  // namespace haptogram::link
