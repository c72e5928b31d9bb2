# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: Apache-2.0
#
# Three Debian packages by CPack: the program, the library pose/ for programs of others, and the
# Python module. `./dev package` builds them; which file belongs to which, the install() commands say
# (COMPONENT).

set(documents ${CMAKE_INSTALL_DATADIR}/doc)
set(contact "The Sightline authors <maintainers@sightline.example>")
set(revision 1)  # of the packages of one version

# A manual page a command, made by the program itself, and the completions of three shells.
if(NOT SIGHTLINE_POSE_ONLY)
  set(manual ${PROJECT_BINARY_DIR}/manual)
  add_custom_command(OUTPUT ${manual}/made
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual}
    COMMAND sightline manual --into ${manual}
    COMMAND sightline completions bash > ${manual}/bash
    COMMAND sightline completions zsh > ${manual}/zsh
    COMMAND sightline completions fish > ${manual}/fish
    COMMAND sh -c "gzip -9n ${manual}/*.1"
    COMMAND ${CMAKE_COMMAND} -E touch ${manual}/made
    DEPENDS sightline VERBATIM)
  add_custom_target(sightline_manual ALL DEPENDS ${manual}/made)
  install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program
          FILES_MATCHING PATTERN "*.1.gz")
  install(FILES ${manual}/bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          RENAME sightline COMPONENT program)
  install(FILES ${manual}/zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions
          RENAME _sightline COMPONENT program)
  install(FILES ${manual}/fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
          RENAME sightline.fish COMPONENT program)
endif()

# What Debian asks of every package: who may do what with it, and what changed.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH, where that is set
set(changelog ${PROJECT_BINARY_DIR}/changelog)
file(WRITE ${changelog}.Debian "sightline (${PROJECT_VERSION}-${revision}) unstable; urgency=medium

  * What changed is in changelog.gz.

 -- ${contact}  ${date}
")
execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md OUTPUT_FILE ${changelog}.gz)
execute_process(COMMAND gzip -9nc ${changelog}.Debian OUTPUT_FILE ${changelog}.Debian.gz)
function(sightline_package component name)
  install(FILES ${PROJECT_SOURCE_DIR}/packaging/copyright DESTINATION ${documents}/${name}
          COMPONENT ${component})
  install(FILES ${changelog}.gz ${changelog}.Debian.gz DESTINATION ${documents}/${name} COMPONENT ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_FILE_NAME DEB-DEFAULT PARENT_SCOPE)
endfunction()

set(CPACK_COMPONENTS_ALL pose_dev)
sightline_package(pose_dev libsightline-pose-dev)
set(CPACK_DEBIAN_POSE_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_POSE_DEV_PACKAGE_DEPENDS "libeigen3-dev")
if(SIGHTLINE_POSE_OPENCV)
  # Its configuration for CMake lies in this one.
  string(APPEND CPACK_DEBIAN_POSE_DEV_PACKAGE_DEPENDS ", libopencv-dev")
endif()
set(CPACK_DEBIAN_POSE_DEV_DESCRIPTION "pose estimation and absolute orientation for C++20
Solvers for the pose of a camera from points and their pixels, with removal of
outliers by a minimax criterion or by consensus, covariances and bounds; and
closed forms of the absolute orientation. A static library with its headers
and its configuration for CMake. Licence: Apache-2.0.")
if(NOT SIGHTLINE_POSE_ONLY)
  list(APPEND CPACK_COMPONENTS_ALL program)
  sightline_package(program sightline)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "gnuplot-nox")
  set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "renders targets, estimates their pose, measures every step
Sightline renders meshed targets under known poses, extracts features from
the images, estimates the six-degree-of-freedom pose from them, and says how
wrong every step was: against the ground truth, and against the Cramer-Rao
bound. It makes image sets, judges extractors and solvers (its own and those
of others), and guards accuracy in continuous integration.")
endif()
if(with_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  sightline_package(python python3-sightline)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  # The targets and studies are the program's.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "sightline (= ${PROJECT_VERSION}-${revision}), python3-numpy, \
python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_minor})")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Sightline for Python and numpy
The module sightline: poses from points, absolute orientation, rendered frames
as arrays without copies, studies with extractors and solvers written in
Python, results as columns.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
# Else it would stand before each package's own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_PACKAGE_CONTACT ${contact})
set(CPACK_DEBIAN_PACKAGE_RELEASE ${revision})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
# Whatever the umask of whoever builds them.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
include(CPack)
