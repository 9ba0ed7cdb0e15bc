// JSON text as a tree whose values record their lines.
#pragma once

#include <difusa/core/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

struct JsonValue {
    enum class Kind : std::uint8_t { null, boolean, number, text, list, object };
    Kind kind = Kind::null;
    bool truth = false;     ///< of a boolean
    std::uint32_t line = 1; ///< where it starts
    double number = 0.0;
    std::string text;
    std::vector<std::string> names; ///< of an object's members
    std::vector<JsonValue> items;   ///< of a list; the values of an object's members

    /// The member of that name, or null.
    const JsonValue* find(std::string_view name) const;
};

/// Parses the whole text. Numbers are doubles: whole ones are exact up to 2^53.
/// Throws InputError "file:line: ..." for anything that is not JSON, duplicate names in an object, values nested more
/// than 64 deep, and more lines than 32 bits can number.
JsonValue parse_json(std::string_view content, const std::string& file);

/// The name of a member, as written in messages.
inline std::string quoted(std::string_view name) {
    return "\"" + std::string(name) + "\"";
}

/// Expectations on values. `what` is what messages call a value: "\"reflectance\"". All throw InputError "file:line:
/// `what` must be ...".
class JsonChecks {
  public:
    explicit JsonChecks(std::string file) : file_(std::move(file)) {}

    const std::string& file() const { return file_; }

    /// Throws InputError "file:line: problem".
    [[noreturn]] void fail(const JsonValue& at, const std::string& problem) const;

    double number(const JsonValue& value, const std::string& what) const;     ///< finite
    std::size_t whole(const JsonValue& value, const std::string& what) const; ///< from 0 to 2^53
    bool truth(const JsonValue& value, const std::string& what) const;
    const std::string& text(const JsonValue& value, const std::string& what) const;
    const std::vector<JsonValue>& list(const JsonValue& value, const std::string& what) const;
    void object(const JsonValue& value, const std::string& what) const;

    /// `count` finite numbers.
    std::vector<double> numbers(const JsonValue& value, const std::string& what, std::size_t count) const;
    Vec3 vector(const JsonValue& value, const std::string& what) const;

    /// An object with no members but these and "comment"; an unknown one is rejected with the nearest of them.
    void members(const JsonValue& value, const std::string& what, const std::vector<std::string>& known) const;

    /// The member of an object. Throws if there is none.
    const JsonValue& required(const JsonValue& value, const std::string& what, std::string_view name) const;

  private:
    [[noreturn]] void unexpected(const JsonValue& value, const std::string& what, const std::string& wanted) const;
    std::string file_;
};

} // namespace difusa
