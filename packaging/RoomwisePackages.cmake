# The target "package": Debian packages of what cmake --install installs, by CPack. Described in docs/packages.md.
# Included last, when every component is known.
set(ROOMWISE_PACKAGE_MAINTAINER "Roomwise maintainers <maintainers@roomwise.invalid>" CACHE STRING
  "Whom the packages name as their maintainer: NAME <ADDRESS>; who passes packages on gives their own")
set(here ${CMAKE_CURRENT_LIST_DIR})
set(built ${PROJECT_BINARY_DIR}/packaging)

file(STRINGS ${here}/changelog newest LIMIT_COUNT 1)
if(NOT newest MATCHES "^roomwise \\(${PROJECT_VERSION}\\)")
  message(FATAL_ERROR "packaging/changelog begins with '${newest}': give it an entry for ${PROJECT_VERSION}")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME roomwise)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGE_CONTACT ${ROOMWISE_PACKAGE_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
if(CMAKE_CROSSCOMPILING)
  # Which package has a library is asked of the books of the other architecture's Debian (arm64_root.sh), not of this
  # machine's.
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
    ${ROOMWISE_ARM64_ROOT}/lib/aarch64-linux-gnu ${ROOMWISE_ARM64_ROOT}/usr/lib/aarch64-linux-gnu)
  set(ROOMWISE_PACKAGE_BOOKS ${ROOMWISE_ARM64_ROOT}/var/lib/dpkg)
endif()

# In cpack's own process: the time in the packages, and what Debian wants elsewhere than cmake --install puts it.
set(ROOMWISE_SOURCE_DIR ${PROJECT_SOURCE_DIR})
configure_file(${here}/source_date.cmake.in ${built}/source_date.cmake @ONLY)
set(CPACK_PROJECT_CONFIG_FILE ${built}/source_date.cmake)
set(CPACK_PRE_BUILD_SCRIPTS ${here}/as_debian_wants_it.cmake)

# roomwise_package(COMPONENT PACKAGE SECTION section DESCRIPTION text [DEPENDS text] [RECOMMENDS text] [SUGGESTS text]
# [SCRIPTS file ...]): what of Roomwise is installed as COMPONENT becomes the package PACKAGE. DESCRIPTION: its first line
# is the summary; no semicolon, which CPack would take for an end.
function(roomwise_package component package)
  cmake_parse_arguments(ARG "" "SECTION;DESCRIPTION;DEPENDS;RECOMMENDS;SUGGESTS" "SCRIPTS" ${ARGN})
  string(TOUPPER ${component} COMPONENT)
  foreach(field SECTION DESCRIPTION DEPENDS RECOMMENDS SUGGESTS)
    set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_${field} "${ARG_${field}}" PARENT_SCOPE)
  endforeach()
  set(CPACK_DEBIAN_${COMPONENT}_DESCRIPTION "${ARG_DESCRIPTION}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_CONTROL_EXTRA "${ARG_SCRIPTS}" PARENT_SCOPE)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()

set(CPACK_COMPONENTS_ALL "")
roomwise_package(program roomwise
  SECTION utils
  DEPENDS adduser
  RECOMMENDS espeak-ng
  SUGGESTS "roomwise-lab, python3-roomwise, haproxy"
  SCRIPTS ${here}/roomwise/postinst ${here}/roomwise/prerm ${here}/roomwise/postrm
  DESCRIPTION "rooms and things of a home, told to a person who cannot see
A helper walks through a home once with a camera that measures depth, or with a
phone. Roomwise turns the recording into a map with rooms and things and learns
to tell the rooms apart. Later two pictures are enough to say the room, and a
browser or a wearable computer is guided to things and rooms.
.
This package has the command line, a small network, the web pages and a service
(systemd, not enabled by itself) that keeps a home open for devices in it.")

roomwise_package(device roomwise-device
  SECTION utils
  RECOMMENDS "speech-dispatcher"
  SUGGESTS "speech-dispatcher-espeak-ng"
  DESCRIPTION "wearable's end of Roomwise: sends what a camera sees, speaks what is answered
In a home that Roomwise has mapped, a small computer that is carried sends the
pictures of its camera to the home's computer and says what comes back: in
which room its wearer is, where things are, and the way to them.
.
This package has that alone, for small boards. It is also in the package
roomwise, as roomwise device.")

# find_package(Roomwise) looks for what its libraries link: libraries that the product is built with.
file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/packages.txt lines)
set(libraries "")
foreach(line IN LISTS lines)
  if(line MATCHES "^\\[(.*)\\]$")
    set(part ${CMAKE_MATCH_1})
  elseif(part STREQUAL "product" AND line MATCHES "^([^ #]+-dev) ")
    list(APPEND libraries ${CMAKE_MATCH_1})
  endif()
endforeach()
list(JOIN libraries ", " libraries)
roomwise_package(library libroomwise-dev
  SECTION libdevel
  DEPENDS "${libraries}"
  DESCRIPTION "library of Roomwise: maps of homes, their rooms and things (headers)
Maps homes from recordings of cameras that measure depth, learns their rooms,
finds things and ways to them.
.
This package has headers, static libraries and what find_package(Roomwise) of
CMake finds.")

if(ROOMWISE_PYTHON)
  find_package(Python 3.9 REQUIRED COMPONENTS Interpreter)  # as in python/, whose variables end with that folder
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  set(major ${Python_VERSION_MAJOR})
  roomwise_package(python python3-roomwise
    SECTION python
    DEPENDS "python3 (>= ${major}.${Python_VERSION_MINOR}), python3 (<< ${major}.${next_minor}), python3-numpy"
    RECOMMENDS "roomwise (= ${PROJECT_VERSION})"
    SCRIPTS ${here}/python3-roomwise/postinst ${here}/python3-roomwise/prerm
    DESCRIPTION "Roomwise from Python: maps of homes, their rooms and things
Reads recordings of cameras that measure depth, maps homes from them, asks in
which room a picture was taken and what stands where, as NumPy's arrays.
.
The small network that comes with Roomwise is in the package roomwise.")
endif()

if(ROOMWISE_LAB)
  roomwise_package(laboratory roomwise-lab
    SECTION science
    DEPENDS "roomwise (= ${PROJECT_VERSION})"
    RECOMMENDS "sweethome3d-furniture"
    DESCRIPTION "simulated homes, training and trials of Roomwise
Makes up furnished homes and records walks through them with the truth about
everything in them, compares maps, rooms and things with that truth, fits the
models that decide, and trains networks.")
endif()

include(CPack)
