// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/background_rig.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {

BackgroundRig::BackgroundRig(const std::string& manifest, const std::vector<std::string>& ports,
                             std::optional<std::uint32_t> baud)
    : bundle_(load_rig_bundle(manifest)), ports_(ports_of(bundle_, ports, baud)) {
    for (PortSettings& port : ports_) port.interrupt = [this] { return off_ ? 1U : 0U; };
    const RigDevices devices(bundle_, ports_);
    for (const Tile& tile : devices.tiles()) {
        identities_.push_back(tile.device.identity());
        statuses_.emplace_back(tile.device.status());
    }
}

BackgroundRig::~BackgroundRig() { end(); }

void BackgroundRig::end() { thread_.end(); }

std::vector<std::optional<Status>> BackgroundRig::statuses() const {
    const std::lock_guard lock(mutex_);
    return statuses_;
}

void BackgroundRig::upload() {
    if (busy()) throw bad_argument("upload", "the rig plays; stop it first");
    const RigDevices devices(bundle_, ports_);
    for (const Tile& tile : devices.tiles()) {
        try {
            require_fits(tile.image, tile.device.identity(), tile.name);
            link::upload(tile.device, tile.image);
        } catch (const Error& error) {
            throw Error(error.code(), tile.name, error.what());
        }
    }
}

void BackgroundRig::play(const RigSettings& settings) {
    thread_.begin([&] {
        return [this, settings] {
            const RigDevices devices(bundle_, ports_);
            link::play(devices.tiles(), settings, [this](const RigPlaying& now) {
                const std::lock_guard lock(mutex_);
                statuses_ = now.statuses;
                return !thread_.ending();
            });
            const std::lock_guard lock(mutex_);
            for (std::optional<Status>& status : statuses_)
                if (status) status->enabled = false;  // as each has confirmed, or play() has thrown
        };
    });
}

void BackgroundRig::stop() {
    thread_.end();
    thread_.wait(std::chrono::milliseconds(0));
}

/// What plays turns its own outputs off when it is interrupted; what was left on by others, here: every tile that can
/// be reached, whatever becomes of another.
void BackgroundRig::shut_off() {
    off_ = true;
    thread_.end();
    thread_.forget_trouble();
    off_ = false;
    std::vector<std::string> on;
    for (std::size_t i = 0; i < ports_.size(); ++i) {
        const std::string tile = name_of_tile(i, ports_[i].port);
        bool off = false;
        try {
            off = Device(ports_[i]).turn_off();
            if (!off) on.push_back(fmt::format("{}: {}", tile, not_confirmed({})));
        } catch (const Error& error) {
            on.push_back(fmt::format("{}: {}", tile, error.message()));
        }
        const std::lock_guard lock(mutex_);
        if (off && statuses_[i]) statuses_[i]->enabled = false;
    }
    if (!on.empty()) throw Error(ErrorCode::device, "rig", fmt::format("{}", fmt::join(on, "; ")));
}

}  // namespace haptogram::link
