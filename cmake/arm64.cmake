# To compile for Debian 12 on arm64 by Debian's cross compiler: CMAKE_TOOLCHAIN_FILE of the presets arm64. Libraries and
# headers come from ROOMWISE_ARM64_ROOT (packaging/arm64.sh makes it), never from this machine. What is built is run by
# qemu where the build must run it, and for the tests.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)

set(_root "$ENV{ROOMWISE_ARM64_ROOT}")
if(_root STREQUAL "")
  get_filename_component(_root ${CMAKE_CURRENT_LIST_DIR}/../build/arm64-root ABSOLUTE)
endif()
set(ROOMWISE_ARM64_ROOT ${_root} CACHE PATH "Debian 12 for arm64, unpacked")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ROOMWISE_ARM64_ROOT)
if(NOT EXISTS ${ROOMWISE_ARM64_ROOT}/usr/lib/aarch64-linux-gnu)
  message(FATAL_ERROR "${ROOMWISE_ARM64_ROOT} is no Debian for arm64: packaging/arm64.sh makes it "
    "(ROOMWISE_ARM64_ROOT in the environment names another folder)")
endif()

set(CMAKE_SYSROOT ${ROOMWISE_ARM64_ROOT})
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH ${ROOMWISE_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# Statically linked where there is a choice: it then needs nothing of this machine's libraries.
find_program(ROOMWISE_QEMU NAMES qemu-aarch64-static qemu-aarch64)
if(ROOMWISE_QEMU)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${ROOMWISE_QEMU} -L ${ROOMWISE_ARM64_ROOT})
endif()
