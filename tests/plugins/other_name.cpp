// An entry that describes something else than the tag promised.
#include <difusa/plugin/plugin.h>

namespace {
__attribute__((used, retain, section(".difusa_plugin"))) const char tag[] =
    "difusa-plugin;kind=kernel;name=promised;" DIFUSA_BUILD_TAG;
} // namespace

extern "C" __attribute__((visibility("default"))) const difusa::PluginDescription* difusa_plugin_entry();
extern "C" const difusa::PluginDescription* difusa_plugin_entry() {
    static const difusa::PluginDescription description{
        "kernel", "delivered", "", {}, [](const difusa::Parameters&) -> void* { return nullptr; }};
    return &description;
}
