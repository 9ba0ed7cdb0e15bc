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

/// Two significant digits, without an exponent below a million: "0.00034", "1200".
std::string two_digits(double value);

} // namespace difusa
