// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/link/memory.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// What an upload found and did, in frames. A frame carries one record, or as many bytes of the sequence.
struct Uploaded {
    std::size_t pieces = 0;   ///< frames that the image has
    std::size_t written = 0;  ///< those that the device did not hold already
};

/// An upload in steps, for who cannot wait: each step is requests, and the next one needs their replies.
class UploadSteps {
public:
    /// @param image  was checked to fit the device
    UploadSteps(const Image& image, const Identity& identity);
    /// @param replies  to the requests of the step before, in order; of the first, none
    /// @return empty when all is done  @throws Error{device} when the digests still differ after writing
    [[nodiscard]] std::optional<std::vector<Request>> next(const std::vector<Reply>& replies);
    /// Progress of the present step in that of all steps.
    [[nodiscard]] Progress part(const Progress& progress) const;
    [[nodiscard]] Uploaded uploaded() const {
        return {pieces_.size() + unread_.size(), wrong_.size() + unread_.size()};
    }

private:
    enum class Step { none, compares, writes, compares_again, starts, over };
    Step step_ = Step::none;
    std::vector<Piece> pieces_, unread_;
    std::vector<Piece> wrong_;  // of the pieces, what the device did not hold
    std::optional<Request> start_;
};

/// @throws Error{bad_input} saying why the image does not fit the device
void require_fits(const Image& image, const Identity& identity, const std::string& where);

/// Brings an image into a device's memories, and starts its modulation or ends the one before. It asks for the digest
/// of each piece first and writes only those that differ, so that an upload which was cut off goes on where it stopped;
/// in the end it asks for the digests again. The caller has checked that the image fits. The geometry of foci can only
/// be written, so it is, each time.
/// @throws Error{device} when the digests still differ after writing
Uploaded upload(Commands& device, const Image& image, const Progress& progress = {});

/// Whether a device's memories hold an image, told by their digests; of the geometry of foci nothing can be told.
[[nodiscard]] bool holds(Commands& device, const Image& image);

/// The same of its records and its sequence alone, which tells tiles of a rig apart.
[[nodiscard]] bool holds_records(Commands& device, const Image& image);

/// Requests that write what an image has of parameters, geometry and modulation, which no bitstream holds. They start
/// nothing.
[[nodiscard]] std::vector<Request> settings_requests(const Image& image);
/// Writes them.
void write_settings(Commands& device, const Image& image);

/// The request that starts the modulation that an image has, with its first sample, over and over. Where it has none, a
/// device that could modulate stops doing so.
[[nodiscard]] std::optional<Request> modulation_request(const Image& image, const Identity& identity);
/// Sends it.
void start_modulation(Commands& device, const Image& image);

/// What a board with an SDRAM reads out of its flash at power-up, to be written at interface::flash_image::first: the
/// frames that a host would send for this image.
/// @param autostart  the board then plays its sequence, with no host and no watchdog
/// @throws Error{bad_input} when there is no room for it in the flash
[[nodiscard]] Bytes flash_image(const Image& image, bool autostart, const std::string& where);

/// The highest index of a record that a device holds; of foci, as its parameters say.
[[nodiscard]] std::uint32_t highest_index(Commands& device);

/// The sequence in a device's memory, and how often it is played; 0 is for ever.
struct DeviceSequence {
    std::vector<SequenceEntry> entries;
    std::uint16_t loops = 0;
};
/// @param empty_is_good  whether there may be none
/// @throws Error{device} when there is none
[[nodiscard]] DeviceSequence download_sequence(Commands& device, const std::string& where, bool empty_is_good = false);

/// Reads the memory that an image fills back, byte by byte, except the geometry, which cannot be read. @return empty
/// when it holds the image, else the first difference in words
std::string compare(Commands& device, const Image& image, const Progress& progress = {});

/// The image that a device's memories hold: its sequence, and the records up to the highest that the sequence plays.
/// @param records  read at least this many records
/// @param where    names the device in messages
/// @throws Error{device} when there is no sequence, or when it plays foci, whose geometry cannot be read back;
/// Error{bad_input} when what should be a record is none
Image download(Commands& device, const Identity& identity, std::uint32_t records, const std::string& where,
               const Progress& progress = {});

/// Begins a session with a device, perhaps after its link was lost. @throws Error{device} when it cannot be reached
using Connect = std::function<std::unique_ptr<Commands>()>;

struct UploadSettings {
    std::string image;     ///< its name in messages
    std::string port;      ///< the device's name in messages
    bool verify = false;   ///< read all of it back and compare, beyond the digests
    double wait_s = 30.0;  ///< for how long, since its last answer, a lost device may stay away
    /// Told that the link was lost, and for how long the upload will wait for it.
    std::function<void(const LinkLost& lost, double wait_s)> lost{};
    Progress progress{};  ///< stages: none, "waiting" after a loss, "verify"
};

/// What has become of it.
struct UploadReport {
    std::size_t records = 0, sequence_entries = 0;
    std::size_t frames = 0, frames_written = 0;  ///< of the last attempt, which finds what came through before a loss
    double seconds = 0.0;                        ///< without the reading back
    std::uint64_t retransmissions = 0;
    unsigned link_losses = 0;
    bool verified = false;
};

/// The whole of an upload: connects, checks that the image fits, writes what differs, goes on after an unplug, and
/// reads back if asked to.
UploadReport upload(const Connect& connect, const Image& image, const UploadSettings& settings);

}  // namespace haptogram::link
