// VTK on the calling thread alone.
#pragma once

#include <functional>

namespace difusa {

/// Does `work` with VTK's own threads switched off, as its thread pool fails if the system provides no thread. VTK has
/// one setting for the whole process: other threads that use VTK meanwhile are slower, but work.
void without_vtk_threads(const std::function<void()>& work);

} // namespace difusa
