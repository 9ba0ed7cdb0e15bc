# difusa_add_plugin(<target> <source>...)
# Builds a difusa plugin module: a shared module without the "lib" prefix, linked to difusa::difusa, that exports only
# its entry. Put the file where difusa looks for plugins, or name its folder with --plugin-path.
function(difusa_add_plugin target)
    add_library(${target} MODULE ${ARGN})
    target_link_libraries(${target} PRIVATE difusa::difusa)
    set_target_properties(${target} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()
