# The target "reference": pages of the library's headers, by doxygen. ROOMWISE_REFERENCE makes them part of the manual.
set(ROOMWISE_REFERENCE_PAGES ${PROJECT_BINARY_DIR}/reference/html)
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
  set(lacking "The pages of the library's headers need doxygen (Debian: doxygen), which is not installed")
  if(ROOMWISE_REFERENCE)
    message(FATAL_ERROR "${lacking}. Install it, or build the manual without them: -DROOMWISE_REFERENCE=OFF")
  endif()
  add_custom_target(reference COMMAND ${CMAKE_COMMAND} -E echo "${lacking}" COMMAND ${CMAKE_COMMAND} -E false VERBATIM)
  return()
endif()

configure_file(${PROJECT_SOURCE_DIR}/docs/Doxyfile.in ${PROJECT_BINARY_DIR}/reference.doxyfile @ONLY)
file(GLOB_RECURSE headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/roomwise/*.h)
add_custom_command(OUTPUT ${ROOMWISE_REFERENCE_PAGES}/index.html
  COMMAND ${DOXYGEN_EXECUTABLE} ${PROJECT_BINARY_DIR}/reference.doxyfile
  DEPENDS ${PROJECT_BINARY_DIR}/reference.doxyfile ${headers}
  COMMENT "Making pages of the library's headers: reference/html/index.html"
  VERBATIM)
add_custom_target(reference DEPENDS ${ROOMWISE_REFERENCE_PAGES}/index.html)

# Into a folder of the test's own, so that it can run while something is built.
if(ROOMWISE_BUILD_TESTS)
  find_package(Python 3.9 REQUIRED COMPONENTS Interpreter)
  add_test(NAME docs_reference
    COMMAND ${Python_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tests/check_reference.py ${DOXYGEN_EXECUTABLE}
      ${PROJECT_BINARY_DIR}/reference.doxyfile ${PROJECT_SOURCE_DIR}/examples)
endif()
