// What the programs share in reading their command lines (CLI11), and in judging the file names on them.
#pragma once

#include <difusa/core/error.h>
#include <difusa/core/types.h>

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
#include <thread>
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

/// Three finite numbers, "X,Y,Z".
Vec3 parse_point(const std::string& option, const std::string& text);

/// "0.5" or "0.5,0.4,0.3": finite numbers, none negative.
Rgb parse_rgb(const std::string& option, const std::string& text);

/// "0.5" or "0.5,-0.4,0.3": finite numbers with nothing but commas between; nothing if the text is anything else.
std::optional<std::vector<double>> parse_numbers(const std::string& text);

/// An option whose text `parse` turns into `target`. CLI11 alone would take -1 for a large number, and say of what it
/// cannot take only that it "could not convert".
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
        ->allow_extra_args(false); // one text each time
}

/// The same for words as they stand: names, directories.
template <class T>
CLI::Option* add_repeated(CLI::App& app, const std::string& name, std::vector<T>& target, const std::string& what) {
    return add_repeated(app, name, target, what, [](const std::string&, const std::string& text) { return T(text); });
}

/// A default as --help shows it.
template <class T> std::string shown(const T& value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

/// What all programs that compute can be told about how to run.
struct RunArguments {
    std::vector<std::filesystem::path> plugin_path;
    unsigned threads = std::max(1U, std::thread::hardware_concurrency());
    bool quiet = false, version = false;
};

/// --seed --threads --plugin-path --quiet --version, in the group `run_group`. Of the number of threads it is said
/// that `independent`, "the result does not depend", on it.
void add_run_arguments(CLI::App& app, RunArguments& run, std::uint64_t& seed, const std::string& independent);
inline constexpr const char* run_group = "Running";

/// Reads the command line into what `app` was told to, and runs `action`; answers --help, and `version` if that flag
/// was set. Refuses what is no option, with the nearest one that is, and what is too much: "`expected` are expected".
/// Returns the exit code, with all errors told on standard error.
int run_command(CLI::App& app, int count, char** words, const std::string& expected, const bool& version,
                const std::function<void()>& action);

/// A file to be written, and whether it is a field (.vtp, .ply).
struct OutputName {
    std::filesystem::path file; ///< empty: not written
    bool is_field = true;
};

/// All that can be wrong with the names of the files to be written is found before the work, not after it: throws
/// UsageError where an output would be written over an input ("the mesh") or another output, and what
/// `check_output_path` throws.
void check_outputs(const std::vector<OutputName>& outputs,
                   const std::vector<std::pair<std::filesystem::path, std::string>>& inputs);

} // namespace difusa
