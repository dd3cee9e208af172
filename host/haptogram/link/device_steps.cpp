// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device_steps.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <iterator>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {
namespace {

using Lock = std::unique_lock<std::mutex>;

constexpr std::chrono::milliseconds longest_read{5};       // until new requests and shut_off() are looked at again
constexpr std::chrono::milliseconds longest_off{20};       // the same while they are shut off already
constexpr std::chrono::milliseconds polite_patience{500};  // for what a channel ends by itself
constexpr std::chrono::hours long_wait{1};                 // for what is told of when it comes

std::exception_ptr shut_off_error() {
    return std::make_exception_ptr(
        Error(ErrorCode::cancelled, "board", "the outputs were shut off, and with them this work"));
}

}  // namespace

/// A request on its way, in one place at a time: queued by its channel, or handed to the client.
struct DeviceSteps::Item {
    Request request;
    std::function<void(const Reply&)> done;
};

/// What a channel and who steps share. All of it is guarded by the mutex.
struct DeviceSteps::Mailbox {
    struct Answer {
        Reply reply;
        std::function<void(const Reply&)> done;
    };
    std::deque<Item> queued;
    std::vector<Request> told;   // that get no answer
    std::deque<Answer> answers;  // that wait() has not handed out yet
    std::size_t under_way = 0;
    std::uint64_t epoch = 0;     // answers to requests of an earlier epoch are dropped
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

DeviceSteps::DeviceSteps(DeviceSettings settings) : settings_(std::move(settings)) {}

DeviceSteps::~DeviceSteps() = default;

void DeviceSteps::end() {
    {
        const Lock lock(mutex_);
        ending_ = true;
        close_all(shut_off_error());
    }
    urgent_ = true;
    work_.notify_all();
    news_.notify_all();
}

std::uint64_t DeviceSteps::shut_off() {
    const Lock lock(mutex_);
    close_all(shut_off_error());
    urgent_ = true;
    work_.notify_all();
    news_.notify_all();
    return ++state_.shut_offs;
}

bool DeviceSteps::wait_off(std::uint64_t shut_off, std::chrono::milliseconds patience) {
    Lock lock(mutex_);
    return clock().wait_for(lock, news_, patience, [&] { return state_.confirmed >= shut_off; });
}

DeviceState DeviceSteps::state() const {
    const Lock lock(mutex_);
    return state_;
}

std::shared_ptr<DeviceSteps::Mailbox> DeviceSteps::open(std::chrono::milliseconds patience, Identity& identity) {
    Lock lock(mutex_);
    const auto over = [&, before = state_.shut_offs] { return ending_ || state_.shut_offs != before; };
    clock().wait_for(lock, news_, patience, [&] { return state_.connection == Connection::connected || over(); });
    if (over()) std::rethrow_exception(shut_off_error());
    if (state_.connection != Connection::connected)
        throw Error(ErrorCode::device, "board", state_.trouble.empty() ? "it has not answered yet" : state_.trouble);
    identity = state_.identity;
    return boxes_.emplace_back(std::make_shared<Mailbox>());
}

void DeviceSteps::close(const std::shared_ptr<Mailbox>& box) {
    const Lock lock(mutex_);
    box->empty();
    std::erase(boxes_, box);
}

/// Drops what every channel has queued, and lets it fail. The mutex is held.
void DeviceSteps::close_all(const std::exception_ptr& why) {
    for (const auto& box : boxes_) {
        box->empty();
        box->closed = why;
        box->news.notify_all();
    }
    boxes_.clear();
}

/// Tells the caller what is so, and whoever waits for it.
template <class Change>
void DeviceSteps::tell(Change change) {
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

bool DeviceSteps::ending() const {
    const Lock lock(mutex_);
    return ending_;
}

/// Whether a step is due at once. The mutex is held.
bool DeviceSteps::has_work() const {
    if (phase_ == Phase::closed) return ending_;
    return urgent_ || ending_ ||
           std::ranges::any_of(boxes_, [](const auto& box) { return !box->queued.empty() || !box->told.empty(); });
}

void DeviceSteps::run() {
    while (const std::optional<Clock::Time> next = step()) {
        if (*next <= clock().now()) continue;
        Lock lock(mutex_);
        clock().wait_until(lock, work_, *next, [this] { return has_work(); });
    }
}

std::optional<Clock::Time> DeviceSteps::step() {
    try {
        if (phase_ == Phase::closed) {
            if (lost_ && ending()) return {};
            if (clock().now() < open_at_) return open_at_;
            open_port();
        }
        if (phase_ == Phase::turns_off || urgent_) {
            turn_off();
        } else if (phase_ == Phase::open && ending()) {
            client_.reset();
            port_.reset();
            return {};
        } else if (phase_ == Phase::serves) {
            return serve();
        } else {
            begin();
        }
    } catch (const Interrupted& urgent) {  // by what is to be done next, unless there is no port to do it through
        if (phase_ == Phase::closed) lose(urgent.what());
    } catch (const std::exception& error) {
        client_.reset();
        port_.reset();
        lose(error.what());
    }
    return clock().now();
}

void DeviceSteps::lose(const std::string& trouble) {
    phase_ = Phase::closed;
    lost_ = true;
    {
        const Lock lock(mutex_);
        close_all(std::make_exception_ptr(LinkLost("board", trouble)));
    }
    tell([&](DeviceState& state) {
        if (state.connection == Connection::connected) state.connection = Connection::lost;
        state.trouble = trouble;
    });
    open_at_ = clock().now() + settings_.reconnect_pause;
}

void DeviceSteps::open_port() {
    port_ = settings_.open();
    client_.emplace(*port_);
    urgent_ = urgent_ || had_session_;  // what ended the last session may have left the outputs on
    phase_ = Phase::open;
}

/// Turns the outputs off ahead of everything. Nothing is waited for as long as the policy would.
void DeviceSteps::turn_off() {
    try {
        if (phase_ != Phase::turns_off) {
            phase_ = Phase::turns_off;
            {
                const Lock lock(mutex_);
                urgent_ = false;
                asked_off_ = state_.shut_offs;
            }
            client_->set_interrupt([] { return 1U; });
            client_->shut_off();
        }
        if (!client_->is_off()) client_->exchange(longest_off);
        if (!client_->is_off()) return;
    } catch (const Error&) {  // its port is gone: what can be done was done
    }
    if (!client_->end_shut_off()) throw LinkLost("board", not_confirmed(watchdog_ms_));
    phase_ = Phase::open;
    tell([&](DeviceState& state) {
        state.status.enabled = false;
        state.confirmed = std::max(state.confirmed, asked_off_);
    });
}

/// Begins a session. @throws Error when the link is lost
void DeviceSteps::begin() {
    if (phase_ == Phase::open) {
        phase_ = Phase::begins;
        client_->set_interrupt([this] { return urgent_ ? 1U : 0U; });
        client_->begin([this] { phase_ = Phase::serves; });
    }
    client_->exchange(longest_read);
    if (phase_ != Phase::serves) return;
    had_session_ = true;
    asking_ = false;
    next_status_ = clock().now();
    tell([&](DeviceState& state) {
        // Why outputs were shut off stays; why there was no device is over.
        if (state.connection != Connection::connected) state.trouble.clear();
        state.connection = Connection::connected;
        state.identity = client_->identity();
    });
    client_->keep_alive_every(keep_alive_pause(watchdog_ms_));
}

/// Speaks to the device. @return when there is something to do again  @throws Error when the link is lost
Clock::Time DeviceSteps::serve() {
    tell_requests();
    take_requests();
    if (!asking_ && clock().now() >= next_status_) {
        ask_for_status();
        next_status_ = clock().now() + keep_alive_pause(watchdog_ms_);
    }
    if (client_->unanswered() == 0) return next_status_;
    client_->exchange(longest_read);
    retransmissions_ = client_->retransmissions();
    return clock().now();
}

/// Sends what the channels only tell, without the mutex: a port that takes no bytes must not hold up shut_off().
void DeviceSteps::tell_requests() {
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
        client_->tell(std::move(request));
    }
    if (!told.empty()) client_->flush();
}

/// Hands requests of the channels in turn to the client, as many as its window holds.
void DeviceSteps::take_requests() {
    const Lock lock(mutex_);
    for (bool found = true; found && !urgent_;) {
        found = false;
        for (const auto& box : boxes_) {
            if (client_->unanswered() >= client_->window()) return;
            if (box->queued.empty()) continue;
            found = true;
            Item item = std::move(box->queued.front());
            box->queued.pop_front();
            ++box->under_way;
            hand_over(box, std::move(item));
        }
    }
}

void DeviceSteps::hand_over(const std::shared_ptr<Mailbox>& box, Item item) {
    const std::uint64_t epoch = box->epoch;
    client_->submit(
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

void DeviceSteps::ask_for_status() {
    asking_ = true;
    client_->submit({interface::Command::status, {}}, [this](const Reply& reply) {
        asking_ = false;
        const Status status = to_status(reply.data);
        watchdog_ms_ = status.watchdog_ms;
        client_->keep_alive_every(keep_alive_pause(watchdog_ms_));
        tell([&](DeviceState& state) { state.status = status; });
    });
}

/// Hands requests to who steps, and waits for their answers.
class DeviceSteps::Channel final : public Commands {
public:
    Channel(std::shared_ptr<DeviceSteps> steps, std::chrono::milliseconds patience)
        : steps_(std::move(steps)), box_(steps_->open(patience, identity_)) {}
    ~Channel() override { steps_->close(box_); }

    [[nodiscard]] const Identity& identity() const override { return identity_; }
    [[nodiscard]] Clock& clock() override { return steps_->clock(); }

    void submit(Request request, std::function<void(const Reply&)> done) override {
        const Lock lock(steps_->mutex_);
        if (box_->closed) std::rethrow_exception(box_->closed);
        box_->queued.push_back({std::move(request), std::move(done)});
    }

    void tell(Request request) override {
        const Lock lock(steps_->mutex_);
        if (box_->closed) std::rethrow_exception(box_->closed);
        box_->told.push_back(std::move(request));
    }

    void flush() override { steps_->work_.notify_all(); }

    void wait(std::size_t most_unanswered) override {
        flush();
        Lock lock(steps_->mutex_);
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
            clock().wait_for(lock, box_->news, long_wait, [&] {
                return box_->closed || box_->refusal || !box_->answers.empty() || box_->unanswered() <= most_unanswered;
            });
        }
    }

    [[nodiscard]] std::size_t unanswered() const override {
        const Lock lock(steps_->mutex_);
        return box_->unanswered();
    }

    void drop() override {
        const Lock lock(steps_->mutex_);
        box_->empty();
        box_->refusal = {};
    }

    [[nodiscard]] std::uint64_t retransmissions() const override { return steps_->retransmissions_ - before_; }

    /// In order with the work of other channels, which goes on; when that brings no answer, ahead of it all.
    bool turn_off() override {
        {
            Lock lock(steps_->mutex_);
            if (box_->closed) return true;  // who steps turns them off, and tells of it
            box_->empty();
            box_->refusal = {};
            for (const auto command : {interface::Command::disable, interface::Command::stop})
                box_->queued.push_back({{command, {}}, {}});
            flush();
            clock().wait_for(lock, box_->news, polite_patience,
                             [&] { return box_->closed || box_->refusal || box_->answers.size() == 2; });
            const bool off = box_->answers.size() == 2;
            box_->empty();
            if (off) return true;
        }
        return steps_->wait_off(steps_->shut_off(), std::chrono::seconds(2));
    }

private:
    std::shared_ptr<DeviceSteps> steps_;
    Identity identity_;
    std::shared_ptr<Mailbox> box_;
    std::uint64_t before_ = steps_->retransmissions_;
};

std::unique_ptr<Commands> DeviceSteps::channel(std::chrono::milliseconds patience) {
    return std::make_unique<Channel>(shared_from_this(), patience);
}

}  // namespace haptogram::link
