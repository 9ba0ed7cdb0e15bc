// A plugin of a kind that does not exist.
#include <difusa/plugin/plugin.h>

namespace {
__attribute__((used, retain, section(".difusa_plugin"))) const char tag[] =
    "difusa-plugin;kind=teapot;name=unknown-kind;" DIFUSA_BUILD_TAG;
} // namespace
