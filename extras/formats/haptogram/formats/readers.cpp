// SPDX-License-Identifier: Apache-2.0
#include "haptogram/formats/readers.hpp"

#include "haptogram/formats/parts.hpp"

namespace haptogram::formats {

ShapeReaders readers() {
    return {{ShapeFormat::off, read_off},
            {ShapeFormat::pcd, read_pcd},
            {ShapeFormat::three_mf, read_three_mf},
            {ShapeFormat::gltf, read_gltf},
            {ShapeFormat::svg, read_svg}};
}

}  // namespace haptogram::formats
