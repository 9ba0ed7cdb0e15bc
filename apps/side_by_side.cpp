#include "side_by_side.h"

#include <difusa/io/whole_file.h>
#include <difusa/study/classical_study.h>

#include <iostream>

namespace difusa {

void write_side_by_side(const SideBySide& plan, const std::filesystem::path& folder, bool quiet,
                        const Registry& registry, const Execution& execution) {
    std::string table = method_header(), csv = method_csv_header();
    if (!quiet) {
        std::cout << table << std::flush;
    }
    const auto compare = [&](const KnownLight& light) {
        const std::vector<MethodTrial> trials =
            compare_methods(registry, light, plan.common, plan.sites, execution, [&](const MethodTrial& trial) {
                const std::string row = method_row(trial);
                if (!quiet) {
                    std::cout << row << std::flush;
                }
                table += row;
                csv += method_csv_row(trial);
            });
        const std::string name = std::filesystem::path(light.name).stem().string();
        write_whole_file(folder / (name + "_side_by_side.svg"), method_chart(trials));
    };
    for (const std::string& name : plan.cases) {
        compare(known_light(Judge(reference_case(name), plan.how, execution)));
    }
    for (const std::string& file : plan.scenes) {
        BakeOptions fine = plan.common;
        fine.sites = plan.sites.back();
        compare(known_light(bake(registry, file, finer(fine), execution), file, plan.how.places, execution));
    }
    write_whole_file(folder / "side_by_side.md", table);
    write_whole_file(folder / "side_by_side.csv", csv);
}

} // namespace difusa
