// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "haptogram/hand/object.hpp"
#include "haptogram/hand/open.hpp"
#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// Opens objects as open_object() does, but reads each mesh file once: where it stands, how it is turned and how large
/// it is then costs no more than a look at its corners.
class OpenedObjects {
public:
    /// @throws as open_object()
    [[nodiscard]] TouchObject open(const ObjectSource& source);
    /// What a scene tells of it.
    /// @throws as open_object()
    [[nodiscard]] FeltObject told(const std::string& name, const ObjectSource& source);

private:
    struct Body;
    [[nodiscard]] const Body& body_of(const ObjectSource& source);

    std::map<std::pair<std::string, std::string>, std::shared_ptr<const Body>> bodies_;  ///< by file and unit
};

}  // namespace haptogram::live
