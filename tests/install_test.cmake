# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# cmake -D BUILD=<build folder> -D SOURCE=<this folder> -D WORK=<scratch> -D GENERATOR=<generator>
#       -D PYTHON=<interpreter, or nothing> -D PYTHON_FOLDER=<of packages> -P install_test.cmake
# GENERATOR is that of the build itself: of CMake's default the machine may lack the program.
# Installs the build, builds and runs a program against the installed pose/, and runs the installed
# `sightline` and the Python module (if there are) with the installed assets alone.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}: exit code ${result}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
run(${CMAKE_COMMAND} -G "${GENERATOR}" -S ${SOURCE}/consumer -B ${WORK}/consumer
    -D CMAKE_PREFIX_PATH=${WORK}/installed -D CMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer)
# The page about embedding shows this program and what it prints.
file(READ ${SOURCE}/../docs/embedding.md page)
file(READ ${SOURCE}/consumer/main.cpp example)
string(REGEX REPLACE "^(//[^\n]*\n)+" "" example "${example}")
foreach(shown IN ITEMS "${example}" "${output}")
  string(FIND "${page}" "${shown}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "docs/embedding.md does not show:\n${shown}")
  endif()
endforeach()
if(EXISTS ${WORK}/installed/bin/sightline)
  # Without the cube the list can only come from the installed assets.
  file(REMOVE_RECURSE ${WORK}/installed/share/sightline/targets/cube)
  run(${WORK}/installed/bin/sightline list targets)
  if(NOT output MATCHES "boeing707" OR output MATCHES "cube")
    message(FATAL_ERROR "the installed program does not list the installed targets:\n${output}")
  endif()
endif()
if(PYTHON)
  run(${CMAKE_COMMAND} -E env PYTHONPATH=${WORK}/installed/${PYTHON_FOLDER} ${PYTHON} -B -c
      "import sightline as sl, numpy as np
print(*sl.targets(), sl.align(np.eye(3), np.eye(3)).status)")
  if(NOT output STREQUAL "boeing707 boeing707_livery tango ok\n")
    message(FATAL_ERROR "the installed Python module does not know the installed targets:\n${output}")
  endif()
endif()
file(REMOVE_RECURSE ${WORK})
