#include "arguments.h"
#include "terminal.h"

#include <difusa/io/field_file.h>
#include <difusa/io/same_file.h>
#include <difusa/plugin/parameters.h>
#include <difusa/version.h>

#include <cmath>
#include <iostream>
#include <map>
#include <utility>

namespace difusa {

namespace {

void refuse_unknown(const CLI::App& app, const std::string& expected) {
    std::vector<std::string> known;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) {
            known.push_back("--" + name);
        }
    }
    std::string extra;
    for (const std::string& word : app.remaining()) {
        if (word.size() > 1 && word[0] == '-') {
            const std::string name = word.substr(0, word.find('='));
            const std::string near = nearest_name(name, known);
            throw UsageError("unknown option " + name + (near.empty() ? "" : ", did you mean " + near + "?") +
                             " (--help lists all)");
        }
        extra = extra.empty() ? word : extra;
    }
    if (!extra.empty()) {
        throw UsageError(expected + " are expected; `" + extra + "` is one argument too many (--help)");
    }
}

} // namespace

void check_rays(std::size_t rays, const std::string& choice, const Directions& directions) {
    const std::size_t stated = directions.size(1);
    if (stated == directions.size(std::size_t{1} << 20U)) {
        throw UsageError("--rays " + std::to_string(rays) + ": has no effect together with --directions " + choice +
                         ", whose resolution means " + std::to_string(stated) +
                         " rays; omit --rays, or the resolution, which then follows from --rays");
    }
}

double parse_positive(const std::string& option, const std::string& text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value > 0.0) || !std::isfinite(value)) {
        throw UsageError(option + " " + text + ": must be a positive number");
    }
    return value;
}

std::optional<std::vector<double>> parse_numbers(const std::string& text) {
    std::vector<double> values;
    const char* at = text.data();
    const char* const end = at + text.size();
    for (;;) {
        double value = 0.0;
        const auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc() || !std::isfinite(value) || (next != end && *next != ',')) {
            return std::nullopt;
        }
        values.push_back(value);
        if (next == end) {
            return values;
        }
        at = next + 1;
    }
}

Vec3 parse_point(const std::string& option, const std::string& text) {
    const auto values = parse_numbers(text);
    if (!values || values->size() != 3) {
        throw UsageError(option + " " + text + ": takes three numbers X,Y,Z with nothing but commas between");
    }
    return {(*values)[0], (*values)[1], (*values)[2]};
}

Rgb parse_rgb(const std::string& option, const std::string& text) {
    const std::vector<double> values = parse_numbers(text).value_or(std::vector<double>());
    const bool negative = std::any_of(values.begin(), values.end(), [](double v) { return v < 0.0; });
    if ((values.size() != 1 && values.size() != 3) || negative) {
        throw UsageError(option + " " + text + ": takes one number, or three R,G,B with nothing but commas between; " +
                         "none may be negative");
    }
    return values.size() == 1 ? Rgb::Constant(values[0]) : Rgb(values[0], values[1], values[2]);
}

double parse_bytes(const std::string& option, const std::string& text) {
    static const std::map<std::string, double> units{{"", 1.0},       {"kB", 1e3},     {"MB", 1e6},
                                                     {"GB", 1e9},     {"TB", 1e12},    {"KiB", 0x1p10},
                                                     {"MiB", 0x1p20}, {"GiB", 0x1p30}, {"TiB", 0x1p40}};
    double value = 0.0;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, value);
    const auto unit = units.find(text.substr(static_cast<std::size_t>(end - text.data())));
    if (error != std::errc() || unit == units.end() || !(value > 0.0) || !std::isfinite(value)) {
        throw UsageError(option + " " + text + ": takes a positive size such as 500MB or 4GiB");
    }
    return value * unit->second;
}

double parse_percent(const std::string& option, const std::string& text) {
    const std::size_t sign = text.find('%');
    const std::vector<double> values =
        parse_numbers(text.substr(0, text.find_last_not_of(" %") + 1)).value_or(std::vector<double>());
    if (sign == std::string::npos || sign + 1 != text.size() || values.size() != 1 || !(values[0] > 0.0)) {
        throw UsageError(option + " " + text + ": takes a positive percentage with its sign, such as 1%");
    }
    return values[0] / 100.0;
}

void add_run_arguments(CLI::App& app, RunArguments& run, std::uint64_t& seed, const std::string& independent) {
    add_whole<std::uint64_t>(app, "--seed", seed, 0, "seed of all random choices")
        ->group(run_group)
        ->type_name("N")
        ->default_str(shown(seed));
    add_run_arguments(app, run, independent);
}

void add_run_arguments(CLI::App& app, RunArguments& run, const std::string& independent) {
    add_parsed(app, "--threads", run.threads, "threads; " + independent + " on it",
               [](const std::string& option, const std::string& text) {
                   const auto threads = parse_whole<unsigned>(option, text, 1);
                   if (threads > 1024) {
                       throw UsageError(option + " " + text + ": must be at most 1024");
                   }
                   return threads;
               })
        ->group(run_group)
        ->type_name("N")
        ->default_str(shown(run.threads));
    add_parsed(app, "--max-memory", run.most_memory,
               "memory for the whole process, estimated before every large step: what would take more is refused",
               parse_bytes)
        ->group(run_group)
        ->type_name("SIZE");
    add_repeated(app, "--plugin-path", run.plugin_path, "additional directory with plugins (may be repeated)")
        ->group(run_group)
        ->type_name("DIR");
    app.add_flag("--quiet", run.quiet, "print errors only")->group(run_group);
    app.add_flag("--version", run.version, "print the version, and those of the libraries")->group(run_group);
}

namespace {

/// What the parser says of an option with too many or too few values, "--sites: At Most 1 required but received 2", in
/// other words.
std::string mismatch_of(const std::string& said) {
    const std::string option = said.substr(0, said.find(": "));
    if (said.find("At Most 1 required") != std::string::npos) {
        return option + ": is given more than once, and takes one value; give it once";
    }
    return said.find("missing") != std::string::npos ? option + ": needs a value" : said;
}

} // namespace

int run_command(CLI::App& app, int count, char** words, const std::string& expected, const bool& version,
                const std::function<void()>& action) {
    app.allow_extras();
    return run_program(app.get_name().c_str(), [&] {
        try {
            app.parse(count, words);
        } catch (const CLI::CallForHelp&) {
            std::cout << app.help();
            return;
        } catch (const CLI::ArgumentMismatch& error) {
            throw UsageError(mismatch_of(error.what()) + " (--help)");
        } catch (const CLI::ParseError& error) {
            throw UsageError(std::string(error.what()) + " (--help)");
        }
        refuse_unknown(app, expected);
        if (version) {
            std::cout << app.get_name() << " " << difusa::version() << "\n";
            for (const auto& [name, number] : library_versions()) {
                std::cout << name << " " << number << "\n";
            }
            return;
        }
        action();
    });
}

void check_outputs(const std::vector<OutputName>& outputs,
                   const std::vector<std::pair<std::filesystem::path, std::string>>& inputs) {
    DistinctFiles distinct;
    for (const auto& [file, is_field] : outputs) {
        if (file.empty()) {
            continue;
        }
        for (const auto& [input, what] : inputs) {
            if (same_file(file, input)) {
                throw UsageError(file.string() + ": would overwrite " + what + "; give the output another name");
            }
        }
        if (!distinct.add(file)) {
            throw UsageError(file.string() + ": two outputs have this name; give each its own name");
        }
        check_output_path(file, is_field);
    }
}

} // namespace difusa
