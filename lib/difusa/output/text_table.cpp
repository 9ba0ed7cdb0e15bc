#include <difusa/output/text_table.h>

#include <algorithm>
#include <cstdio>

namespace difusa {

std::string text_table(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> width(rows.front().size(), 0);
    for (const std::vector<std::string>& row : rows) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            width[c] = std::max(width[c], row[c].size());
        }
    }
    std::string text;
    for (const std::vector<std::string>& row : rows) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::string blank(width[c] - row[c].size(), ' ');
            text += (c == 0 ? "" : "  ") + (c == 0 ? row[c] + blank : blank + row[c]);
        }
        text += "\n";
    }
    return text;
}

std::string formatted(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

} // namespace difusa
