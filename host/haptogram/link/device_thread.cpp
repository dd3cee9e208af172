// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device_thread.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {
namespace {

using Clock = std::chrono::steady_clock;
using Lock = std::unique_lock<std::mutex>;

constexpr std::chrono::milliseconds longest_read{5};       // until new requests and shut_off() are looked at again
constexpr std::chrono::milliseconds polite_patience{500};  // for what a channel ends by itself

/// A request on its way, in one place at a time: queued by its channel, or handed to the client.
struct Item {
    Request request;
    std::function<void(const Reply&)> done;
};

/// What a channel and the thread share. All of it is guarded by the core's mutex.
struct Mailbox {
    struct Answer {
        Reply reply;
        std::function<void(const Reply&)> done;
    };
    std::deque<Item> queued;
    std::vector<Request> told;   // that get no answer
    std::deque<Answer> answers;  // that wait() has not handed out yet
    std::size_t under_way = 0;
    std::uint64_t epoch = 0;     // answers to requests of an earlier one are nobody's
    std::exception_ptr refusal;  // thrown once by wait()
    std::exception_ptr closed;   // thrown from now on by everything
    std::condition_variable news;

    [[nodiscard]] std::size_t unanswered() const { return queued.size() + under_way + answers.size(); }
    void empty() {
        queued.clear();
        told.clear();
        answers.clear();
        under_way = 0;
        ++epoch;
    }
};

std::exception_ptr shut_off_error() {
    return std::make_exception_ptr(
        Error(ErrorCode::cancelled, "board", "the outputs were shut off, and with them this work"));
}

}  // namespace

class DeviceThread::Core {
public:
    explicit Core(Settings settings) : settings_(std::move(settings)) {}

    void start() {
        thread_ = std::thread([this] { run(); });
    }

    /// May be called again; whoever does waits, too.
    void end() {
        {
            const Lock lock(mutex_);
            ending_ = true;
            close_all(shut_off_error());
        }
        urgent_ = true;
        work_.notify_all();
        news_.notify_all();
        const std::lock_guard joining(joining_);
        if (thread_.joinable()) thread_.join();
    }

    std::uint64_t shut_off() {
        const Lock lock(mutex_);
        close_all(shut_off_error());
        urgent_ = true;
        work_.notify_all();
        news_.notify_all();
        return ++state_.shut_offs;
    }

    bool wait_off(std::uint64_t shut_off, std::chrono::milliseconds patience) {
        Lock lock(mutex_);
        return news_.wait_for(lock, patience, [&] { return state_.confirmed >= shut_off; });
    }

    std::shared_ptr<Mailbox> open(std::chrono::milliseconds patience, Identity& identity) {
        Lock lock(mutex_);
        const auto over = [&, before = state_.shut_offs] { return ending_ || state_.shut_offs != before; };
        news_.wait_for(lock, patience, [&] { return state_.connection == Connection::connected || over(); });
        if (over()) std::rethrow_exception(shut_off_error());
        if (state_.connection != Connection::connected)
            throw Error(ErrorCode::device, "board",
                        state_.trouble.empty() ? "it has not answered yet" : state_.trouble);
        identity = state_.identity;
        return boxes_.emplace_back(std::make_shared<Mailbox>());
    }

    void close(const std::shared_ptr<Mailbox>& box) {
        const Lock lock(mutex_);
        box->empty();
        std::erase(boxes_, box);
    }

    DeviceState state() const {
        const Lock lock(mutex_);
        return state_;
    }

    std::mutex& mutex() const { return mutex_; }
    void wake() { work_.notify_all(); }
    std::uint64_t retransmissions() const { return retransmissions_; }

private:
    /// Drops what every channel has queued, and lets it fail. The mutex is held.
    void close_all(const std::exception_ptr& why) {
        for (const auto& box : boxes_) {
            box->empty();
            box->closed = why;
            box->news.notify_all();
        }
        boxes_.clear();
    }

    /// Tells the caller what is so, and whoever waits for it.
    template <class Change>
    void tell(Change change) {
        DeviceState now;
        {
            const Lock lock(mutex_);
            change(state_);
            now = state_;
        }
        news_.notify_all();
        if (!settings_.told) return;
        std::string trouble;
        try {
            settings_.told(now);
            return;
        } catch (const std::exception& error) {
            trouble = error.what();
        } catch (...) {
            trouble = "an unknown exception";
        }
        shut_off();
        const Lock lock(mutex_);
        state_.trouble = fmt::format("what was to be told of the board failed: {}", trouble);
    }

    void run() {
        for (bool had_session = false;;) {
            try {
                const std::unique_ptr<Transport> port = settings_.open();
                Client client(*port);
                urgent_ = urgent_ || had_session;  // what ended the last session may have left the outputs on
                while (!serve(client, had_session)) {
                }
                return;
            } catch (const std::exception& error) {
                lose(error.what());
            }
            Lock lock(mutex_);
            work_.wait_for(lock, settings_.reconnect_pause, [&] { return ending_; });
            if (ending_) return;
        }
    }

    /// Begins a session and serves the channels, until shut_off() or the end interrupts whatever is waited for.
    /// @return whether it is the end  @throws Error when the link is lost
    bool serve(Client& client, bool& had_session) {
        try {
            if (urgent_) turn_off(client);
            if (ending()) return true;
            client.set_interrupt([this] { return urgent_ ? 1U : 0U; });
            const Identity identity = client.identify();
            had_session = true;
            asking_ = false;
            tell([&](DeviceState& state) {
                // Why outputs were shut off stays; why there was no device is over.
                if (state.connection != Connection::connected) state.trouble.clear();
                state.connection = Connection::connected;
                state.identity = identity;
            });
            client.keep_alive_every(keep_alive_pause(watchdog_ms_));
            serve(client);
        } catch (const Interrupted&) {
        }
        return false;
    }

    void lose(const std::string& trouble) {
        {
            const Lock lock(mutex_);
            close_all(std::make_exception_ptr(LinkLost("board", trouble)));
        }
        tell([&](DeviceState& state) {
            if (state.connection == Connection::connected) state.connection = Connection::lost;
            state.trouble = trouble;
        });
    }

    bool ending() const {
        const Lock lock(mutex_);
        return ending_;
    }

    /// Speaks to the device until something is urgent. @throws Error when the link is lost
    void serve(Client& client) {
        Clock::time_point next_status = Clock::now();
        while (!urgent_) {
            tell_requests(client);
            take_requests(client);
            if (!asking_ && Clock::now() >= next_status) {
                ask_for_status(client);
                next_status = Clock::now() + keep_alive_pause(watchdog_ms_);
            }
            if (client.unanswered() > 0) {
                client.exchange(longest_read);
                retransmissions_ = client.retransmissions();
                continue;
            }
            Lock lock(mutex_);
            work_.wait_until(lock, next_status, [&] {
                return urgent_ || ending_ || std::ranges::any_of(boxes_, [](const auto& box) {
                           return !box->queued.empty() || !box->told.empty();
                       });
            });
        }
    }

    /// Sends what the channels only tell, without the mutex: a port that takes no bytes must not hold up shut_off().
    void tell_requests(Client& client) {
        std::vector<Request> told;
        {
            const Lock lock(mutex_);
            for (const auto& box : boxes_) {
                std::ranges::move(box->told, std::back_inserter(told));
                box->told.clear();
            }
        }
        for (Request& request : told) {
            if (urgent_) return;
            client.tell(std::move(request));
        }
        if (!told.empty()) client.flush();
    }

    /// Hands requests of the channels in turn to the client, as many as its window holds.
    void take_requests(Client& client) {
        const Lock lock(mutex_);
        for (bool found = true; found && !urgent_;) {
            found = false;
            for (const auto& box : boxes_) {
                if (client.unanswered() >= client.window()) return;
                if (box->queued.empty()) continue;
                found = true;
                Item item = std::move(box->queued.front());
                box->queued.pop_front();
                ++box->under_way;
                hand_over(client, box, std::move(item));
            }
        }
    }

    void hand_over(Client& client, const std::shared_ptr<Mailbox>& box, Item item) {
        const std::uint64_t epoch = box->epoch;
        client.submit(
            std::move(item.request),
            [this, box, epoch, done = std::move(item.done)](const Reply& reply) {
                const Lock lock(mutex_);
                if (box->epoch != epoch) return;
                --box->under_way;
                box->answers.push_back({reply, done});
                box->news.notify_all();
            },
            [this, box, epoch](const Error& error) {
                const Lock lock(mutex_);
                if (box->epoch != epoch) return;
                box->empty();
                box->refusal = std::make_exception_ptr(error);
                box->news.notify_all();
            });
    }

    void ask_for_status(Client& client) {
        asking_ = true;
        client.submit({interface::Command::status, {}}, [this, &client](const Reply& reply) {
            asking_ = false;
            const Status status = to_status(reply.data);
            watchdog_ms_ = status.watchdog_ms;
            client.keep_alive_every(keep_alive_pause(watchdog_ms_));
            tell([&](DeviceState& state) { state.status = status; });
        });
    }

    /// Turns the outputs off ahead of everything. Nothing is waited for as long as the policy would.
    void turn_off(Client& client) {
        std::uint64_t asked = 0;
        {
            const Lock lock(mutex_);
            urgent_ = false;
            asked = state_.shut_offs;
        }
        client.set_interrupt([] { return 1U; });
        if (!client.turn_off()) throw LinkLost("board", not_confirmed(watchdog_ms_));
        tell([&](DeviceState& state) {
            state.status.enabled = false;
            state.confirmed = std::max(state.confirmed, asked);
        });
    }

    Settings settings_;
    mutable std::mutex mutex_;
    std::condition_variable work_;  // for the thread
    std::condition_variable news_;  // for who waits for a connection or a confirmation
    DeviceState state_;
    std::vector<std::shared_ptr<Mailbox>> boxes_;
    bool ending_ = false;
    std::atomic<bool> urgent_ = false;
    std::atomic<std::uint64_t> retransmissions_ = 0;
    std::mutex joining_;
    std::thread thread_;
    // Of the thread alone:
    bool asking_ = false;
    std::uint16_t watchdog_ms_ = 500;
};

/// A channel: hands requests to the thread and waits for their answers in its own.
class DeviceThread::Channel final : public Commands {
public:
    Channel(std::shared_ptr<Core> core, std::chrono::milliseconds patience)
        : core_(std::move(core)), box_(core_->open(patience, identity_)) {}
    ~Channel() override { core_->close(box_); }

    [[nodiscard]] const Identity& identity() const override { return identity_; }

    void submit(Request request, std::function<void(const Reply&)> done) override {
        const Lock lock(core_->mutex());
        if (box_->closed) std::rethrow_exception(box_->closed);
        box_->queued.push_back({std::move(request), std::move(done)});
    }

    void tell(Request request) override {
        const Lock lock(core_->mutex());
        if (box_->closed) std::rethrow_exception(box_->closed);
        box_->told.push_back(std::move(request));
    }

    void flush() override { core_->wake(); }

    void wait(std::size_t most_unanswered) override {
        core_->wake();
        Lock lock(core_->mutex());
        for (;;) {
            if (box_->closed) std::rethrow_exception(box_->closed);
            if (box_->refusal) std::rethrow_exception(std::exchange(box_->refusal, {}));
            if (!box_->answers.empty()) {
                const Mailbox::Answer answer = std::move(box_->answers.front());
                box_->answers.pop_front();
                lock.unlock();
                if (answer.done) answer.done(answer.reply);
                lock.lock();
                continue;
            }
            if (box_->unanswered() <= most_unanswered) return;
            box_->news.wait(lock);
        }
    }

    [[nodiscard]] std::size_t unanswered() const override {
        const Lock lock(core_->mutex());
        return box_->unanswered();
    }

    void drop() override {
        const Lock lock(core_->mutex());
        box_->empty();
        box_->refusal = {};
    }

    [[nodiscard]] std::uint64_t retransmissions() const override { return core_->retransmissions() - before_; }

    /// In order with the work of other channels, which goes on; when that brings no answer, ahead of it all.
    bool turn_off() override {
        {
            Lock lock(core_->mutex());
            if (box_->closed) return true;  // the thread turns them off, and tells of it
            box_->empty();
            box_->refusal = {};
            for (const auto command : {interface::Command::disable, interface::Command::stop})
                box_->queued.push_back({{command, {}}, {}});
            core_->wake();
            box_->news.wait_for(lock, polite_patience,
                                [&] { return box_->closed || box_->refusal || box_->answers.size() == 2; });
            const bool off = box_->answers.size() == 2;
            box_->empty();
            if (off) return true;
        }
        return core_->wait_off(core_->shut_off(), std::chrono::seconds(2));
    }

private:
    std::shared_ptr<Core> core_;
    Identity identity_;
    std::shared_ptr<Mailbox> box_;
    std::uint64_t before_ = core_->retransmissions();
};

DeviceThread::DeviceThread(Settings settings) : core_(std::make_shared<Core>(std::move(settings))) { core_->start(); }

DeviceThread::~DeviceThread() { core_->end(); }

void DeviceThread::end() { core_->end(); }

std::unique_ptr<Commands> DeviceThread::channel(std::chrono::milliseconds patience) {
    return std::make_unique<Channel>(core_, patience);
}

std::uint64_t DeviceThread::shut_off() { return core_->shut_off(); }

bool DeviceThread::wait_off(std::uint64_t shut_off, std::chrono::milliseconds patience) {
    return core_->wait_off(shut_off, patience);
}

DeviceState DeviceThread::state() const { return core_->state(); }

}  // namespace haptogram::link
