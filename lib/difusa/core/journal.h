// The record of a computation: phases with their times, notes, savings and counts.
#pragma once

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace difusa {

/// Work that the scene did not need and that was therefore skipped.
struct Saving {
    std::string what;    ///< "shadow rays"
    std::string because; ///< "the room is convex and empty"
    std::string unit;    ///< "rays"
    double amount = 0.0; ///< the amount of work saved
};

/// Written by the thread that started the computation.
class Journal {
  public:
    /// Ends the current phase, if any, and starts one of that name.
    void begin(std::string_view phase) {
        end();
        phase_ = phase;
        began_ = std::chrono::steady_clock::now();
    }
    void end() {
        if (!phase_.empty()) {
            const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began_;
            seconds_.emplace_back(phase_, took.count());
            phase_.clear();
        }
    }
    void note(std::string text) { notes_.push_back(std::move(text)); }
    void save(Saving saving) { savings_.push_back(std::move(saving)); }
    void count(const std::string& name, std::size_t amount) { counts_[name] += amount; }
    /// Adds what another one holds after what is here.
    void append(const Journal& other) {
        seconds_.insert(seconds_.end(), other.seconds_.begin(), other.seconds_.end());
        notes_.insert(notes_.end(), other.notes_.begin(), other.notes_.end());
        savings_.insert(savings_.end(), other.savings_.begin(), other.savings_.end());
        append_counts(other);
    }

    /// Adds its counts only: those of work that is part of a phase of this one.
    void append_counts(const Journal& other) {
        for (const auto& [name, amount] : other.counts_) {
            counts_[name] += amount;
        }
    }

    /// Adds its times and counts only: those of work whose outcome was replaced.
    void append_effort(const Journal& other) {
        Journal effort;
        effort.seconds_ = other.seconds_;
        effort.counts_ = other.counts_;
        append(effort);
    }

    const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; } ///< wall time, in order
    const std::vector<std::string>& notes() const { return notes_; }
    bool has_note(const std::string& text) const {
        return std::find(notes_.begin(), notes_.end(), text) != notes_.end();
    }
    const std::vector<Saving>& savings() const { return savings_; }
    std::size_t count_of(const std::string& name) const {
        const auto found = counts_.find(name);
        return found == counts_.end() ? 0 : found->second;
    }

  private:
    std::string phase_;
    std::chrono::steady_clock::time_point began_;
    std::vector<std::pair<std::string, double>> seconds_;
    std::vector<std::string> notes_;
    std::vector<Saving> savings_;
    std::map<std::string, std::size_t> counts_;
};

} // namespace difusa
