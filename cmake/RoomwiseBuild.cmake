# How every target of Roomwise is compiled, and the two functions that declare a module and its tests.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

# One code generation for every target (x86-64 baseline): a translation unit that wants more chooses at run
# time. Mixed -march flags change Eigen's alignment from one target to the next and corrupt memory.
# -ffp-contract=off: the same seed gives the same bits whichever way the compiler would have fused.
add_compile_options(-Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off)
# Eigen asks this of the compiler, and fuses by itself where it is there, as on every arm64. What else it does otherwise
# there, two headers take back.
set(ROOMWISE_EIGEN_AS_ON_X86 "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  add_compile_options(-U__ARM_FEATURE_FMA)
  add_compile_definitions(EIGEN_DENSEBASE_PLUGIN="${PROJECT_SOURCE_DIR}/cmake/eigen_products_as_on_x86.h")
  set(ROOMWISE_EIGEN_AS_ON_X86 ${PROJECT_SOURCE_DIR}/cmake/eigen_as_on_x86.h)
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  add_compile_options(-O3)
endif()

# GCC collects garbage long before memory is short: without, it takes a tenth less time and 0.6 GB at most.
add_compile_options("$<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=600000>")

if(ROOMWISE_SANITIZE)
  add_compile_options(-fsanitize=${ROOMWISE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # GCC 12 sees uninitialised variables in the sanitizers' own code.
  add_compile_options(-Wno-maybe-uninitialized)
  add_link_options(-fsanitize=${ROOMWISE_SANITIZE})
endif()

# Everything is compiled so that libFuzzer sees which branches are taken (clang only; preset "fuzz").
option(ROOMWISE_FUZZ "Build the fuzz targets for libFuzzer" OFF)
if(ROOMWISE_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  add_link_options(-fsanitize=address,undefined)
endif()

# Precompiled headers take __TIME__ and the order of definitions away from what ccache can see; it must be told
# that neither matters here.
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()

# What is compiled as part of a module can also become part of a shared library (Python's, or a user's). Names stay within
# it, so that the code is what a program's would be: calls are direct and can be inlined.
function(roomwise_compile_for_sharing target)
  set_target_properties(${target} PROPERTIES
    POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# Half of what the compiler reads are the same few headers of libraries, so they are compiled once for all
# modules (roomwise_module_headers) and once for all tests (roomwise_test_headers). The sanitizers' presets
# do without, which keeps every file including what it uses.
function(add_shared_headers name headers)
  add_library(${name} OBJECT ${PROJECT_SOURCE_DIR}/cmake/shared_headers.cpp)
  target_link_libraries(${name} PRIVATE ${ARGN})
  target_precompile_headers(${name} PRIVATE ${ROOMWISE_EIGEN_AS_ON_X86} ${PROJECT_SOURCE_DIR}/cmake/${headers})
endfunction()

# Most of what is left of a clean build is headers read and templates made anew for every source, so sources of
# a target are compiled in batches. Names in unnamed namespaces must then differ within a target. The other
# presets do without, which keeps every file standing alone; who edits is faster without, too.
option(ROOMWISE_UNITY_BUILD "Compile the sources of a target in batches" OFF)
function(roomwise_compile_in_batches target)
  if(ROOMWISE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    # To the compiler a batch's sources are headers, in whose classes it wants no type of an unnamed namespace.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# roomwise_module(NAME [PRIVATE_MODULE] SOURCES a.cpp ... [LINKS target ...] [PRIVATE_LINKS target ...])
# declares the library roomwise_NAME (alias Roomwise::NAME); a module of headers alone gives no SOURCES. A
# part of a module that a small program takes alone is a target of its own, NAME_PART, which the module links. A
# PRIVATE_MODULE is not installed: only programs and tests of Roomwise link it.
function(roomwise_module name)
  cmake_parse_arguments(ARG "PRIVATE_MODULE" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  if(ARG_SOURCES)
    add_library(roomwise_${name} STATIC ${ARG_SOURCES})
    set(visibility PUBLIC)
    target_link_libraries(roomwise_${name} PRIVATE ${ARG_PRIVATE_LINKS})
    roomwise_compile_for_sharing(roomwise_${name})
    target_precompile_headers(roomwise_${name} REUSE_FROM roomwise_module_headers)
    roomwise_compile_in_batches(roomwise_${name})
  else()
    add_library(roomwise_${name} INTERFACE)
    set(visibility INTERFACE)
  endif()
  add_library(Roomwise::${name} ALIAS roomwise_${name})
  target_include_directories(roomwise_${name} ${visibility}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
  target_link_libraries(roomwise_${name} ${visibility} ${ARG_LINKS})
  if(NOT ARG_PRIVATE_MODULE)
    set_property(GLOBAL APPEND PROPERTY ROOMWISE_MODULES roomwise_${name})
  endif()
endfunction()

# What is tested is compiled as it ships; the tests themselves need no optimiser's time.
# At -O1 GCC 12 takes members of Eigen's matrices for uninitialised.
set(ROOMWISE_TEST_OPTIONS $<$<CONFIG:Release>:-O1;-Wno-maybe-uninitialized>)

# roomwise_test(NAME SOURCES a_test.cpp ... LINKS target ... [SUITES SuiteTest ...])
# declares the test program NAME_test; each GoogleTest case becomes a CTest of its own. Of SUITES, whose tests share
# what is dear to make (SetUpTestSuite), each becomes one CTest; none of their tests may skip itself.
function(roomwise_test name)
  if(NOT ROOMWISE_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;SUITES" ${ARGN})
  add_executable(${name}_test ${ARG_SOURCES})
  target_link_libraries(${name}_test PRIVATE ${ARG_LINKS} Roomwise::testing GTest::gmock_main)
  target_compile_options(${name}_test PRIVATE ${ROOMWISE_TEST_OPTIONS})
  target_precompile_headers(${name}_test REUSE_FROM roomwise_test_headers)
  roomwise_compile_in_batches(${name}_test)
  set(others "")
  if(ARG_SUITES)
    list(TRANSFORM ARG_SUITES APPEND ".*" OUTPUT_VARIABLE suites)
    list(JOIN suites ":" suites)
    set(others TEST_FILTER "-${suites}")
  endif()
  gtest_discover_tests(${name}_test TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 ${others}
    PROPERTIES SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\]" TIMEOUT 300)
  foreach(suite IN LISTS ARG_SUITES)
    add_test(NAME ${name}.${suite} COMMAND ${name}_test --gtest_filter=${suite}.*)
    # Long ones begin first. What does not run does not pass.
    set_tests_properties(${name}.${suite} PROPERTIES COST 100 TIMEOUT 900
      FAIL_REGULAR_EXPRESSION "\\[  SKIPPED \\];Running 0 tests")
  endforeach()
endfunction()
include(GoogleTest)
