// Tables for people.
#pragma once

#include <string>
#include <vector>

namespace difusa {

/// Columns as wide as their widest cell, two blanks apart: the first to the left, the others to the right. All rows
/// have as many cells as the first.
std::string text_table(const std::vector<std::vector<std::string>>& rows);

/// By a format of printf for one double.
std::string formatted(const char* format, double value);

} // namespace difusa
