#include <difusa/import/json_tree.h>

#include <difusa/core/error.h>
#include <difusa/import/file_content.h>
#include <difusa/plugin/parameters.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>

namespace difusa {

namespace {

using PlainJson = nlohmann::json;

/// Iterates over a text and tracks the line of the last character passed. The parser looks one character ahead at the
/// end of a number: a line end counts with the character after it.
class LineCounter {
  public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    LineCounter(const char* at, std::uint32_t* line) : at_(at), line_(line) {}
    const char& operator*() const { return *at_; }
    LineCounter& operator++() {
        *line_ += passed_line_end_ ? 1 : 0;
        passed_line_end_ = *at_ == '\n';
        ++at_;
        return *this;
    }
    LineCounter operator++(int) {
        LineCounter before = *this;
        ++*this;
        return before;
    }
    bool operator==(const LineCounter& other) const { return at_ == other.at_; }

  private:
    const char* at_;
    std::uint32_t* line_;
    bool passed_line_end_ = false;
};

/// Receives the parser's events.
class Builder : public nlohmann::json_sax<PlainJson> {
  public:
    Builder(const std::string& file, const std::uint32_t& line) : file_(file), line_(line) {}

    JsonValue take() { return std::move(root_); }

    bool null() override {
        add({});
        return true;
    }
    bool boolean(bool value) override {
        add({}).truth = value;
        latest_->kind = JsonValue::Kind::boolean;
        return true;
    }
    bool number_integer(number_integer_t value) override { return number(static_cast<double>(value)); }
    bool number_unsigned(number_unsigned_t value) override { return number(static_cast<double>(value)); }
    bool number_float(number_float_t value, const string_t& /*text*/) override { return number(value); }
    bool string(string_t& value) override {
        add({}).text = std::move(value);
        latest_->kind = JsonValue::Kind::text;
        return true;
    }
    bool binary(binary_t& /*value*/) override { return false; } // JSON text has none
    bool start_object(std::size_t /*size*/) override { return open(JsonValue::Kind::object); }
    bool start_array(std::size_t /*size*/) override { return open(JsonValue::Kind::list); }
    bool key(string_t& name) override {
        open_.back()->names.push_back(std::move(name));
        return true;
    }
    bool end_object() override {
        refuse_twice(*open_.back());
        open_.pop_back();
        return true;
    }
    bool end_array() override {
        open_.pop_back();
        return true;
    }
    bool parse_error(std::size_t /*position*/, const std::string& last, const PlainJson::exception& error) override {
        // "[json.exception...] parse error at line 3, column 5: what is wrong; last read: ..."
        if (error.id == 406) { // number overflow
            fail(excerpt(last) + " is too large: the maximum is 1.7e308; correct it");
        }
        std::string text = error.what();
        const std::size_t begin = text.find(": ");
        text = begin == std::string::npos ? text : text.substr(begin + 2);
        const std::size_t end = text.find("; last read");
        const std::size_t expected = text.find("; expected");
        text =
            text.substr(0, end) +
            (end != std::string::npos && expected != std::string::npos && expected > end ? text.substr(expected) : "");
        fail(text + ", at " + excerpt(last.size() > 30 ? last.substr(last.size() - 30) : last) +
             ": this is not JSON; correct it");
    }

  private:
    static constexpr std::size_t deepest = 64;

    [[noreturn]] void fail(const std::string& problem) const {
        throw InputError(file_ + ":" + std::to_string(line_) + ": " + problem);
    }
    bool number(double value) {
        add({}).number = value;
        latest_->kind = JsonValue::Kind::number;
        return true;
    }
    bool open(JsonValue::Kind kind) {
        if (open_.size() >= deepest) {
            fail("values are nested more than " + std::to_string(deepest) + " deep: no valid file is");
        }
        JsonValue& value = add({});
        value.kind = kind;
        // Only the innermost list grows, so the enclosing ones do not move.
        open_.push_back(&value);
        return true;
    }
    JsonValue& add(JsonValue value) {
        value.line = line_;
        if (open_.empty()) {
            root_ = std::move(value);
            latest_ = &root_;
        } else {
            open_.back()->items.push_back(std::move(value));
            latest_ = &open_.back()->items.back();
        }
        return *latest_;
    }
    void refuse_twice(const JsonValue& object) const {
        std::vector<std::size_t> order(object.names.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return std::tie(object.names[a], a) < std::tie(object.names[b], b);
        });
        const auto twice = std::adjacent_find(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return object.names[a] == object.names[b];
        });
        if (twice != order.end()) {
            throw InputError(file_ + ":" + std::to_string(object.items[*(twice + 1)].line) + ": " +
                             excerpt(object.names[*twice]) + " occurs twice in one object (first in line " +
                             std::to_string(object.items[*twice].line) + "): remove one");
        }
    }

    std::string file_;
    const std::uint32_t& line_;
    JsonValue root_;
    JsonValue* latest_ = nullptr;
    std::vector<JsonValue*> open_; ///< lists and objects that contain the next value
};

std::string in_words(const JsonValue& value) {
    switch (value.kind) {
    case JsonValue::Kind::null:
        return "null";
    case JsonValue::Kind::boolean:
        return value.truth ? "true" : "false";
    case JsonValue::Kind::number:
        return PlainJson(value.number).dump();
    case JsonValue::Kind::text:
        return excerpt(value.text);
    case JsonValue::Kind::list:
        return "a list of " + std::to_string(value.items.size());
    case JsonValue::Kind::object:
        return "an object";
    }
    return "";
}

} // namespace

const JsonValue* JsonValue::find(std::string_view name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? nullptr : &items[static_cast<std::size_t>(found - names.begin())];
}

JsonValue parse_json(std::string_view content, const std::string& file) {
    if (std::count(content.begin(), content.end(), '\n') >= none) {
        throw InputError(file + ": has more than 2^32 lines: split it");
    }
    std::uint32_t line = 1;
    Builder builder(file, line);
    const char* const begin = content.data();
    PlainJson::sax_parse(LineCounter(begin, &line), LineCounter(begin + content.size(), &line), &builder);
    return builder.take();
}

void JsonChecks::fail(const JsonValue& at, const std::string& problem) const {
    throw InputError(file_ + ":" + std::to_string(at.line) + ": " + problem);
}

void JsonChecks::unexpected(const JsonValue& value, const std::string& what, const std::string& wanted) const {
    fail(value, what + " must be " + wanted + ", not " + in_words(value));
}

double JsonChecks::number(const JsonValue& value, const std::string& what) const {
    if (value.kind != JsonValue::Kind::number || !std::isfinite(value.number)) {
        unexpected(value, what, "a number");
    }
    return value.number;
}

std::size_t JsonChecks::whole(const JsonValue& value, const std::string& what) const {
    if (value.kind != JsonValue::Kind::number || !(value.number >= 0.0 && value.number <= 0x1p53) ||
        value.number != std::floor(value.number)) {
        unexpected(value, what, "a non-negative whole number");
    }
    return static_cast<std::size_t>(value.number);
}

bool JsonChecks::truth(const JsonValue& value, const std::string& what) const {
    if (value.kind != JsonValue::Kind::boolean) {
        unexpected(value, what, "true or false");
    }
    return value.truth;
}

const std::string& JsonChecks::text(const JsonValue& value, const std::string& what) const {
    if (value.kind != JsonValue::Kind::text) {
        unexpected(value, what, "a text");
    }
    return value.text;
}

const std::vector<JsonValue>& JsonChecks::list(const JsonValue& value, const std::string& what) const {
    if (value.kind != JsonValue::Kind::list) {
        unexpected(value, what, "a list");
    }
    return value.items;
}

void JsonChecks::object(const JsonValue& value, const std::string& what) const {
    if (value.kind != JsonValue::Kind::object) {
        unexpected(value, what, "an object ({ ... })");
    }
}

std::vector<double> JsonChecks::numbers(const JsonValue& value, const std::string& what, std::size_t count) const {
    if (value.kind != JsonValue::Kind::list || value.items.size() != count) {
        unexpected(value, what, "a list of " + std::to_string(count) + " numbers");
    }
    std::vector<double> result;
    for (const JsonValue& item : value.items) {
        result.push_back(number(item, "each number of " + what));
    }
    return result;
}

Vec3 JsonChecks::vector(const JsonValue& value, const std::string& what) const {
    const std::vector<double> v = numbers(value, what, 3);
    return {v[0], v[1], v[2]};
}

void JsonChecks::members(const JsonValue& value, const std::string& what, const std::vector<std::string>& known) const {
    object(value, what);
    for (std::size_t i = 0; i < value.names.size(); ++i) {
        const std::string& name = value.names[i];
        if (name == "comment" || std::find(known.begin(), known.end(), name) != known.end()) {
            continue;
        }
        std::string message = what + " has no " + excerpt(name);
        const std::string near = nearest_name(name, known);
        message += near.empty() ? ". It has:" : "; did you mean '" + near + "'? It has:";
        for (const std::string& each : known) {
            message += " " + each;
        }
        fail(value.items[i], message);
    }
}

const JsonValue& JsonChecks::required(const JsonValue& value, const std::string& what, std::string_view name) const {
    const JsonValue* found = value.find(name);
    if (found == nullptr) {
        fail(value, what + " needs \"" + std::string(name) + "\": add it");
    }
    return *found;
}

} // namespace difusa
