# libspeechd (speech-dispatcher's client), imported as Speechd::Speechd.
include(FindPackageHandleStandardArgs)
find_path(Speechd_INCLUDE_DIR libspeechd.h PATH_SUFFIXES speech-dispatcher)
find_library(Speechd_LIBRARY speechd)
find_package_handle_standard_args(Speechd REQUIRED_VARS Speechd_LIBRARY Speechd_INCLUDE_DIR)
if(Speechd_FOUND AND NOT TARGET Speechd::Speechd)
  add_library(Speechd::Speechd UNKNOWN IMPORTED)
  set_target_properties(Speechd::Speechd PROPERTIES
    IMPORTED_LOCATION ${Speechd_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${Speechd_INCLUDE_DIR})
endif()
