#----------------------------------------------------------------
# Generated CMake target import file for configuration "Debug".
#----------------------------------------------------------------

# Commands may need to know the format version.
set(CMAKE_IMPORT_FILE_VERSION 1)

# Import target "difusa::difusa" for configuration "Debug"
set_property(TARGET difusa::difusa APPEND PROPERTY IMPORTED_CONFIGURATIONS DEBUG)
set_target_properties(difusa::difusa PROPERTIES
  IMPORTED_LINK_DEPENDENT_LIBRARIES_DEBUG "OpenMeshCore;VTK::CommonCore;VTK::CommonDataModel;VTK::IOXML"
  IMPORTED_LOCATION_DEBUG "${_IMPORT_PREFIX}/lib/libdifusa.so.0.1.0"
  IMPORTED_SONAME_DEBUG "libdifusa.so.0.1"
  )

list(APPEND _cmake_import_check_targets difusa::difusa )
list(APPEND _cmake_import_check_files_for_difusa::difusa "${_IMPORT_PREFIX}/lib/libdifusa.so.0.1.0" )

# Commands beyond this point should not need to know the version.
set(CMAKE_IMPORT_FILE_VERSION)
