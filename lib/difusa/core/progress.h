// How a long computation tells its caller where it is, and learns that it should stop.
#pragma once

#include <difusa/core/error.h>

#include <string_view>

namespace difusa {

/// Override what you need; the base class is silent and never cancels.
/// `phase` and `advance` are called from the thread that started the computation, `cancelled` from any.
class Progress {
  public:
    virtual ~Progress() = default;

    /// A new phase begins, for example "transport".
    virtual void phase(std::string_view /*name*/) {}

    /// The share of the current phase that is done, in [0,1].
    virtual void advance(double /*fraction*/) {}

    /// Something the user should know, told as soon as it is known: also if the computation fails later.
    virtual void remark(std::string_view /*what*/) {}

    /// True once the computation should end; it then throws Interrupted soon.
    virtual bool cancelled() const { return false; }

    /// Throws Interrupted if cancelled.
    void check() const {
        if (cancelled()) {
            throw Interrupted();
        }
    }
};

/// How to compute: threads, and whom to tell. A plain value, handed down by reference.
struct Execution {
    unsigned threads = 1;         ///< at least 1
    Progress* progress = nullptr; ///< may be null: silent

    void phase(std::string_view name) const {
        if (progress != nullptr) {
            progress->check();
            progress->phase(name);
        }
    }
};

} // namespace difusa
