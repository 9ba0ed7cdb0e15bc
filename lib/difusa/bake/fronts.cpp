#include <difusa/bake/fronts.h>

#include <difusa/core/text.h>
#include <difusa/lighting/inside_out.h>
#include <difusa/repair/coplanar_faces.h>
#include <difusa/repair/covered_parts.h>

#include <string>
#include <utility>

namespace difusa {

namespace {

/// "5856 triangles from face 0 (line 12) on, near (1, 2, 3)".
std::string place_of(const BakeResult& result, const ConnectedPart& part) {
    const Mesh& mesh = result.scene->mesh;
    const Index first = part.triangles.front();
    return std::to_string(part.triangles.size()) + (part.triangles.size() == 1 ? " triangle" : " triangles") +
           " from " + face_name(result.diagnosis, mesh.original_face[first]) + " on, near " +
           coordinates(mesh.corner(first, 0));
}

/// What a user should know of parts that are left as they are; empty for the others.
struct Advice {
    const char *one, *many, *remedy;
};

Advice advice_on(FrontFault fault) {
    switch (fault) {
    case FrontFault::leaky:
        return {"part has its fronts inside, with holes through which hardly any light gets in",
                "parts have their fronts inside, with holes through which hardly any light gets in",
                "this is right for a room with windows; an object to be seen from outside has to be turned over with "
                "--flip all (in a scene file: \"flip\": true for its mesh)"};
    case FrontFault::dark_room:
        return {"closed part has its fronts inside, where other parts are but no light",
                "closed parts have their fronts inside, where other parts are but no light",
                "a room needs a light in it; an object to be seen from outside has to be turned over with --flip all "
                "(in a scene file: \"flip\": true for its mesh)"};
    case FrontFault::shut_light:
        return {"closed part has its fronts outside, and shuts up a light inside",
                "closed parts have their fronts outside, and shut up lights inside",
                "turn a room over with --flip all (in a scene file: \"flip\": true for its mesh); open the lampshade "
                "of a lamp"};
    case FrontFault::inside_out:
        break;
    }
    return {"", "", ""};
}

void note_faults(const BakeResult& result, const FrontVerdict& verdict, FrontFault fault, const Execution& execution) {
    std::size_t count = 0;
    std::string places;
    for (const JudgedPart& judged : verdict.faults) {
        if (judged.fault == fault && count++ < 3) {
            places += (places.empty() ? "" : "; ") + place_of(result, verdict.parts[judged.part]);
        }
    }
    if (count > 0) {
        const Advice advice = advice_on(fault);
        execution.note(std::to_string(count) + " " + (count == 1 ? advice.one : advice.many) + " (" + places +
                       (count > 3 ? "; ...)" : ")") + "; " + advice.remedy);
    }
}

void add_finding(BakeResult& result, Finding finding, const Execution& execution) {
    result.diagnosis.findings.push_back(std::move(finding));
    if (execution.progress != nullptr) {
        execution.progress->remark(result.diagnosis.findings.back().message());
    }
}

} // namespace

bool settle_fronts(BakeResult& result, const Choices& choices, const Execution& execution) {
    if (choices.flip == Flip::nothing) {
        return false;
    }
    Mesh& mesh = result.scene->mesh;
    if (choices.flip == Flip::all) {
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            mesh.turn_over(t);
            result.turned_over.push_back(t);
        }
        mesh.derive();
        execution.note("all faces have been turned over (--flip all)");
        return true;
    }
    execution.phase("check fronts");
    const FrontVerdict verdict =
        judge_fronts(*result.scene, result.camera, *choices.engine, result.options.seed, execution);
    for (const FrontFault fault : {FrontFault::leaky, FrontFault::dark_room, FrontFault::shut_light}) {
        note_faults(result, verdict, fault, execution);
    }
    std::vector<std::string> places;
    for (const JudgedPart& judged : verdict.faults) {
        if (judged.fault == FrontFault::inside_out) {
            places.push_back(place_of(result, verdict.parts[judged.part]));
        }
    }
    if (places.empty()) {
        return false;
    }
    for (const JudgedPart& judged : verdict.faults) {
        if (judged.fault == FrontFault::inside_out) {
            for (const Index t : verdict.parts[judged.part].triangles) {
                mesh.turn_over(t);
                result.turned_over.push_back(t);
            }
        }
    }
    mesh.derive();
    const std::size_t count = places.size();
    add_finding(result, finding_of(Defect::inside_out_parts, count, std::move(places)), execution);
    return true;
}

void note_coplanar_faces(const BakeResult& result, const Execution& execution) {
    if (result.files.empty()) {
        return;
    }
    Mesh mesh = result.scene->mesh;
    const SetApart apart = set_apart(mesh, execution);
    if (!apart.moved.empty()) {
        execution.note("moved objects lie on others in the same plane (" +
                       place_of(apart.moved.front(), " on ", result.diagnosis) +
                       (apart.moved.size() > 1 ? "; ..." : "") +
                       "), where they may see what is behind these: keep them " + text_of(apart.gap) +
                       " away, or bake the moved scene");
    }
}

bool settle_coplanar_faces(BakeResult& result, const Execution& execution) {
    if (result.files.empty()) {
        return false;
    }
    Mesh& mesh = result.scene->mesh;
    const auto report = [&](Defect defect, const std::vector<CoplanarFace>& faces, bool given_up) {
        for (Finding& finding : findings_of(defect, faces, given_up, result.diagnosis)) {
            add_finding(result, std::move(finding), execution);
        }
        return !faces.empty();
    };
    if (result.scene->thermal) { // what is covered would radiate
        const CoveredParts covered = leave_out_covered(mesh, execution);
        return report(Defect::covered_parts, covered.cut, covered.given_up);
    }
    const SetApart apart = set_apart(mesh, execution);
    return report(Defect::coplanar_faces, apart.moved, apart.given_up);
}

} // namespace difusa
