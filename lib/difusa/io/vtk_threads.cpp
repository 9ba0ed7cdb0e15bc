// Compiled as C++17: vtkSMPTools.h of VTK 9.1 is not valid C++20.
#include <difusa/io/vtk_threads.h>

#include <vtkSMPTools.h>

namespace difusa {

void without_vtk_threads(const std::function<void()>& work) {
    vtkSMPTools::LocalScope({1, "Sequential", false}, work);
}

} // namespace difusa
