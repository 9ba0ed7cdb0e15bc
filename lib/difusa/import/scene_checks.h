// Checks on the values of scene files, using the unit of length and up direction given by the scene.
#pragma once

#include <difusa/import/json_tree.h>

#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

/// All throw InputError "file:line: ..." with the remedy.
class SceneChecks : public JsonChecks {
  public:
    explicit SceneChecks(const std::filesystem::path& name) : JsonChecks(name.string()), folder_(name.parent_path()) {}

    /// Reads the members "unit" and "up" of the scene.
    void read_conventions(const JsonValue& root);

    double unit() const { return unit_; } ///< of length, in metres
    const Vec3& up() const { return up_; }
    const std::filesystem::path& folder() const { return folder_; } ///< of the scene file

    /// One number, or R G B; none negative.
    Rgb colour(const JsonValue& value, const std::string& what) const;

    /// Light given by one of two members: `radiometric`, in W, or `photometric`, in lm, cd, lux or cd/m², which is
    /// converted (core/photometry.h) and sets `is_photometric`. Rejects both, and none.
    Rgb light(const JsonValue& object, const std::string& what, const char* radiometric, const char* photometric,
              bool& is_photometric) const;

    /// `name`: of the member, for messages.
    Rgb reflectance_of(const JsonValue& value, std::string_view name = "reflectance") const;

    double positive(const JsonValue& value, const std::string& what) const;

    /// The unit of length named by the object, in metres.
    double unit_of(const JsonValue& object, double otherwise) const;

    /// In metres.
    Vec3 position(const JsonValue& value, const std::string& what) const;

    /// Of unit length.
    Vec3 direction(const JsonValue& value, const std::string& what) const;

    /// Of unit length; also "x", "y", "z".
    Vec3 up_direction(const JsonValue& value) const;

    /// A unit vector from the member `name`, or towards the point "look_at" from `from`.
    Vec3 direction_or_target(const JsonValue& object, const std::string& what, const char* name,
                             const Vec3& from) const;

    /// The member "name", or nothing.
    std::string name_of(const JsonValue& object) const;

    /// The path of a readable file next to this one.
    std::filesystem::path file_beside(const JsonValue& value, const std::string& what) const;

    /// Rejects a name that is not among the `known`.
    [[noreturn]] void refuse_name(const JsonValue& at, const std::string& name, const std::string& missing,
                                  const std::vector<std::string>& known) const;

    /// Rejects an object that has not exactly one of two members, but `both` or none.
    [[noreturn]] void refuse_choice(const JsonValue& at, const std::string& what, const std::string& one,
                                    const std::string& other, bool both) const;

  private:
    std::filesystem::path folder_;
    double unit_ = 1.0;
    Vec3 up_ = Vec3::UnitZ();
};

} // namespace difusa
