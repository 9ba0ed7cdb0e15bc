// The scalar and vector types shared by all parts of the library.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <limits>

namespace difusa {

/// Position, direction or normal in the unit of length of the scene file.
using Vec3 = Eigen::Vector3d;

/// Three linear channels R, G, B: a reflectance in [0,1], or a flux density in W/m².
using Rgb = Eigen::Array3d;

/// One row per site, vertex or point, one column per channel (1 for a grey scene, otherwise 3).
using Values = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The same in single precision: half as much memory to read, where that is what takes time.
using SingleValues = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Numbers of points, faces, sites and materials; 32 bits keep a million sites compact.
using Index = std::uint32_t;

/// The number that means "none of them".
inline constexpr Index none = std::numeric_limits<Index>::max();

} // namespace difusa
