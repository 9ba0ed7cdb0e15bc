#include "terminal.h"

#include <difusa/core/error.h>

#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

namespace difusa {

namespace {

volatile std::sig_atomic_t interrupted = 0;

void on_signal(int signal) {
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
    phase_ = name;
    began_ = last_shown_ = Clock::now();
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
    if (silent_ || !terminal_ || now - last_shown_ < std::chrono::milliseconds(100)) {
        return;
    }
    last_shown_ = now;
    const double passed = std::chrono::duration<double>(now - began_).count();
    const double left = fraction > 0.0 ? passed * (1.0 - fraction) / fraction : 0.0;
    std::fprintf(stderr, "\r\033[K%s %3.0f %%, %.0f s left", phase_.c_str(), 100.0 * fraction, std::ceil(left));
    std::fflush(stderr);
    shown_ = true;
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

bool TerminalProgress::cancelled() const {
    return interrupted != 0;
}

int run_program(const char* name, const std::function<void()>& program) {
    const auto report = [name](const char* what, ExitCode code) {
        std::fprintf(stderr, "%s: %s\n", name, what);
        return static_cast<int>(code);
    };
    std::signal(SIGXFSZ,
                SIG_IGN); // a file that grows too large then gives an error message instead of ending the process
    try {
        program();
        if (!std::cout.flush()) {
            throw ResourceError("cannot write to standard output");
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
