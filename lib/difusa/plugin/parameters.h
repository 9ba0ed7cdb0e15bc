// Parameters of a plugin as typed by the user, `radial:width=0.5,profile=cubic`, checked against the plugin's
// declarations. An unknown one is rejected with the nearest known name.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// One parameter of a plugin.
struct ParameterSpec {
    enum class Type { real, integer, word, vector };
    std::string name;
    Type type = Type::real;
    std::string default_value; ///< as the user would type it; may be empty if `meaning` says what happens then
    std::string meaning;       ///< one sentence with the unit
    double minimum = -1e300, maximum = 1e300; ///< for real and integer: both ends allowed
    std::vector<std::string> words;           ///< for word: the values allowed
};

/// Values for all declared parameters; those the user omitted have their defaults.
class Parameters {
  public:
    Parameters() = default;

    /// Parses "name=value,name=value" (empty: all defaults). Vectors are written 1/2/3.
    /// Names may be written with '-' or '_'. `owner` ("basis radial") is for messages.
    /// Throws UsageError: unknown or repeated name, or a value that does not parse or is out of range.
    Parameters(std::string_view text, std::vector<ParameterSpec> specs, std::string owner);

    /// The value of a declared parameter. Throws InternalError for an undeclared name or another type, or for a
    /// number without a value (empty default, not given).
    double real(std::string_view name) const;
    long integer(std::string_view name) const;
    const std::string& word(std::string_view name) const;
    std::vector<double> vector(std::string_view name) const; ///< empty if the value is empty

    /// True if given by the user.
    bool given(std::string_view name) const;

    /// All non-empty values, "width=0.5,profile=gaussian", in the declared order: for reports, and usable as input.
    std::string text() const;

  private:
    const std::string& value(std::string_view name, ParameterSpec::Type type) const;
    std::vector<ParameterSpec> specs_;
    std::map<std::string, std::string, std::less<>> values_;
    std::vector<std::string> given_;
    std::string owner_;
};

/// The name in `known` with the smallest edit distance to `name`, or "" if none is close (distance at most a third of
/// its length, at least 1). '-' and '_' count as equal.
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

} // namespace difusa
