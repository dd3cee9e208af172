// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "haptogram/link/device_thread.hpp"
#include "haptogram/link/intensity.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/verbs/trigger_reader.hpp"
#include "scenes.hpp"
#include "virtual_board.hpp"

namespace haptogram::studio {

/// The one board that the studio drives. Every function returns at once; the work is done in a thread of its own, one
/// after the other. stop() overtakes all of it.
class Player {
public:
    struct Settings {
        /// Told in some thread of each status of the board, and of each change. It must return soon.
        std::function<void(const link::DeviceState&)> told;
        /// Told in some thread what happens to work: {"t": "progress", "done", "stopped" or "failed", "work",
        /// "number", …}.
        std::function<void(nlohmann::ordered_json)> work;
        link::Clock& clock = link::machine_clock();
    };

    explicit Player(Settings settings);
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;
    /// Outputs off, and the end of the connection; waits some two seconds for it at most.
    ~Player();

    /// Connects to a port, in place of the present one. @param baud  its rate; none: it is found
    void connect(const std::string& port, std::optional<std::uint32_t> baud);
    /// Starts a virtual board, as VirtualBoard has it, and connects to it.
    void connect_virtual(const Core& core, const std::string& model);
    /// Outputs off, and lets go of the board; nothing of that is waited for.
    void disconnect();
    [[nodiscard]] bool connected() const;

    /// Turns the outputs off and lets go of the port, so that another program can have it until take_back().
    /// @param free  told in some thread once it can
    /// @throws Error{device} without a connection, or while a virtual board is still starting
    BoardPort lend(std::function<void()> free);
    /// Connects again to the port that was lent.
    void take_back();

    /// Brings a scene's image into the board's memories.
    /// @return the number by which the work is told of
    /// @throws Error{device} without a connection
    std::uint64_t upload(std::shared_ptr<const Scene> scene);
    /// The same, then plays it until its end or stop().
    /// @param parts  of it, if it waits for trigger() and the board's pin, each of which starts one
    /// @param lines  a named pipe whose lines start them, too; "": none. What they do not say is told as progress
    /// @throws Error{bad_argument} naming "lines" when there is no such pipe, or the parts are not all of the scene's
    std::uint64_t play(std::shared_ptr<const Scene> scene, std::vector<TriggeredPart> parts = {},
                       const std::string& lines = "");
    /// Starts a part of what plays, at once. @throws Error{device} when nothing waits for it
    void trigger(std::size_t part);

    /// The same, then plays one record until the next call names another. Calls while it plays cost one message each.
    /// @param index  of the record, from 1 on
    /// @throws Error{bad_argument} for a record that the scene does not have, Error{device} while another scene streams
    std::uint64_t stream(std::shared_ptr<const Scene> scene, std::uint32_t index);

    /// How strong everything plays from now on, also what plays already; of an image's amplitudes, 0…1.
    /// @throws Error{bad_argument} for another "intensity"
    void set_intensity(double factor);
    [[nodiscard]] double intensity() const { return intensity_; }

    /// Modulates what plays as a scene is, from now on.
    /// @throws Error{device} when no scene plays; Error{bad_input} when the two differ in more than their modulation,
    /// or
    ///         have no amplitudes that could be modulated
    void modulate(std::shared_ptr<const Scene> scene);

    /// Outputs off: what waits is dropped, what is under way is cut off. May be called from any thread.
    /// @return a number; the outputs are off once the state's `confirmed` has reached it. None without a connection
    std::optional<std::uint64_t> stop();

private:
    class Scrub;
    class Fired;
    struct Work {
        std::string name;
        std::function<nlohmann::ordered_json(link::Commands&, std::uint64_t number)> act;
        std::shared_ptr<Scrub> scrub{};  ///< of a stream
        std::uint64_t number = 0;
        std::uint64_t stops = 0;  ///< that there had been when it was asked for
    };
    using Open = std::function<std::unique_ptr<link::Transport>()>;
    void connect(Open open, BoardPort port, std::shared_ptr<VirtualBoard> board);
    void let_go(std::shared_ptr<link::DeviceThread> device, std::shared_ptr<VirtualBoard> board,
                std::function<void()> free);
    std::uint64_t ask(Work work);
    void run();
    void tell_progress(const char* name, std::uint64_t number, double fraction, std::string_view stage) const;
    link::Watch watch(link::Commands& device, const char* name, std::uint64_t number,
                      std::shared_ptr<const Scene> scene, link::Intensity& intensity, std::function<void()> changed);
    [[nodiscard]] std::unique_ptr<TriggerReader> reader(const Scene& scene, LiveText* lines,
                                                        std::uint64_t number) const;
    void bring(link::Commands& device, const char* name, std::uint64_t number, const Scene& scene,
               nlohmann::ordered_json& report) const;

    Settings settings_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Work> waiting_;
    bool over_ = false;
    std::atomic<double> intensity_ = 1.0;
    std::uint64_t stops_ = 0, asked_ = 0;
    std::shared_ptr<Fired> fired_;                       // of what plays, if it waits for triggers
    std::shared_ptr<Scrub> scrub_;                       // what a stream under way plays
    std::shared_ptr<const Scene> playing_, modulation_;  // what plays, and whose modulation it is to have
    Open open_;                                          // of the present connection
    BoardPort port_;                                     // of a board that is not ours
    std::shared_ptr<VirtualBoard> board_;
    std::shared_ptr<link::DeviceThread> device_;
    std::shared_ptr<std::atomic<bool>> given_up_ = std::make_shared<std::atomic<bool>>(false);  // no rate is looked for
    std::shared_ptr<std::atomic<bool>> listened_to_;  // whether the present device is told of
    std::vector<std::future<void>> let_go_;           // boards that end, each in a thread of its own
    std::thread thread_;
};

}  // namespace haptogram::studio
