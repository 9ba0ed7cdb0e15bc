#include <difusa/version.h>

// DIFUSA_VERSION and DIFUSA_*_VERSION are defined by the build.

namespace difusa {

std::string version() {
    return DIFUSA_VERSION;
}

std::vector<std::pair<std::string, std::string>> library_versions() {
    std::vector<std::pair<std::string, std::string>> versions{{"CGAL", DIFUSA_CGAL_VERSION},
                                                              {"CLI11", DIFUSA_CLI11_VERSION},
                                                              {"Eigen", DIFUSA_EIGEN_VERSION},
                                                              {"Embree", DIFUSA_EMBREE_VERSION},
                                                              {"HDF5", DIFUSA_HDF5_VERSION},
                                                              {"nanoflann", DIFUSA_NANOFLANN_VERSION},
                                                              {"nlohmann-json", DIFUSA_JSON_VERSION},
                                                              {"OpenMesh", DIFUSA_OPENMESH_VERSION},

                                                              {"VTK", DIFUSA_VTK_VERSION}};
    std::erase_if(versions, [](const auto& each) { return each.second.empty(); });
    return versions;
}

} // namespace difusa
