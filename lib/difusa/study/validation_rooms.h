// What the scenes of validation cases are made of.
#pragma once

#include <difusa/study/references/form_factors.h>
#include <difusa/study/validation.h>

#include <string>
#include <vector>

namespace difusa {

/// Adds a rectangle whose front is u × v, of a material that the case gets with it.
void add_rectangle(Scene& scene, const std::string& name, const Vec3& a, const Vec3& u, const Vec3& v, double rho = 0.0,
                   double emission = 0.0);

/// The same with a rectangular hole, in shares of u and v; a hole that reaches an edge leaves nothing there.
void add_rectangle_around(Scene& scene, const std::string& name, const Vec3& a, const Vec3& u, const Vec3& v,
                          const Rectangle& hole);

/// Points along a line, named by `names`: `first`, `first` + `step`, ..., with the normal n; `published` as many or
/// none.
void add_points(ValidationCase& one, const std::vector<std::string>& names, const Vec3& first, const Vec3& step,
                const Vec3& n, const std::vector<double>& published);

/// Adds the nodes of a Gauss-Legendre rule of `count` by `count` on a rectangle to the last reading, weighted by
/// `factor` times their areas.
void add_nodes(ValidationCase& one, const Vec3& a, const Vec3& u, const Vec3& v, std::size_t count, double factor);

/// Fills in the readings' exact figures from ValidationCase::exact, for readings at one place.
void fill_exact(ValidationCase& one);

} // namespace difusa
