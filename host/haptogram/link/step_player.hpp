// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/format/image.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/device_state.hpp"
#include "haptogram/link/intensity.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {

/// What is told of work.
struct StepWork {
    enum class Stage { uploads, plays, done, stopped, failed };
    std::string name;          ///< "upload", "play" or "stream"
    std::uint64_t number = 0;  ///< as the call returned it
    Stage stage = Stage::done;
    double fraction = 0.0;  ///< of the upload
    double seconds = 0.0;   ///< for which it has played
    std::optional<Uploaded> uploaded{};
    std::optional<Played> played{};
    std::optional<Error> error{};
};

/// Plays on a device for a program that has neither threads nor the right to wait, as a page in a browser. Every
/// function returns at once. What is due is done by step(), which must be called often: at least so often as the
/// watchdog must hear something. Its transport gives what has arrived, and never waits.
///
/// One piece of work is done after the other. stop() overtakes all of it, as DeviceThread::shut_off() does.
class StepPlayer {
public:
    struct Settings {
        /// Told of each status and each change of the device's state.
        std::function<void(const DeviceState&)> told;
        /// Told what becomes of work.
        std::function<void(const StepWork&)> work;
        std::uint16_t watchdog_ms = 500;  ///< outputs go off when step() was not called for so long
    };

    /// Begins a session. @param line  open
    StepPlayer(std::unique_ptr<Transport> line, Settings settings);

    /// Sends what is due, and takes what has arrived. @param passed  since the call before
    void step(std::chrono::microseconds passed);

    /// Brings an image into the device's memories. @return the number by which the work is told of
    /// @throws Error{device} while there is no connection, Error{bad_input} for an image that does not fit the device
    std::uint64_t upload(std::shared_ptr<const Image> image);
    /// The same, then plays it until its end or stop().
    /// @param parts  of it, if it waits for trigger() and the device's pin, each of which starts one
    /// @throws as require_parts() does
    std::uint64_t play(std::shared_ptr<const Image> image, std::vector<TriggeredPart> parts = {});
    /// Starts a part of the present image, at once. @throws Error{device} when no part waits for a trigger
    void trigger(std::size_t part);
    /// The same, then plays one record until the next call names another. The same image is brought only once.
    /// @throws Error{bad_argument} for a record that the image does not have, Error{device} while another image streams
    std::uint64_t stream(std::shared_ptr<const Image> image, std::uint32_t index);

    /// How strong everything plays from now on, also what plays already; of an image's amplitudes, 0…1.
    /// @throws Error{bad_argument} for another "intensity"
    void set_intensity(double factor);
    [[nodiscard]] double intensity() const { return wanted_; }
    /// Modulates what plays as another image is, from now on.
    /// @throws Error{device} when nothing plays from a sequence; Error{bad_input} when the two differ in more than
    /// their modulation, or have no amplitudes that could be modulated
    void modulate(const Image& image);

    /// Outputs off: what waits is dropped, what is under way is cut off. Repeated by step() until the device has
    /// confirmed it. @return the outputs are off once the state's `confirmed` has reached it
    std::uint64_t stop();
    /// The line is gone. What is under way fails, and nothing is sent any more.
    void lose(const std::string& why);

    [[nodiscard]] const DeviceState& state() const { return state_; }
    /// Whether work is under way, or waits, that has outputs on or will turn them on.
    [[nodiscard]] bool drives() const;

private:
    enum class Phase { uploads, weakens, begins, plays, ends };
    struct Work {
        StepWork told;
        std::shared_ptr<const Image> image;
        std::uint16_t index = 0;  ///< of the record that streams; 0: the sequence
        Phase phase = Phase::uploads;
        std::optional<UploadSteps> upload{};
        std::optional<Intensity> intensity{};
        double factor = 1.0;      ///< that the device has
        std::uint16_t shown = 0;  ///< index that the device plays
        Status before{};          ///< of when it began to play
        bool heard = false;       ///< a status, while it plays, that was not looked at yet
        std::chrono::nanoseconds begun{};
        unsigned silent = 0;  ///< statuses in a row that say that all is over
        std::vector<TriggeredPart> parts{};
        std::optional<std::size_t> triggered{};  ///< that is to start
    };
    /// Requests under way whose replies the work needs all together.
    struct Batch {
        std::size_t unanswered = 0;
        std::vector<Reply> replies;
        std::optional<Error> refused{};
    };

    void begin_session();
    void turn_off(std::chrono::microseconds passed);
    void ask_for_status();
    void take_status(const Status& status);
    void ask(std::vector<Request> requests);
    void advance();
    void advance_upload();
    void begin_to_play();
    void go_on_playing();
    void end(StepWork::Stage stage, std::optional<Error> error = {});
    void drop_work(StepWork::Stage stage, const std::optional<Error>& error);
    std::uint64_t add(const char* name, std::shared_ptr<const Image> image, std::uint16_t index,
                      std::vector<TriggeredPart> parts = {});
    void tell_state() const;

    Settings settings_;
    std::unique_ptr<Transport> line_;
    Client client_;
    DeviceState state_;
    std::deque<Work> works_;  // the first is under way
    std::optional<Batch> batch_;
    std::optional<std::vector<Request>> modulation_;  // that what plays is to have
    double wanted_ = 1.0;
    std::uint64_t numbers_ = 0;
    bool turning_off_ = false, asking_ = false, gone_ = false;
    std::chrono::microseconds since_status_{0}, pause_{0};  // pause_: until a session is tried again
};

}  // namespace haptogram::link
