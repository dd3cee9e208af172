# SPDX-License-Identifier: Apache-2.0
# Run as a script: writes the two sources that include all that Verilator has made of a class, by the list that it wrote beside it.
include(${FOLDER}/${PREFIX}.cmake)
foreach(kind FAST SLOW)
  set(text "")
  foreach(file IN LISTS ${PREFIX}_CLASSES_${kind} ${PREFIX}_SUPPORT_${kind})
    get_filename_component(name ${file} NAME)
    string(APPEND text "#include \"${name}\"\n")
  endforeach()
  string(TOLOWER ${kind} name)
  file(CONFIGURE OUTPUT ${FOLDER}/${PREFIX}_${name}.cpp CONTENT "${text}" @ONLY)
endforeach()
