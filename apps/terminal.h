// Shared by the programs: progress on a terminal, interruption, and errors as exit codes.
#pragma once

#include <difusa/core/progress.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// Shows phase, percentage and remaining time: on a terminal as one line that is overwritten, elsewhere as one line per
/// phase, and another if it is going to take minutes. Ctrl-C (SIGINT), SIGTERM and SIGHUP cancel, unless the caller
/// ignores them; a second one ends the process at once, and so does the first while input is read.
class TerminalProgress final : public Progress {
  public:
    explicit TerminalProgress(bool silent);
    ~TerminalProgress() override;
    TerminalProgress(const TerminalProgress&) = delete;
    TerminalProgress& operator=(const TerminalProgress&) = delete;

    void phase(std::string_view name) override;
    void advance(double fraction) override;
    void remark(std::string_view what) override;
    bool cancelled() const override;

    /// Prints the notes on standard error.
    void print_remarks();

    /// Does `work`; if it fails, other than by interruption, prints the notes, unless silent: it could not report them.
    void watch(const std::function<void()>& work);

    /// Clears the progress line on the terminal.
    void clear();

  private:
    using Clock = std::chrono::steady_clock;
    bool silent_, terminal_;
    bool shown_ = false;
    bool warned_ = false;                ///< that this phase will take minutes
    double fraction_ = 1.0, from_ = 0.0; ///< the latest of the current loop, and its first
    std::string phase_;
    std::vector<std::string> remarks_;
    Clock::time_point began_, last_shown_; ///< began_: the current loop
};

/// Runs `program`; turns what it throws into a message on standard error, "NAME: what", and the exit code. A standard
/// output that is full, closed or no longer read does not stop it: its files are written, and the exit code is
/// ExitCode::resources.
int run_program(const char* name, const std::function<void()>& program);

} // namespace difusa
