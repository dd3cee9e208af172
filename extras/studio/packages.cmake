# SPDX-License-Identifier: Apache-2.0
# Without node all but the page is built, and the server says what is missing.
if(NOT HAPTOGRAM_PROGRAM AND NOT HAPTOGRAM_TESTS)
  return()
endif()
find_program(HAPTOGRAM_NODE node)
mark_as_advanced(HAPTOGRAM_NODE)
if(HAPTOGRAM_NODE AND EXISTS ${PROJECT_SOURCE_DIR}/extras/studio/web/node_modules/esbuild)
  set(HAPTOGRAM_PAGE ON)
else()
  message(NOTICE "haptogram: the studio's page is left out: it needs node (nodejs) and the packages of extras/studio/web. On Debian 12 tools/setup installs both.")
endif()
