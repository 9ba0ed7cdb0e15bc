// Errors, classified by who can fix them. Library code deliberately throws only these; a program turns them into the
// exit codes below.
#pragma once

#include <stdexcept>
#include <string>

namespace difusa {

/// Exit codes of every difusa program.
enum class ExitCode : int {
    done = 0,
    usage = 1,         ///< an option, plugin or parameter is wrong
    input = 2,         ///< a file cannot be read, or the scene cannot be baked
    not_converged = 3, ///< the discretised equation has no reliable solution
    resources = 4,     ///< memory or disk would not suffice
    internal = 5,      ///< a broken invariant: a bug
    interrupted = 130
};

/// Base of all errors of the library. `what()` says what happened, where, and what to do.
class Error : public std::runtime_error {
  public:
    Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    ExitCode code() const noexcept { return code_; }

  private:
    ExitCode code_;
};

struct UsageError : Error {
    explicit UsageError(const std::string& message) : Error(ExitCode::usage, message) {}
};
struct InputError : Error {
    explicit InputError(const std::string& message) : Error(ExitCode::input, message) {}
};
struct NotConverged : Error {
    explicit NotConverged(const std::string& message) : Error(ExitCode::not_converged, message) {}
};
struct ResourceError : Error {
    explicit ResourceError(const std::string& message) : Error(ExitCode::resources, message) {}
};
struct InternalError : Error {
    explicit InternalError(const std::string& message) : Error(ExitCode::internal, message) {}
};
struct Interrupted : Error {
    Interrupted() : Error(ExitCode::interrupted, "interrupted") {}
};

/// Throws InternalError with the expression, its location and `values` if `holds` is false.
void require(bool holds, const char* expression, const char* file, int line, const std::string& values = {});

} // namespace difusa

/// A broken invariant of difusa itself (never a user error); active in every build.
#define DIFUSA_REQUIRE(expression, ...)                                                                                \
    ((expression) ? void() : ::difusa::require(false, #expression, __FILE__, __LINE__ __VA_OPT__(, ) __VA_ARGS__))
