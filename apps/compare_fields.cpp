// compare_fields result reference [error]: norms and a map of the error of one baked field against another.
#include "arguments.h"
#include "terminal.h"

#include <difusa/import/text_scanner.h>
#include <difusa/io/field_reader.h>
#include <difusa/io/field_writers.h>
#include <difusa/study/compare.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace compare_fields {

using difusa::add_parsed;
using difusa::add_whole;
using difusa::UsageError;

const char* const examples =
    R"(Compares a baked field with a reference: norms of the error, and the error as a field.

Examples:
  compare_fields out.vtp fine.vtp error.vtp
      total and indirect light; open error.vtp in ParaView and colour by radiosity_error_relative
  compare_fields out.vtp fine.vtp
      the table only
  compare_fields out.vtp fine.vtp error.vtp --report error.json --array irradiance_direct --array reflectance
      additional arrays, and all norms as JSON
  compare_fields out.ply fine.ply
      the weighted radiosity only: PLY holds nothing else

The meshes may differ: the reference is then interpolated at its nearest point facing the same way, and should be
the finer one. Norms are relative to the same norm of the reference, integrated over the surface of the result.
Emitters, known from the array emission of either file, are left out of the norms of radiosity and luminance, because
their own light would hide the errors around them; --with-emitters includes them.

Exit codes: 0 done, 1 usage, 2 input, 3 not converged, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path result, reference, error, report;
    difusa::CompareOptions compare;
    unsigned threads = difusa::processors();
    bool quiet = false, version = false;
};

double parse_share(const std::string& option, const std::string& text) {
    const double share = difusa::parse_percent(option, text);
    if (!(share <= 1.0)) {
        throw UsageError(option + " " + text + ": must be at most 100%");
    }
    return share;
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("result", a.result, "field to be assessed: .vtp or .ply")->type_name("RESULT");
    app.add_option("reference", a.reference, "what it should be: .vtp or .ply")->type_name("REFERENCE");
    app.add_option("error", a.error, "error field on the result's mesh, .vtp (not written if omitted)")
        ->type_name("ERROR");
    app.add_option("--array", a.compare.arrays, "compare this point array too (may be repeated)")
        ->type_name("NAME")
        ->allow_extra_args(false);
    add_parsed(app, "--max-distance", a.compare.max_distance,
               "ignore points of the result farther than this from the reference (default: 1 % of its diameter)",
               difusa::parse_positive)
        ->type_name("D");
    add_parsed(app, "--min-match", a.compare.least_matched,
               "refuse fields of which less of the result's area than this matches the reference (default: 50 %)",
               parse_share)
        ->type_name("P%");
    app.add_flag("--with-emitters", a.compare.with_emitters,
                 "include emitting surfaces in the norms of radiosity and luminance");
    app.add_option("--report", a.report, "write all norms as JSON")->type_name("FILE.json");
    add_whole(app, "--threads", a.threads, 1U, "threads; the result does not depend on it")
        ->type_name("N")
        ->default_str(difusa::shown(a.threads));
    app.add_flag("--quiet", a.quiet, "print errors only");
    app.add_flag("--version", a.version, "print the version, and those of the libraries");
}

void check(const Arguments& a) {
    if (a.result.empty() || a.reference.empty()) {
        throw UsageError("two fields are expected: compare_fields result.vtp reference.vtp error.vtp (--help)");
    }
    if (!a.error.empty() && difusa::lower_case(a.error.extension().string()) != ".vtp") {
        throw UsageError("cannot write errors to `" + a.error.string() + "`: the name must end in .vtp (ParaView)");
    }
    if (a.threads > 1024) {
        throw UsageError("--threads " + std::to_string(a.threads) + ": must be at most 1024");
    }
    difusa::check_outputs({{a.error, true}, {a.report, false}},
                          {{a.result, "the result"}, {a.reference, "the reference"}});
}

void write(const difusa::Comparison& comparison, const difusa::FieldFile& result, const Arguments& a) {
    std::vector<std::unique_ptr<difusa::WholeFile>> written; // all or none
    if (!a.error.empty()) {
        written.push_back(std::make_unique<difusa::WholeFile>(a.error));
        difusa::write_field(difusa::error_field(comparison, result, a.result.string(), a.reference.string()), a.error,
                            *written.back(), {});
    }
    if (!a.report.empty()) {
        written.push_back(std::make_unique<difusa::WholeFile>(a.report));
        written.back()->write(difusa::report_of(comparison, a.result.string(), a.reference.string()));
    }
    for (const auto& file : written) {
        file->commit();
    }
}

void run(const Arguments& a) {
    check(a);
    difusa::TerminalProgress progress(a.quiet);
    const difusa::Execution execution{a.threads, &progress};
    difusa::FieldFile result;
    difusa::Comparison comparison;
    try {
        execution.phase("read");
        result = difusa::read_field(a.result);
        const difusa::FieldFile reference = difusa::read_field(a.reference);
        execution.phase("compare");
        comparison = difusa::compare(result, a.result.string(), reference, a.reference.string(), a.compare, execution);
        execution.phase("write");
        write(comparison, result, a);
    } catch (const std::bad_alloc&) {
        throw difusa::ResourceError("out of memory: compare coarser meshes, or use a machine with more memory");
    }
    progress.clear();
    if (a.quiet) {
        return;
    }
    std::cout << a.result.string() << " against " << a.reference.string() << ": " << difusa::table_of(comparison);
    for (const std::string& note : comparison.notes) {
        std::cout << "note: " << note << "\n";
    }
    for (const std::filesystem::path& file : {a.error, a.report}) {
        if (!file.empty()) {
            std::cout << "written: " << file.string() << "\n";
        }
    }
}

int program(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "compare_fields");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "two fields and one output file", arguments.version,
                               [&] { run(arguments); });
}

} // namespace compare_fields
