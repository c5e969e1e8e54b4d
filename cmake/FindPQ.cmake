# libpq, PostgreSQL's client, imported as PQ::PQ. CMake's own module asks for the server's headers, too.
include(FindPackageHandleStandardArgs)
find_path(PQ_INCLUDE_DIR libpq-fe.h PATH_SUFFIXES postgresql)
find_library(PQ_LIBRARY pq)
find_package_handle_standard_args(PQ REQUIRED_VARS PQ_LIBRARY PQ_INCLUDE_DIR)
if(PQ_FOUND AND NOT TARGET PQ::PQ)
  add_library(PQ::PQ UNKNOWN IMPORTED)
  set_target_properties(PQ::PQ PROPERTIES
    IMPORTED_LOCATION ${PQ_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${PQ_INCLUDE_DIR})
endif()
