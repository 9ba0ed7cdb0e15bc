// The scalar and vector types every part of the library shares.
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

/// One row for each site, vertex or point, one column for each channel (1 for a grey scene, else 3).
using Values = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Numbers of points, faces, sites and materials; 32 bits keep a million sites small.
using Index = std::uint32_t;

/// The number that stands for "none of them".
inline constexpr Index none = std::numeric_limits<Index>::max();

} // namespace difusa
