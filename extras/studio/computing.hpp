// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "answers.hpp"
#include "haptogram/base/progress.hpp"
#include "local_server.hpp"
#include "messages.hpp"
#include "pins.hpp"
#include "scenes.hpp"
#include "worker.hpp"

namespace haptogram::studio {

using serve::Page, serve::Reply;

/// What pages ask of scenes: to compile them, and what they do in the air and at the pins. It is computed in threads of
/// its own and answered to the page that asked. No board has a part in it. Its functions are for the server's thread,
/// and return at once.
class Computing {
public:
    /// @param post  calls work in the server's thread
    Computing(Scenes& scenes, std::function<void(std::function<void()>)> post);

    /// The field on a plane, or a report, as a file.
    /// @return whether that is asked for
    /// @throws Error when the request makes no sense
    bool write(const Request& request, const Reply& reply);
    /// A scene's image in the bitstream of its board.
    /// @param placed  folder of the boards' placed designs, as patch() takes it
    /// @throws Error when there is no such scene, or it names no board
    void bitstream(const Request& request, const Reply& reply, const std::filesystem::path& placed);

    void ask(const std::shared_ptr<Page>& page, const SceneMessage& message);
    void ask(const std::shared_ptr<Page>& page, const HandMessage& message);
    void ask(const std::shared_ptr<Page>& page, const PathMessage& message);
    void ask(const std::shared_ptr<Page>& page, const SliceMessage& message);
    void ask(const std::shared_ptr<Page>& page, const ReachMessage& message);
    void ask(const std::shared_ptr<Page>& page, const SkinMessage& message);
    void ask(const std::shared_ptr<Page>& page, const DrivesMessage& message);
    void ask(const std::shared_ptr<Page>& page, const AnalyzeMessage& message);
    void ask(const std::shared_ptr<Page>& page, const SimulateMessage& message);
    void ask(const std::shared_ptr<Page>& page, const CancelMessage& message);
    void ask(const std::shared_ptr<Page>& page, const PulsesMessage& message);

    /// A page was closed: what it waits for is dropped, or ends early.
    void forget(const Page& page);
    /// All that can ends early.
    void end() { over_ = true; }

private:
    using Wanted = std::shared_ptr<std::atomic<bool>>;  ///< whether somebody still waits for it
    struct Asker {
        Wanted analyzing = std::make_shared<std::atomic<bool>>(false);
        Wanted simulating = std::make_shared<std::atomic<bool>>(false);
        Wanted rendering = std::make_shared<std::atomic<bool>>(false);
        std::shared_ptr<const Pins> pins{};  ///< what was simulated last
    };

    [[nodiscard]] Progress going_while(Wanted wanted) const;
    /// Of each of a page's views the newest slice.
    void slice(const std::shared_ptr<Page>& page, std::uint32_t view, std::function<void()> work);
    /// Answers with a file that takes a while.
    void write(const Reply& reply, Writing writing);

    Scenes& scenes_;
    std::function<void(std::function<void()>)> post_;
    std::map<std::uint64_t, Asker> askers_;  // by their page's number, from their first such message on
    std::atomic<bool> over_ = false;
    std::uint64_t file_number_ = 0;
    // Last, so that they end before what they use.
    Worker slices_, compilers_, hands_, renderers_, files_, analyses_, simulations_;
};

}  // namespace haptogram::studio
