// What the programs share: progress on a terminal, interruption, and errors as exit codes.
#pragma once

#include <difusa/core/progress.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// Shows phase, percent and remaining time: one line that is rewritten on a terminal, a line a phase elsewhere.
/// Ctrl-C (SIGINT), SIGTERM and SIGHUP cancel, unless the caller ignores them; a second one ends the process at once.
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

    /// Says on standard error what was remarked: for runs that fail and will not say it otherwise.
    void print_remarks();

    /// Takes the progress line off the terminal.
    void clear();

  private:
    using Clock = std::chrono::steady_clock;
    bool silent_, terminal_;
    bool shown_ = false;
    std::string phase_;
    std::vector<std::string> remarks_;
    Clock::time_point began_, last_shown_;
};

/// Runs `program`; turns what it throws, and a standard output that takes no more, into a message on standard error,
/// "NAME: what", and the exit code.
int run_program(const char* name, const std::function<void()>& program);

} // namespace difusa
