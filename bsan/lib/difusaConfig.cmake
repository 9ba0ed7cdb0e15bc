# find_package(difusa): the target difusa::difusa, the function difusa_add_plugin(), and difusa_PLUGIN_DIR, the folder
# in which the library looks for plugins.

####### Expanded from @PACKAGE_INIT@ by configure_package_config_file() #######
####### Any changes to this file will be overwritten by the next CMake run ####
####### The input file was difusaConfig.cmake.in                            ########

get_filename_component(PACKAGE_PREFIX_DIR "${CMAKE_CURRENT_LIST_DIR}/../../../" ABSOLUTE)

macro(set_and_check _var _file)
  set(${_var} "${_file}")
  if(NOT EXISTS "${_file}")
    message(FATAL_ERROR "File or directory ${_file} referenced by variable ${_var} does not exist !")
  endif()
endmacro()

####################################################################################

# Before other packages are found: they set the variable in it to their own prefix.
set(difusa_PLUGIN_DIR "${PACKAGE_PREFIX_DIR}/lib/difusa/plugins")

include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4 NO_MODULE)
include("${CMAKE_CURRENT_LIST_DIR}/difusaTargets.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/difusa_add_plugin.cmake")
