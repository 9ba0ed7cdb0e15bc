// Command line parsing (CLI11) shared by the programs, and checks of the file names given there.
#pragma once

#include <difusa/core/error.h>
#include <difusa/core/progress.h>
#include <difusa/core/types.h>
#include <difusa/rays/directions.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// A whole number of at least `least`.
template <class T> T parse_whole(const std::string& option, const std::string& text, T least) {
    T value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range && text[0] != '-') {
        throw UsageError(option + " " + text + ": must be at most " + std::to_string(std::numeric_limits<T>::max()));
    }
    if (error != std::errc() || end != text.data() + text.size() || value < least) {
        throw UsageError(option + " " + text + ": must be a whole number of at least " + std::to_string(least));
    }
    return value;
}

/// A positive, finite number.
double parse_positive(const std::string& option, const std::string& text);

/// "500MB", "4GiB" or "2e9" as bytes. Throws UsageError.
double parse_bytes(const std::string& option, const std::string& text);

/// "1%" or "0.5 %" as a positive share. Throws UsageError.
double parse_percent(const std::string& option, const std::string& text);

/// Three finite numbers, "X,Y,Z".
Vec3 parse_point(const std::string& option, const std::string& text);

/// "0.5" or "0.5,0.4,0.3": finite numbers, none negative.
Rgb parse_rgb(const std::string& option, const std::string& text);

/// "0.5" or "0.5,-0.4,0.3": finite numbers separated only by commas; empty if the text is anything else.
std::optional<std::vector<double>> parse_numbers(const std::string& text);

/// Throws UsageError if the directions `choice` say themselves how many rays there are, so that --rays does nothing.
void check_rays(std::size_t rays, const std::string& choice, const Directions& directions);

/// An option whose text `parse` converts to `target`. CLI11 alone would accept -1 as a large number, and would only say
/// "could not convert" about text it rejects.
template <class T, class Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, T& target, const std::string& what, Parse parse) {
    return app.add_option_function<std::string>(
        name, [&target, name, parse](const std::string& text) { target = parse(name, text); }, what);
}

template <class T>
CLI::Option* add_whole(CLI::App& app, const std::string& name, T& target, T least, const std::string& what) {
    return add_parsed(app, name, target, what, [least](const std::string& option, const std::string& text) {
        return parse_whole<T>(option, text, least);
    });
}

/// An option that may be repeated; `parse` turns each text into one more entry of `target`.
template <class T, class Parse>
CLI::Option* add_repeated(CLI::App& app, const std::string& name, std::vector<T>& target, const std::string& what,
                          Parse parse) {
    return app
        .add_option_function<std::vector<std::string>>(
            name,
            [&target, name, parse](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) {
                    target.push_back(parse(name, text));
                }
            },
            what)
        ->expected(-1)
        ->allow_extra_args(false); // one text per occurrence
}

/// The same for plain words: names, directories.
template <class T>
CLI::Option* add_repeated(CLI::App& app, const std::string& name, std::vector<T>& target, const std::string& what) {
    return add_repeated(app, name, target, what, [](const std::string&, const std::string& text) { return T(text); });
}

/// A default as shown by --help.
template <class T> std::string shown(const T& value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

/// Run settings common to all programs that compute.
struct RunArguments {
    std::vector<std::filesystem::path> plugin_path;
    unsigned threads = processors();
    double most_memory = std::numeric_limits<double>::infinity(); ///< bytes for the whole process
    bool quiet = false, version = false;

    Execution execution(Progress& progress) const { return {threads, &progress, nullptr, most_memory}; }
};

/// --seed --threads --max-memory --plugin-path --quiet --version, in the group `run_group`. `independent` is what the
/// help says of the number of threads: "the result does not depend".
void add_run_arguments(CLI::App& app, RunArguments& run, std::uint64_t& seed, const std::string& independent);

/// The same without --seed.
void add_run_arguments(CLI::App& app, RunArguments& run, const std::string& independent);
inline constexpr const char* run_group = "Running";

/// Parses the command line into the targets declared on `app` and runs `action`; answers --help, and `version` if that
/// flag was set. Rejects unknown options, suggesting the nearest known one, and surplus arguments: "`expected` are
/// expected". Returns the exit code; all errors are reported on standard error.
int run_command(CLI::App& app, int count, char** words, const std::string& expected, const bool& version,
                const std::function<void()>& action);

/// An output file, and whether it is a field (.vtp, .ply, .glb).
struct OutputName {
    std::filesystem::path file; ///< empty: not written
    bool is_field = true;
};

/// Finds everything wrong with the output file names before the work starts: throws UsageError if an output would
/// overwrite an input named on the command line ("the mesh") or another output, and whatever `check_output_path`
/// throws.
void check_outputs(const std::vector<OutputName>& outputs,
                   const std::vector<std::pair<std::filesystem::path, std::string>>& inputs);

} // namespace difusa
