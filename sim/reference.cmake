# SPDX-License-Identifier: Apache-2.0
# The reference board needs no Verilated core; the library for other languages has it inside.
set(sources serial_line.cpp identity.cpp reference_board.cpp reference_commands.cpp reference_cycle.cpp reference_drive_player.cpp
  reference_frames.cpp reference_line.cpp reference_modulation.cpp reference_player.cpp reference_port.cpp reference_pulses.cpp
  reference_reader.cpp reference_replies.cpp reference_source.cpp
  reference_stream.cpp reference_sync.cpp reference_trigger.cpp)
list(TRANSFORM sources PREPEND ${HAPTOGRAM_SIM_DIR}/)
add_library(haptogram_reference STATIC ${sources})
set_target_properties(haptogram_reference PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_include_directories(haptogram_reference PUBLIC ${HAPTOGRAM_SIM_DIR})
target_link_libraries(haptogram_reference PUBLIC haptogram_verbs PRIVATE fmt::fmt haptogram_warnings)
