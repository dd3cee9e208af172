# SPDX-License-Identifier: Apache-2.0
# cpack -G DEB makes haptogram and libhaptogram-dev, with what Debian wants beside the files: copyright, changelog, a packed manual.
if(NOT PROJECT_IS_TOP_LEVEL OR NOT HAPTOGRAM_INSTALL OR NOT HAPTOGRAM_PROGRAM OR SKBUILD)
  return()
endif()
set(CPACK_PACKAGE_VENDOR Haptogram)
set(CPACK_PACKAGE_CONTACT "The Haptogram authors <haptogram@example.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program system devel)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME haptogram)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "python3-matplotlib, python3-intelhex")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "command line, simulated board and studio for mid-air haptics
 Compiles shapes, texts and paths to images for an FPGA that drives arrays of
 ultrasonic transducers, simulates the FPGA, computes fields, drives boards.")
set(CPACK_DEBIAN_DEVEL_PACKAGE_NAME libhaptogram-dev)
set(CPACK_DEBIAN_DEVEL_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVEL_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVEL_PACKAGE_DEPENDS "libfmt-dev, libhwy-dev, libminizip-dev, libtbb-dev, libeigen3-dev, nlohmann-json3-dev, libtomlplusplus-dev, libbullet-dev, libpng-dev, libpugixml-dev, zlib1g-dev, libftdi1-dev")
set(CPACK_COMPONENT_DEVEL_DESCRIPTION "C++ libraries of haptogram
 Static libraries, headers, CMake and pkg-config files.")

set(DEBIAN ${PROJECT_BINARY_DIR}/debian)
file(WRITE ${DEBIAN}/triggers "activate-noawait ldconfig\n")  # for libhaptogram.so
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${DEBIAN}/triggers)
file(WRITE ${DEBIAN}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: haptogram

Files: *
Copyright: 2026 The Haptogram authors
License: Apache-2.0

Files: usr/share/haptogram/studio/*
Copyright: see notices.html there, which has the texts of all packages of the page
License: Expat
 See notices.html beside the page.

License: Apache-2.0
 On Debian systems the license is in /usr/share/common-licenses/Apache-2.0.
")
# The date of the last commit, so that the same sources make the same package.
execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%cD OUTPUT_VARIABLE DATE OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT DATE)
  string(TIMESTAMP DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
file(WRITE ${DEBIAN}/changelog.Debian "haptogram (${PROJECT_VERSION}-1) unstable; urgency=low

  * See CHANGELOG.md of the sources.

 -- The Haptogram authors <haptogram@example.invalid>  ${DATE}
")
execute_process(COMMAND gzip -9nf ${DEBIAN}/changelog.Debian)
install(FILES ${DEBIAN}/copyright ${DEBIAN}/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/haptogram COMPONENT system)
install(FILES ${DEBIAN}/copyright ${DEBIAN}/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libhaptogram-dev COMPONENT devel)
install(FILES host/cli/60-haptogram.rules DESTINATION lib/udev/rules.d COMPONENT system)
include(CPack)
cpack_add_component(program GROUP program)
cpack_add_component(system GROUP program)
cpack_add_component(devel GROUP devel)
