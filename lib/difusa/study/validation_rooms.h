// What the scenes of validation cases are made of.
#pragma once

#include <difusa/study/references/form_factors.h>
#include <difusa/study/validation.h>

#include <initializer_list>
#include <string>
#include <vector>

namespace difusa {

/// Adds a rectangle whose front is u × v, of a material that the case gets with it.
void add_rectangle(Scene& scene, const std::string& name, const Vec3& a, const Vec3& u, const Vec3& v, double rho = 0.0,
                   double emission = 0.0);

/// The same with a rectangular hole, in shares of u and v; a hole that reaches an edge leaves nothing there.
void add_rectangle_around(Scene& scene, const std::string& name, const Vec3& a, const Vec3& u, const Vec3& v,
                          const Rectangle& hole);

/// One side of a room: a rectangle whose front, u × v, faces inwards.
struct RoomSide {
    const char* name;
    Vec3 a, u, v;
};

enum class RoomFace { floor, ceiling, y_low, y_high, x_low, x_high };

/// Of a room from the origin to `size`.
RoomSide room_side(const Vec3& size, RoomFace side);

/// Adds these sides, each of a material of its own.
void add_sides(Scene& scene, const Vec3& size, std::initializer_list<RoomFace> sides, double rho = 0.0);

/// Adds the nodes of these sides to the last reading, as add_nodes does.
void add_side_nodes(ValidationCase& one, const Vec3& size, std::initializer_list<RoomFace> sides, std::size_t count,
                    double factor);

/// "A", "B", ... from `first` on, each with `suffix`.
std::vector<std::string> letters(char first, std::size_t count, const std::string& suffix = "");

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
