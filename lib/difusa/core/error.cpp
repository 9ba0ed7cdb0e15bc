#include <difusa/core/error.h>

namespace difusa {

void require(bool holds, const char* expression, const char* file, int line, const std::string& values) {
    if (holds) {
        return;
    }
    std::string message = "broken invariant `" + std::string(expression) + "` at " + file + ":" + std::to_string(line);
    if (!values.empty()) {
        message += " (" + values + ")";
    }
    throw InternalError(message);
}

} // namespace difusa
