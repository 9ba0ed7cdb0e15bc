// A tag that fits, and an entry that fails.
#include <difusa/plugin/plugin.h>

#include <stdexcept>

namespace {
__attribute__((used, retain, section(".difusa_plugin"))) const char tag[] =
    "difusa-plugin;kind=kernel;name=throwing-entry;" DIFUSA_BUILD_TAG;
} // namespace

extern "C" __attribute__((visibility("default"))) const difusa::PluginDescription* difusa_plugin_entry();
extern "C" const difusa::PluginDescription* difusa_plugin_entry() {
    throw std::runtime_error("the licence of this plugin has expired");
}
