// The version of difusa, and the libraries it was built with.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// "0.1.0"
std::string version();

/// Name and version of each library difusa was built with, for example {"CGAL", "5.5.1"}.
std::vector<std::pair<std::string, std::string>> library_versions();

} // namespace difusa
