# espeak-ng (text to speech), imported as EspeakNg::EspeakNg.
include(FindPackageHandleStandardArgs)
find_path(EspeakNg_INCLUDE_DIR espeak-ng/speak_lib.h)
find_library(EspeakNg_LIBRARY espeak-ng)
find_package_handle_standard_args(EspeakNg REQUIRED_VARS EspeakNg_LIBRARY EspeakNg_INCLUDE_DIR)
if(EspeakNg_FOUND AND NOT TARGET EspeakNg::EspeakNg)
  add_library(EspeakNg::EspeakNg UNKNOWN IMPORTED)
  set_target_properties(EspeakNg::EspeakNg PROPERTIES
    IMPORTED_LOCATION ${EspeakNg_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${EspeakNg_INCLUDE_DIR})
endif()
