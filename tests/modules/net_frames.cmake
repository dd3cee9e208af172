# SPDX-License-Identifier: Apache-2.0
# The byte side of the port's receiver as a program, to which a model in Python sends frames: a million in the preset `deep`.
set(HERE ${CMAKE_CURRENT_LIST_DIR})
add_library(module_net_receiver STATIC)
haptogram_verilate(module_net_receiver Vnet_receiver_bench net_receiver_bench SOURCES ${HERE}/net_receiver_bench.v
  INCLUDE_DIRS ${PROJECT_SOURCE_DIR}/rtl ${PROJECT_SOURCE_DIR}/rtl/net OPTIONS -Wall)
add_executable(net_receiver ${HERE}/net_receiver.cpp)
target_link_libraries(net_receiver PRIVATE module_net_receiver)
target_compile_options(net_receiver PRIVATE -O2 -Wall -Wextra)
haptogram_script_test(net_frames 900 ${Python3_EXECUTABLE} ${HERE}/net_frames.py $<TARGET_FILE:net_receiver>)
if(HAPTOGRAM_DEEP_TESTS)
  set_tests_properties(net_frames PROPERTIES ENVIRONMENT HAPTOGRAM_NET_FRAMES=1000000)
endif()
