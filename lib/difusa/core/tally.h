// Counts how often a reader met something worth a note, and where first.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

struct Tally {
    const char* unit = "line"; ///< of places: "line" or "byte"
    std::size_t count = 0;
    std::size_t place = 0; ///< of the first occurrence
    std::string word = {}; ///< the text there, in quotation marks; may be empty

    void add(std::size_t where, const std::string& what = {}) {
        if (count++ == 0) {
            place = where;
            word = what;
        }
    }

    /// Appends "things: 3 (first at line 7: 'l'); meaning" unless there was none.
    void note(const std::string& things, const std::string& meaning, std::vector<std::string>& notes) const {
        if (count > 0) {
            notes.push_back(things + ": " + std::to_string(count) + " (first at " + unit + " " + std::to_string(place) +
                            (word.empty() ? "" : ": " + word) + "); " + meaning);
        }
    }
};

} // namespace difusa
