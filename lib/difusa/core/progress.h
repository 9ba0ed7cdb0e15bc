// How a long computation reports progress to its caller, and learns that it should stop.
#pragma once

#include <difusa/core/error.h>
#include <difusa/core/journal.h>
#include <difusa/core/memory.h>

#include <limits>
#include <string>
#include <string_view>
#include <utility>

namespace difusa {

/// Override what you need; the base class is silent and never cancels.
/// `phase` and `advance` are called from the thread that started the computation, `cancelled` from any.
class Progress {
  public:
    virtual ~Progress() = default;

    /// A new phase begins, for example "transport".
    virtual void phase(std::string_view /*name*/) {}

    /// The completed share of the current phase, in [0,1].
    virtual void advance(double /*fraction*/) {}

    /// Something the user should know, reported as soon as it is known, even if the computation fails later.
    virtual void remark(std::string_view /*what*/) {}

    /// True once the computation should stop; it then throws Interrupted soon.
    virtual bool cancelled() const { return false; }

    /// Throws Interrupted if cancelled.
    void check() const {
        if (cancelled()) {
            throw Interrupted();
        }
    }
};

/// Reports nothing, and is cancelled with another, which may be null. Override what is to be reported.
class SubordinateProgress : public Progress {
  public:
    explicit SubordinateProgress(Progress* whole) : whole_(whole) {}
    bool cancelled() const final { return whole_ != nullptr && whole_->cancelled(); }

  protected:
    Progress* whole() const { return whole_; }

  private:
    Progress* whole_;
};

/// The number of processors that this process may run on, at least 1.
unsigned processors();

/// How to compute: threads, progress reporting, and where to record. A plain value, passed by reference.
struct Execution {
    unsigned threads = processors();                              ///< at least 1; results do not depend on it
    Progress* progress = nullptr;                                 ///< may be null: silent
    Journal* journal = nullptr;                                   ///< may be null: nothing is recorded
    double most_memory = std::numeric_limits<double>::infinity(); ///< bytes that the whole process may take

    /// Bytes that can still be allocated.
    std::size_t memory_left() const { return available_memory(most_memory); }

    /// The same with another progress and journal.
    Execution with(Progress* other, Journal* journal_of_it) const {
        return {threads, other, journal_of_it, most_memory};
    }

    /// Starts a new phase. Throws Interrupted if the computation was cancelled, UsageError without any threads.
    void phase(std::string_view name) const {
        if (threads == 0) {
            throw UsageError("threads: at least 1 is needed");
        }
        if (progress != nullptr) {
            progress->check();
            progress->phase(name);
        }
        if (journal != nullptr) {
            journal->begin(name);
        }
    }

    /// Something the user should know.
    void note(const std::string& text) const {
        if (journal != nullptr) {
            journal->note(text);
        }
        if (progress != nullptr) {
            progress->remark(text);
        }
    }

    /// The same for something that many steps may find; the journal, if there is one, holds it once.
    void note_once(const std::string& text) const {
        if (journal == nullptr || !journal->has_note(text)) {
            note(text);
        }
    }

    void save(Saving saving) const {
        if (journal != nullptr) {
            journal->save(std::move(saving));
        }
    }

    void count(const std::string& name, std::size_t amount) const {
        if (journal != nullptr) {
            journal->count(name, amount);
        }
    }

    /// Throws Interrupted if the computation was cancelled.
    void check() const {
        if (progress != nullptr) {
            progress->check();
        }
    }

    /// The same threads without progress reports, for loops too short to matter.
    Execution silent() const { return with(nullptr, nullptr); }
};

/// The same threads without progress reports, for one of several loops of a phase; it can still be cancelled.
class Unreported {
  public:
    explicit Unreported(const Execution& execution)
        : progress_(execution.progress), execution_(execution.with(&progress_, nullptr)) {}
    Unreported(const Unreported&) = delete;
    Unreported& operator=(const Unreported&) = delete;

    operator const Execution&() const { return execution_; }

  private:
    SubordinateProgress progress_;
    Execution execution_;
};

} // namespace difusa
