// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/transfer.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/memory.hpp"

namespace haptogram::link {
namespace {

using interface::Command;

/// What a frame carries: a record, or as many bytes of anything else.
std::size_t frame_bytes(const Image& image) { return std::size_t{2} * record_words(image.channels); }

/// An image's records in frames, one in each, then foci and the sequence in pieces of the same length.
std::vector<Piece> records_of(const Image& image) {
    std::vector<Piece> pieces;
    cut(pieces, interface::primary_base, primary_words(image), frame_bytes(image));
    cut(pieces, interface::sequence_base, sequence_words(image), frame_bytes(image));
    return pieces;
}

/// The same, and then parameters and samples.
std::vector<Piece> pieces_of(const Image& image) {
    std::vector<Piece> pieces = records_of(image);
    cut(pieces, interface::parameters_base, parameters_words(image), frame_bytes(image));
    cut(pieces, interface::modulation_base, modulation_words(image), frame_bytes(image));
    return pieces;
}

/// What can be written and not be read, so that no digest tells whether the device has it.
std::vector<Piece> unread_pieces_of(const Image& image) {
    std::vector<Piece> pieces;
    cut(pieces, interface::geometry_base, geometry_words(image), frame_bytes(image));
    return pieces;
}

constexpr double compared = 0.05, written = 0.95;  // about the time that each step takes of the whole

/// Over and over, from the first sample on.
Request played(const SampledModulation& modulation) {
    return modulate_request(modulation.divider, static_cast<std::uint16_t>(modulation.samples.size()), true);
}

/// Connects again after a loss, until then. @return empty when the device did not come back
std::unique_ptr<Commands> connect_again(const Connect& connect, Clock& clock, Clock::Time until,
                                        const Progress& progress) {
    constexpr std::chrono::milliseconds pause{200};
    while (clock.now() < until) {
        progress(0.0, "waiting");
        clock.rest(pause);
        try {
            return connect();
        } catch (const Error& error) {
            if (error.code() != ErrorCode::device) throw;
        }
    }
    return {};
}

}  // namespace

UploadSteps::UploadSteps(const Image& image, const Identity& identity)
    : pieces_(pieces_of(image)), unread_(unread_pieces_of(image)), start_(modulation_request(image, identity)) {
    if (image.foci && identity.version_major == 2 && identity.version_minor < 5 && weighs(image.foci->engine.geometry))
        throw Error(
            ErrorCode::device, "board",
            fmt::format("it speaks protocol 2.{}, in which channels have no weights, and the image's have; give the "
                        "board a bitstream of 2.5 or later, or compile it with a calibration whose drive is "
                        "\"full\" and that has no dead elements",
                        identity.version_minor));
}

std::optional<std::vector<Request>> UploadSteps::next(const std::vector<Reply>& replies) {
    switch (step_) {
        case Step::none: step_ = Step::compares; return asking(Command::digest, pieces_);
        case Step::compares: {
            step_ = Step::writes;
            wrong_ = differing(pieces_, replies);
            std::vector<Request> requests = writing(unread_);
            std::ranges::move(writing(wrong_), std::back_inserter(requests));
            return requests;
        }
        case Step::writes: step_ = Step::compares_again; return asking(Command::digest, wrong_);
        case Step::compares_again: {
            const std::vector<Piece> still = differing(wrong_, replies);
            if (!still.empty())
                throw Error(ErrorCode::device, "board",
                            fmt::format("its memory differs from what was written, from address {:#010x} on; does "
                                        "another program write to this board?",
                                        still.front().address));
            step_ = Step::starts;
            return start_ ? std::vector<Request>{*start_} : std::vector<Request>{};
        }
        default: step_ = Step::over; return {};
    }
}

Progress UploadSteps::part(const Progress& progress) const {
    if (step_ == Step::compares) return progress.between(0.0, compared);
    if (step_ == Step::writes) return progress.between(compared, written);
    if (step_ == Step::compares_again) return progress.between(written, 1.0);
    return {};
}

Uploaded upload(Commands& device, const Image& image, const Progress& progress) {
    UploadSteps steps(image, device.identity());
    std::vector<Reply> replies;
    while (std::optional<std::vector<Request>> requests = steps.next(replies))
        replies = device.pipeline(std::move(*requests), steps.part(progress));
    return steps.uploaded();
}

bool holds(Commands& device, const Image& image) { return differing(device, pieces_of(image)).empty(); }

bool holds_records(Commands& device, const Image& image) { return differing(device, records_of(image)).empty(); }

std::vector<Request> settings_requests(const Image& image) {
    std::vector<Piece> pieces = unread_pieces_of(image);
    cut(pieces, interface::parameters_base, parameters_words(image), frame_bytes(image));
    cut(pieces, interface::modulation_base, modulation_words(image), frame_bytes(image));
    return writing(pieces);
}

void write_settings(Commands& device, const Image& image) { device.pipeline(settings_requests(image)); }

std::optional<Request> modulation_request(const Image& image, const Identity& identity) {
    if (image.modulation) return played(*image.modulation);
    if (identity.modulation_words > 0) return modulate_request(0, 0, false);
    return {};
}

void start_modulation(Commands& device, const Image& image) {
    if (std::optional<Request> request = modulation_request(image, device.identity()))
        device.request(std::move(*request));
}

Bytes flash_image(const Image& image, bool autostart, const std::string& where) {
    Bytes bytes{0};
    std::uint8_t number = 0;
    const auto add = [&](const Request& request) {
        const Bytes frame = encode_request(number++, request.command, request.payload);
        bytes.insert(bytes.end(), frame.begin(), frame.end());
    };
    add({Command::identify, {}});
    std::vector<Piece> pieces = unread_pieces_of(image);
    std::ranges::move(pieces_of(image), std::back_inserter(pieces));
    for (Piece& piece : pieces) {
        if (autostart && piece.address == interface::sequence_base)
            interface::sequence_header_field::autostart.set(piece.bytes, 1);
        add(writing(piece));
    }
    if (image.modulation) add(played(*image.modulation));
    bytes.insert(bytes.end(), 2, 0);
    if (bytes.size() > interface::flash_image::bytes)
        throw bad_input(where,
                        fmt::format("it takes {} bytes of the board's flash, which has room for {}; leave some records "
                                    "out, or upload it",
                                    bytes.size(), interface::flash_image::bytes));
    return bytes;
}

std::uint32_t highest_index(Commands& device) {
    const Identity& identity = device.identity();
    if (identity.foci == 0) return identity.records;
    namespace field = interface::parameters_field;
    const auto bytes = static_cast<std::uint16_t>(2 * interface::parameters_words);
    return identity.records + field::foci_count.get(device.read(interface::parameters_base, bytes));
}

std::string compare(Commands& device, const Image& image, const Progress& progress) {
    const std::vector<Piece> pieces = pieces_of(image);
    const std::vector<Reply> replies = device.pipeline(asking(Command::read, pieces), progress);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const auto [expected, found] = std::ranges::mismatch(pieces[i].bytes, replies[i].data);
        if (expected == pieces[i].bytes.end() && found == replies[i].data.end()) continue;
        const auto at = static_cast<std::uint32_t>(expected - pieces[i].bytes.begin());
        return fmt::format("the board's memory differs at address {:#010x}", pieces[i].address + at);
    }
    return {};
}

DeviceSequence download_sequence(Commands& device, const std::string& where, bool empty_is_good) {
    namespace header = interface::sequence_header_field;
    namespace entry = interface::sequence_entry_field;
    const Identity& identity = device.identity();
    const std::uint32_t length =
        header::length.get(device.read(interface::sequence_base, interface::sequence_word_bits / 8));
    if (length >= identity.sequence_depth || (length == 0 && !empty_is_good))
        throw Error(ErrorCode::device, where,
                    fmt::format("the sequence header in its memory says {} entries; upload an image first", length));
    const auto words =
        words_of<std::uint32_t>(contents(device, interface::sequence_base, 4 * (length + std::size_t{1}), {}));
    DeviceSequence found{{}, static_cast<std::uint16_t>(header::loops.get(words))};
    for (std::size_t i = 1; i < words.size(); ++i)
        found.entries.push_back({static_cast<std::uint16_t>(entry::index.get(&words[i])),
                                 static_cast<std::uint16_t>(entry::dwell.get(&words[i])),
                                 entry::mark.get(&words[i]) != 0});
    return found;
}

Image download(Commands& device, const Identity& identity, std::uint32_t records, const std::string& where,
               const Progress& progress) {
    DeviceSequence sequence = download_sequence(device, where, records > 0);
    for (const SequenceEntry& entry : sequence.entries) {
        if (entry.index > identity.records && entry.index <= highest_index(device))
            throw Error(ErrorCode::device, where,
                        fmt::format("its sequence plays the focus record of index {}, and the geometry of foci cannot "
                                    "be read back; keep the image that was uploaded",
                                    entry.index));
        records = std::min(std::max<std::uint32_t>(records, entry.index), identity.records);
    }
    Image image;
    image.channels = identity.channels;
    image.clock_hz = identity.clock_hz;
    image.timing_bits = identity.timing_bits;
    image.pulse_bits = identity.pulse_bits;
    image.sequence = std::move(sequence.entries);
    image.loops = sequence.loops;
    const std::size_t bytes = std::size_t{2} * record_words(identity.channels) * records;
    take_records(image, words_of<std::uint16_t>(contents(device, interface::primary_base, bytes, progress)), where);
    return image;
}

void require_fits(const Image& image, const Identity& identity, const std::string& where) {
    haptogram::require_fits(image, identity.core(), where);
}

UploadReport upload(const Connect& connect, const Image& image, const UploadSettings& settings) {
    std::unique_ptr<Commands> device = connect();
    require_fits(image, device->identity(), settings.image);
    Clock& clock = device->clock();
    const Clock::Time begun = clock.now();
    UploadReport report{.records = image.record_count(), .sequence_entries = image.sequence.size()};
    // A device that comes back, and then answers nothing, has not come back.
    Clock::Time answered = clock.now();
    // Neither has one with which an upload comes no farther each time. What was written need not be written again, but
    // what was compared is.
    double farthest[2] = {};
    const Progress progress([&](double fraction, std::string_view stage) {
        const bool writes = fraction > compared && fraction < written;
        double& before = farthest[fraction < written ? 0 : 1];
        if (writes || fraction > before) answered = clock.now();
        if (!writes) before = std::max(before, fraction);
        settings.progress(fraction, stage);
        return true;
    });
    for (bool done = false; !done;) {
        try {
            const Uploaded uploaded = upload(*device, image, progress);
            report.frames = uploaded.pieces;
            report.frames_written = uploaded.written;
            done = true;
        } catch (const LinkLost& lost) {
            report.retransmissions += device->retransmissions();
            device.reset();
            ++report.link_losses;
            const auto until = answered + Clock::time(std::min(settings.wait_s, 1e8));
            const double left_s = Clock::seconds(until - clock.now());
            if (settings.lost && left_s > 0.0) settings.lost(lost, left_s);
            device = connect_again(connect, clock, until, settings.progress);
            if (!device)
                throw Error(ErrorCode::device, settings.port,
                            "it did not come back; the same command goes on where this one stopped");
            require_fits(image, device->identity(), settings.image);
        }
    }
    report.retransmissions += device->retransmissions();
    report.seconds = clock.seconds_since(begun);
    if (settings.verify) {
        const std::string difference = compare(*device, image, settings.progress.in_stage("verify"));
        if (!difference.empty())
            throw Error(ErrorCode::device, settings.image, difference + "; does another program write to this board?");
        report.verified = true;
    }
    return report;
}

}  // namespace haptogram::link
