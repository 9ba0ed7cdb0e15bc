# difusa_add_plugin(<target> <source>...)
# Makes a plugin module of difusa: a shared module without "lib" before its name, linked to difusa::difusa, that
# exports nothing but its entry. Put the file where difusa looks for plugins, or name its folder with --plugin-path.
function(difusa_add_plugin target)
    add_library(${target} MODULE ${ARGN})
    target_link_libraries(${target} PRIVATE difusa::difusa)
    set_target_properties(${target} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()
