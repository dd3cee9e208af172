// SPDX-License-Identifier: Apache-2.0
#include "studio.hpp"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "answers.hpp"
#include "assets.hpp"
#include "board_json.hpp"
#include "computing.hpp"
#include "failure.hpp"
#include "guest.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/port_rates.hpp"
#include "haptogram/link/to_json.hpp"
#include "live.hpp"
#include "local_server.hpp"
#include "messages.hpp"
#include "page_sight.hpp"
#include "player.hpp"
#include "scenes.hpp"
#include "study.hpp"
#include "worker.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds scene_pause{30};  // between scenes of a live session that a page is sent

/// The one server with its pages, scenes and board. Its callbacks run in the server's thread.
class Studio {
public:
    Studio(const Options& options, Assets assets)
        : assets_(std::move(assets)),
          server_(options.port == 0 ? std::initializer_list<std::uint16_t>{usual_port, 0}
                                    : std::initializer_list<std::uint16_t>{options.port},
                  "port", {}),
          player_({.told = [this](const link::DeviceState& state) { server_.post([this, state] { tell(state); }); },
                   .work =
                       [this](ordered_json report) {
                           server_.post([this, report = std::move(report)] { tell_work(report); });
                       }}) {
        placed_ = options.placed;
        if (!options.project.empty()) scenes_.open(options.project);
        name_ = options.project.empty() ? "example" : options.project.filename().string();
        folder_ = options.project.empty() ? std::filesystem::current_path()
                                          : std::filesystem::absolute(options.project).parent_path();
    }

    [[nodiscard]] std::uint16_t port() const { return server_.port(); }

    void run(const serve::Access& access, const std::function<bool()>& ended) {
        server_.run(access,
                    {.request = [this](Request request, const Reply& reply) { answer(std::move(request), reply); },
                     .opened = [this](std::shared_ptr<Page> page) { open(std::move(page)); },
                     .message = [this](Page& page, std::string text) { take(page, text); },
                     .closed = [this](Page& page) { close(page); },
                     .tick = [this, &ended] { return tick(ended); }});
    }

private:
    struct Visitor {
        std::shared_ptr<Page> page;
        PageSight sight{link::machine_clock()};
    };
    struct Stop {
        std::uint64_t page;
        std::optional<std::uint64_t> number;  ///< of the DeviceThread; none: until the guest has ended
        std::uint32_t n;
        Clock::time_point asked = Clock::now();
    };

    /// A guest under way.
    struct UnderWay {
        std::uint64_t page = 0, number = 0;
        bool live = false;      ///< not a study
        bool plays = false;     ///< on a board
        bool borrowed = false;  ///< that is the studio's
        bool ends = false;      ///< it was asked to
        bool on = false;        ///< it has outputs on
        Child::Command command{};
        std::shared_ptr<TemporaryFolder> folder{};  ///< that it runs in, if it is of its own
        Clock::time_point drawn{};                  ///< when a scene was sent last
        std::unique_ptr<Guest> session{};           ///< none until its port is free
    };

    // Requests.

    void answer(Request request, const Reply& reply) {
        if (request.path == "/api/bitstream")
            computing_.bitstream(request, reply, placed_);
        else if (!computing_.write(request, reply))
            reply(answer_at_once(std::move(request)));
    }

    Answer answer_at_once(Request request) {
        if (request.path == "/api/hello") return {.body = to_text(hello())};
        if (request.path == "/api/stop" && request.method == "POST") {
            ++stops_asked_;
            const bool connected = player_.stop().has_value() || guest_plays();
            end_guest();
            return {.body = to_text({{"connected", connected}})};
        }
        if (request.path.starts_with("/api/")) {
            const std::string path = request.path;
            const std::optional<Answer> answer = studio::answer_at_once(scenes_, std::move(request));
            return answer ? *answer : error_answer(404, "there is no " + path);
        }
        const auto asset = assets_.find(request.path);
        if (asset == assets_.end()) return error_answer(404, "there is no such file");
        const bool gzip = request.takes_gzip && !asset->second.gzip.empty();
        return {200, asset->second.type, gzip ? asset->second.gzip : asset->second.plain, gzip};
    }

    ordered_json hello() const {
        ordered_json hello = hello_json(scenes_, name_);
        hello["ports"] = link::to_json(link::available_ports());
        return hello;
    }

    // Pages.

    void open(std::shared_ptr<Page> page) {
        page->send(to_text(device_json()));
        const std::uint64_t number = page->number();
        visitors_[number].page = std::move(page);
    }

    void close(Page& page) {
        computing_.forget(page);
        sessions_.forget(page.number());
        live_starts_.forget(page.number());
        visitors_.erase(page.number());
        if (driver_ == page.number())
            outputs_off(page.trouble().empty() ? "the page that drove the board was closed" : page.trouble());
        if (guest_ && guest_->page == page.number()) end_guest();
    }

    void take(Page& page, const std::string& text) {
        const auto visitor = visitors_.find(page.number());
        if (visitor == visitors_.end()) return;
        visitor->second.sight.heard();
        std::optional<Message> message;
        if (const auto error = error_of([&] { message = read_message(text); })) {
            page.send(to_text({{"t", "error"}, {"error", *error}}));
            page.close(error->at("message"));
            return;
        }
        std::visit(
            [&](const auto& each) {
                if constexpr (requires { computing_.ask(visitor->second.page, each); })
                    computing_.ask(visitor->second.page, each);
                else
                    act(visitor->second, each);
            },
            *message);
    }

    // The board: what pages ask of it.

    void act(Visitor& visitor, const ConnectMessage& message) {
        tell_failure(*visitor.page, message.n, [&] {
            require_own_port();
            if (message.port == "virtual" || message.port == "virtual-rtl")
                player_.connect_virtual(instrument_of(scenes_.find(message.scene)->settings).core,
                                        message.port == "virtual" ? "reference" : "rtl");
            else
                player_.connect(message.port, rate_of(message));
            state_ = {};
            left_on_ = false;
            port_ = message.port;
            baud_ = message.baud;
            broadcast(device_json());
        });
    }

    void act(Visitor& visitor, const DisconnectMessage& message) {
        tell_failure(*visitor.page, message.n, [&] {
            require_own_port();
            player_.disconnect();
            driver_ = {};
            left_on_ = false;
            broadcast(device_json());
        });
    }

    void act(Visitor& visitor, const UploadMessage& message) {
        tell_failure(*visitor.page, message.n, [&] { (void)player_.upload(scenes_.find(message.scene)); });
    }

    void act(Visitor& visitor, const PlayMessage& message) {
        drive(visitor, message.n,
              [&] { return player_.play(scenes_.find(message.scene), message.triggers, message.lines); });
    }

    void act(Visitor& visitor, const TriggerMessage& message) {
        tell_failure(*visitor.page, message.n, [&] {
            require_no_other_driver(visitor);
            player_.trigger(message.number);
        });
    }

    void act(Visitor& visitor, const StreamMessage& message) {
        drive(visitor, message.n, [&] { return player_.stream(scenes_.find(message.scene), message.index); });
    }

    void act(Visitor& visitor, const IntensityMessage& message) {
        tell_failure(*visitor.page, message.n, [&] {
            require_no_other_driver(visitor);
            player_.set_intensity(message.value);
            broadcast(device_json());
        });
    }

    void act(Visitor& visitor, const ModulateMessage& message) {
        tell_failure(*visitor.page, message.n, [&] {
            require_no_other_driver(visitor);
            player_.modulate(scenes_.find(message.scene));
        });
    }

    /// Work that turns the outputs on, for the one page that then keeps them on. @param work  returns its number
    template <class Work>
    void drive(Visitor& visitor, std::uint32_t n, Work work) {
        tell_failure(*visitor.page, n, [&] {
            require_no_other_driver(visitor);
            driver_work_ = work();
            driver_ = visitor.page->number();
            visitor.sight.seen();
        });
    }

    void require_no_other_driver(const Visitor& visitor) const {
        if (driver_ && *driver_ != visitor.page->number())
            throw Error(ErrorCode::device, "board", "another page drives it; press STOP there or here first");
        if (guest_plays()) throw Error(ErrorCode::device, "board", "a study or a live session plays; stop it first");
    }

    [[nodiscard]] static std::optional<std::uint32_t> rate_of(const ConnectMessage& message) {
        if (message.baud == 0) return {};
        if (message.baud < 300 || message.baud > 12'000'000)
            throw bad_argument("baud",
                               fmt::format("found {}, expected 300 to 12000000, or 0 to find it", message.baud));
        return message.baud;
    }

    void act(Visitor& visitor, const StopMessage& message) {
        ++stops_asked_;
        driver_ = {};
        const std::optional<std::uint64_t> number = player_.stop();
        if (number || guest_plays())
            stops_.push_back({visitor.page->number(), guest_plays() ? std::nullopt : number, message.n});
        else
            tell_off({visitor.page->number(), {}, message.n}, true);
        end_guest();
    }

    // Guests: studies and live sessions. One page runs one; a participant's answers come from there alone.

    /// Whether a session may have a board of its own playing.
    [[nodiscard]] bool guest_plays() const { return guest_ && guest_->plays; }

    void end_guest() {
        if (!guest_) return;
        guest_->ends = true;
        if (guest_->session) guest_->session->end();
    }

    void require_own_port() const {
        if (guest_ && guest_->borrowed)
            throw Error(ErrorCode::device, "board", "a study or a live session plays on it; stop that first");
    }

    void act(Visitor& visitor, const StudiesMessage& message) {
        sessions_.ask(visitor.page->number(), [this, page = visitor.page, n = message.n] {
            tell_failure(*page, n, [&] {
                page->send(to_text({{"t", "studies"},
                                    {"n", n},
                                    {"folder", folder_.string()},
                                    {"protocols", study_protocols(folder_)}}));
            });
        });
    }

    void act(Visitor& visitor, const StudyMessage& message) {
        tell_failure(*visitor.page, message.n, [&] {
            require_no_guest();
            UnderWay next{.page = visitor.page->number(), .number = ++guest_number_};
            std::optional<BoardPort> port;
            if (!message.port.empty()) {
                require_no_other_driver(visitor);
                next.plays = true;
                next.borrowed = message.port == "studio";
                if (!next.borrowed && player_.connected() && message.port == port_)
                    throw Error(ErrorCode::device, message.port, "the studio has this port; choose the studio's board");
                port = BoardPort{message.port, {}};
            }
            // Before the port is lent, as it may fail.
            Child::Command command = study_command(message, folder_, port);
            if (next.borrowed) {
                const BoardPort lent = player_.lend(
                    [this, number = next.number] { server_.post([this, number] { begin_guest(number); }); });
                command = study_command(message, folder_, lent);
            }
            next.command = std::move(command);
            take_in(std::move(next), message.n);
        });
    }

    void require_no_guest() const {
        if (guest_) throw Error(ErrorCode::failed, "session", "a study or a live session is under way; stop it first");
    }

    void act(Visitor& visitor, const LiveMessage& message) {
        // What the document names is opened in another thread, as it may take a while.
        live_starts_.ask(visitor.page->number(), [this, page = visitor.page, message, stops = stops_asked_] {
            tell_failure(*page, message.n, [&] {
                server_.post([this, number = page->number(), n = message.n, stops,
                              start = prepare_live(scenes_, message)] { begin_live(number, n, stops, start); });
            });
        });
    }

    /// @param stops  that had been asked for when the session was
    void begin_live(std::uint64_t page, std::uint32_t n, std::uint64_t stops, const LiveStart& start) {
        const auto visitor = visitors_.find(page);
        if (visitor == visitors_.end()) return;
        tell_failure(*visitor->second.page, n, [&] {
            if (stops != stops_asked_) throw Error(ErrorCode::cancelled, "session", "STOP was pressed before it began");
            require_no_guest();
            require_no_other_driver(visitor->second);
            if (player_.intensity() != 1.0)
                throw Error(
                    ErrorCode::failed, "session",
                    "a live session plays at full strength, and the intensity is lower; move it to 100 % first");
            UnderWay next{.page = page, .number = ++guest_number_, .live = true, .plays = true, .borrowed = true};
            const BoardPort lent =
                player_.lend([this, number = next.number] { server_.post([this, number] { begin_guest(number); }); });
            next.command = live_command(start, lent);
            next.folder = start.folder;
            take_in(std::move(next), n);
            if (!start.left_out.empty()) tell_guest({{"show", "note"}, {"text", start.left_out}});
        });
    }

    void take_in(UnderWay next, std::uint32_t n) {
        guest_ = std::move(next);
        if (!guest_->borrowed) begin_guest(guest_->number);
        if (guest_->plays) {
            driver_ = {};
            player_.stop();  // one thing plays at a time, so that one page is watched
        }
        if (guest_->plays) broadcast(device_json());
        tell_guest({{"show", "begun"}, {"n", n}});
    }

    /// Once its port is free.
    void begin_guest(std::uint64_t number) {
        if (!guest_ || guest_->number != number) return;
        if (guest_->ends) {
            guest_ended(0);  // nothing of it has played
            return;
        }
        guest_->session = std::make_unique<Guest>(std::move(guest_->command), guest_settings(number));
        if (guest_->live) drive_for_guest();
    }

    /// As long as a live session lasts, its page must be alive and in sight, as one that plays; of a study,
    /// while a trial's questions are asked its stimulus plays: then the page must be alive and in sight, as one that
    /// plays. At other times the outputs are off.
    void watch_guest(const ordered_json& shown) {
        if (guest_->live || !guest_->plays || shown["show"] == "note" || shown["show"] == "wrong") return;
        driver_ = {};
        if (shown["show"] == "ask")
            drive_for_guest();
        else
            tell_guest_on(false);
    }

    /// The guest's page keeps the outputs on.
    void drive_for_guest() {
        tell_guest_on(true);
        const auto visitor = visitors_.find(guest_->page);
        if (visitor == visitors_.end()) return;
        driver_ = guest_->page;
        driver_work_ = 0;  // none of the player's
        visitor->second.sight.seen();
    }

    void tell_guest_on(bool on) {
        if (std::exchange(guest_->on, on) != on) broadcast(device_json());
    }

    [[nodiscard]] Guest::Settings guest_settings(std::uint64_t number) {
        return {.shown =
                    [this, number](ordered_json shown) {
                        server_.post([this, number, shown = std::move(shown)]() mutable {
                            if (!guest_ || guest_->number != number || leaves_out(shown)) return;
                            watch_guest(shown);
                            tell_guest(std::move(shown));
                        });
                    },
                .ended =
                    [this, number](std::optional<int> code) {
                        server_.post([this, number, code] {
                            if (guest_ && guest_->number == number) guest_ended(code);
                        });
                    }};
    }

    void act(Visitor& visitor, const AnswerMessage& message) {
        if (guest_ && guest_->session && guest_->page == visitor.page->number())
            guest_->session->answer(message.number, message.text);
    }

    void act(Visitor& visitor, const LeaveMessage&) {
        if (guest_ && guest_->session && guest_->page == visitor.page->number()) guest_->session->leave();
    }

    /// A page draws no more scenes than it is asked to, whatever the rate of the tracker.
    bool leaves_out(const ordered_json& shown) {
        if (!shown.contains("scene")) return false;
        const Clock::time_point now = Clock::now();
        if (now - guest_->drawn < scene_pause) return true;
        guest_->drawn = now;
        return false;
    }

    void tell_guest(ordered_json shown) {
        const auto visitor = visitors_.find(guest_->page);
        if (visitor == visitors_.end()) return;
        visitor->second.page->send(to_text({{"t", guest_->live ? "live" : "study"}, {"shown", std::move(shown)}}));
    }

    void guest_ended(std::optional<int> code) {
        tell_guest({{"show", "ended"}, {"code", code ? ordered_json(*code) : ordered_json()}});
        const bool borrowed = guest_->borrowed, plays = guest_->plays;
        constexpr int not_confirmed = 4;
        const bool confirmed = code && *code != not_confirmed;
        left_on_ = borrowed && guest_->on && !confirmed;
        if (guest_plays() && driver_ == guest_->page) driver_ = {};
        guest_.reset();
        std::optional<std::uint64_t> off;
        if (borrowed) {
            state_ = {};
            player_.take_back();
            // Whatever the guest left on, as from now on this program keeps the board's watchdog quiet.
            off = player_.stop();
        }
        if (plays) broadcast(device_json());
        // Its runner turned the outputs off before it ended, but for one that says that nobody confirmed it, or that
        // was killed. Then the board is asked, or, if it is not ours, its watchdog does it, and nobody says so.
        std::erase_if(stops_, [&](Stop& stop) {
            if (stop.number) return false;
            if (!confirmed && off) {
                stop.number = off;
                return false;
            }
            tell_off(stop, confirmed);
            return true;
        });
    }

    static void act(Visitor& visitor, const BeatMessage& message) {
        visitor.sight.beat(message.hidden);
        visitor.page->send(to_text({{"t", "beat"}}));  // the page, too, wants a sign of life
    }

    // The board: what it tells, and what keeps its outputs on.

    /// The one state of the outputs, whoever has them on.
    [[nodiscard]] ordered_json device_json() const {
        ordered_json json = own_board_json();
        if (guest_plays()) {
            json["guest"] = guest_->live ? "live session" : "study";
            if (guest_->borrowed || guest_->on) json["status"]["outputs"] = guest_->on ? "on" : "off";
        } else if (left_on_) {
            json["status"]["outputs"] = "unknown";
        }
        return json;
    }

    [[nodiscard]] ordered_json own_board_json() const {
        if (guest_ && guest_->borrowed) return {{"t", "device"}, {"connection", "lent"}, {"port", port_}};
        if (!player_.connected()) return {{"t", "device"}, {"connection", "none"}};
        std::uint32_t baud = baud_;
        if (port_.starts_with("virtual"))
            baud = 0;
        else if (baud == 0 && state_.connection != link::Connection::connecting)
            baud = link::remembered_rate(port_).value_or(0);
        return studio::device_json(state_, port_, baud, player_.intensity());
    }

    void tell(const link::DeviceState& state) {
        state_ = state;
        if (state.connection == link::Connection::connected) left_on_ = false;  // the board tells itself
        std::erase_if(stops_, [&](const Stop& stop) {
            if (!stop.number || state.confirmed < *stop.number) return false;
            tell_off(stop, true);
            return true;
        });
        broadcast(device_json());
    }

    void tell_off(const Stop& stop, bool confirmed) {
        const auto visitor = visitors_.find(stop.page);
        if (visitor == visitors_.end()) return;
        visitor->second.page->send(to_text({{"t", "off"}, {"n", stop.n}, {"confirmed", confirmed}}));
    }

    void tell_work(const ordered_json& report) {
        if (report["t"] != "progress" && report["number"] == driver_work_) driver_ = {};
        broadcast(report);
    }

    void outputs_off(const std::string& why) {
        ++stops_asked_;
        driver_ = {};
        player_.stop();
        if (guest_plays()) end_guest();
        broadcast({{"t", "notice"}, {"message", "Outputs off: " + why + "."}});
    }

    bool tick(const std::function<bool()>& ended) {
        const Clock::time_point now = Clock::now();
        if (driver_)
            if (const auto why = visitors_.at(*driver_).sight.too_long()) outputs_off(*why);
        std::erase_if(stops_, [&](const Stop& stop) {
            if (now - stop.asked < std::chrono::seconds(2)) return false;
            tell_off(stop, false);
            return true;
        });
        const bool over = ended();
        if (over) computing_.end();
        return !over;
    }

    void broadcast(const ordered_json& message) {
        for (const auto& [number, visitor] : visitors_) visitor.page->send(to_text(message));
    }

    Assets assets_;
    std::string name_;
    std::filesystem::path folder_;  // of the project: where protocols and results are
    std::filesystem::path placed_;  // boards' designs, for bitstreams
    Scenes scenes_;
    serve::Server server_;
    std::map<std::uint64_t, Visitor> visitors_;
    std::optional<std::uint64_t> driver_;  // the page that keeps the outputs on
    std::uint64_t driver_work_ = 0;        // and what it asked to be played
    std::vector<Stop> stops_;              // that the board has not confirmed
    link::DeviceState state_;
    std::string port_;
    std::uint32_t baud_ = 0;  // 0: it is found
    Player player_;           // after what it tells of
    Computing computing_{scenes_, [this](std::function<void()> work) { server_.post(std::move(work)); }};
    std::uint64_t stops_asked_ = 0;  // what was asked for before one must not begin after it
    Worker sessions_, live_starts_;
    std::uint64_t guest_number_ = 0;
    bool left_on_ = false;           // by the last guest, as far as anybody knows
    std::optional<UnderWay> guest_;  // the last, so that it ends before the board that it may play on
};

}  // namespace

void run(const Options& options,
         const std::function<void(const std::string& address, const std::string& missing)>& listening,
         const std::function<bool()>& ended) {
    const std::filesystem::path page = options.page.empty() ? own_data("studio") : options.page;
    std::error_code ignored;
    const bool missing = options.page.empty() && !std::filesystem::exists(page / "page.json", ignored);
    Studio studio(options, missing ? assets_without_page(page.string()) : load_assets(page));
    const serve::Access access = serve::access_for(studio.port(), make_token());
    listening(fmt::format("http://{}/#{}", access.hosts.front(), access.token),
              missing ? "the page was not built: it needs node and the packages of extras/studio/web; run tools/setup, "
                        "then build again"
                      : "");
    studio.run(access, ended);
}

}  // namespace haptogram::studio
