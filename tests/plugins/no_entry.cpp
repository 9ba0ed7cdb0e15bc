// A tag that fits, and nothing behind it.
#include <difusa/plugin/plugin.h>

namespace {
__attribute__((used, retain, section(".difusa_plugin"))) const char tag[] =
    "difusa-plugin;kind=kernel;name=no-entry;" DIFUSA_BUILD_TAG;
} // namespace
