// The properties in which library and plugin must agree for their C++ types to be compatible in memory.
#pragma once

#include <Eigen/Core>

#define DIFUSA_STRING_2(x) #x
#define DIFUSA_STRING(x) DIFUSA_STRING_2(x)

/// Incremented whenever a declaration visible to plugins changes its meaning or layout.
#define DIFUSA_INTERFACE_VERSION 8

// The standard library, the layout of its strings, and its debug containers, which are larger.
#if defined(__GLIBCXX__) && defined(_GLIBCXX_DEBUG)
#define DIFUSA_STANDARD_LIBRARY "libstdc++" DIFUSA_STRING(_GLIBCXX_USE_CXX11_ABI) "-debug"
#elif defined(__GLIBCXX__)
#define DIFUSA_STANDARD_LIBRARY "libstdc++" DIFUSA_STRING(_GLIBCXX_USE_CXX11_ABI)
#elif defined(_LIBCPP_VERSION)
#define DIFUSA_STANDARD_LIBRARY "libc++" DIFUSA_STRING(_LIBCPP_ABI_VERSION)
#else
#define DIFUSA_STANDARD_LIBRARY "unknown"
#endif

// Eigen's version, its alignment of objects and heap memory, and whether it takes that of malloc: with -mavx, or GCC's
// -fsanitize=address, a matrix made here could not be freed there.
#define DIFUSA_EIGEN                                                                                                   \
    DIFUSA_STRING(EIGEN_WORLD_VERSION)                                                                                 \
    "." DIFUSA_STRING(EIGEN_MAJOR_VERSION) "." DIFUSA_STRING(EIGEN_MINOR_VERSION) "/" DIFUSA_STRING(                   \
        EIGEN_MAX_STATIC_ALIGN_BYTES) "/" DIFUSA_STRING(EIGEN_DEFAULT_ALIGN_BYTES) "/" DIFUSA_STRING(EIGEN_MALLOC_ALREADY_ALIGNED)

/// "interface=8;library=libstdc++1;eigen=3.4.0/16/16/1": the build tags.
#define DIFUSA_BUILD_TAG                                                                                               \
    "interface=" DIFUSA_STRING(DIFUSA_INTERFACE_VERSION) ";library=" DIFUSA_STANDARD_LIBRARY ";eigen=" DIFUSA_EIGEN
