// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/region.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/field.hpp"
#include "scenes.hpp"

namespace haptogram::studio {

/// The field of a scene on a plane, or the surface of one value in a volume, as a file.
struct FieldRequest {
    std::shared_ptr<const Scene> scene;
    std::uint32_t record = 0;  ///< of this one alone, counted from 1; 0: the mean over the sequence
    Region region;
    Quantity quantity{};
    double below_db = 6.0;  ///< of a surface
    std::string name;       ///< of the file
};

/// Reads the query of /api/field; messages.hpp has its members.
/// @throws Error naming the member that is missing or makes no sense
[[nodiscard]] FieldRequest field_request(std::string_view query, Scenes& scenes);

/// The file's content, as `haptogram field` writes it.
[[nodiscard]] std::string field_file(const FieldRequest& request, const Progress& progress);

}  // namespace haptogram::studio
