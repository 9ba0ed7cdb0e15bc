#include "terminal.h"

#include <difusa/core/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>

namespace difusa {

namespace {

volatile std::sig_atomic_t interrupted = 0;
volatile std::sig_atomic_t nothing_to_clean_up = 0; ///< until input has been read
const char* volatile interruption = nullptr;        ///< what is said then

void on_signal(int signal) {
    if (nothing_to_clean_up != 0) { // readers do not look whether they are to stop
        if (const char* const said = interruption; said != nullptr) {
            [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, said, std::strlen(said));
        }
        _exit(static_cast<int>(ExitCode::interrupted));
    }
    interrupted = 1;
    std::signal(signal, SIG_DFL); // the next one ends the process
}

/// What the caller ignores (nohup, a background job of a script) stays ignored.
void cancel_on(int signal) {
    if (std::signal(signal, on_signal) == SIG_IGN) {
        std::signal(signal, SIG_IGN);
    }
}

} // namespace

TerminalProgress::TerminalProgress(bool silent) : silent_(silent), terminal_(isatty(STDERR_FILENO) != 0) {
    nothing_to_clean_up = 1;
    cancel_on(SIGINT);
    cancel_on(SIGTERM);
    cancel_on(SIGHUP);
}

TerminalProgress::~TerminalProgress() {
    clear();
}

void TerminalProgress::clear() {
    if (shown_) {
        std::fputs("\r\033[K", stderr);
        shown_ = false;
    }
}

void TerminalProgress::phase(std::string_view name) {
    nothing_to_clean_up = name == "read" ? 1 : 0;
    phase_ = name;
    began_ = last_shown_ = Clock::now();
    fraction_ = 1.0; // until a loop begins
    warned_ = false;
    if (silent_) {
        return;
    }
    if (terminal_) {
        clear();
        std::fprintf(stderr, "%s ...", phase_.c_str());
        std::fflush(stderr);
        shown_ = true;
    } else {
        std::fprintf(stderr, "%s\n", phase_.c_str());
    }
}

void TerminalProgress::advance(double fraction) {
    const Clock::time_point now = Clock::now();
    if (fraction < fraction_) { // the next loop of the phase
        began_ = now;
        from_ = fraction;
    }
    fraction_ = fraction;
    if (silent_ || now - last_shown_ < std::chrono::milliseconds(100)) {
        return;
    }
    last_shown_ = now;
    const double passed = std::chrono::duration<double>(now - began_).count();
    const double left = fraction > from_ ? passed * (1.0 - fraction) / (fraction - from_) : 0.0;
    if (terminal_) {
        std::fprintf(stderr, "\r\033[K%s %3.0f %%, %.0f s left", phase_.c_str(), 100.0 * fraction, std::ceil(left));
        std::fflush(stderr);
        shown_ = true;
    } else if (!warned_ && passed > 1.0 && left > 60.0) {
        std::fprintf(stderr, "%s: about %.0f min left\n", phase_.c_str(), std::ceil(left / 60.0));
        warned_ = true;
    }
}

void TerminalProgress::remark(std::string_view what) {
    remarks_.emplace_back(what);
}

void TerminalProgress::print_remarks() {
    clear();
    for (const std::string& what : remarks_) {
        std::fprintf(stderr, "note: %s\n", what.c_str());
    }
}

void TerminalProgress::watch(const std::function<void()>& work) {
    try {
        work();
    } catch (const Error& error) {
        if (!silent_ && error.code() != ExitCode::interrupted) {
            print_remarks();
        }
        throw;
    }
}

bool TerminalProgress::cancelled() const {
    return interrupted != 0;
}

namespace {

/// The number of a standard stream that the caller has closed would be given to the next file that is opened, which
/// would then receive what is printed. What takes its place here cannot be written to, or read from, either.
void occupy_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (fcntl(stream, F_GETFD) < 0 && errno == EBADF) {
            open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY); // the lowest free number
        }
    }
}

} // namespace

int run_program(const char* name, const std::function<void()>& program) {
    const auto report = [name](const char* what, ExitCode code) {
        std::fprintf(stderr, "%s: %s\n", name, what);
        return static_cast<int>(code);
    };
    static std::string said; // for as long as signals may come
    said = std::string(isatty(STDERR_FILENO) != 0 ? "\r\033[K" : "") + name + ": interrupted\n";
    interruption = said.c_str();
    occupy_standard_streams();
    // A file that grows too large and a reader that has gone are then errors, instead of the end of the process.
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
    try {
        program();
        if (!std::cout.flush()) {
            throw ResourceError("cannot write to standard output; files are complete");
        }
        return static_cast<int>(ExitCode::done);
    } catch (const Error& error) {
        return report(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return report("out of memory: give a larger --spacing or --output-spacing, or fewer --rays",
                      ExitCode::resources);
    } catch (const std::exception& error) {
        return report((std::string("internal error: ") + error.what()).c_str(), ExitCode::internal);
    } catch (...) {
        return report("internal error: something other than an exception was thrown (by a plugin?)",
                      ExitCode::internal);
    }
}

} // namespace difusa
