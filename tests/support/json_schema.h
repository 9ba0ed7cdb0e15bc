// Whether a JSON document is as a schema says (json-schema.org, draft 2020-12), with the keywords that our schema uses.
#pragma once

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace difusa::test {

class JsonSchema {
  public:
    explicit JsonSchema(nlohmann::json schema) : schema_(std::move(schema)) {}

    /// What is wrong, with its place; empty if nothing is.
    std::vector<std::string> faults(const nlohmann::json& document) {
        std::vector<std::string> faults;
        check(schema_, document, "", faults);
        return faults;
    }

    /// The places of members that the schema declares and no document had until now.
    std::vector<std::string> never_met() const {
        std::vector<std::string> places;
        collect(schema_, "", places);
        std::erase_if(places, [&](const std::string& place) { return met_.count(place) > 0; });
        return places;
    }

  private:
    using Json = nlohmann::json;
    using Faults = std::vector<std::string>;

    static bool is_of_type(const Json& value, const std::string& type) {
        return type == "null"      ? value.is_null()
               : type == "boolean" ? value.is_boolean()
               : type == "string"  ? value.is_string()
               : type == "array"   ? value.is_array()
               : type == "object"  ? value.is_object()
               : type == "integer" ? value.is_number_integer()
               : type == "number"  ? value.is_number()
                                   : throw std::invalid_argument("unknown type " + type);
    }

    bool holds(const Json& schema, const Json& value) {
        Faults faults;
        check(schema, value, "condition", faults);
        return faults.empty();
    }

    void check_members(const Json& schema, const Json& value, const std::string& place, Faults& faults) {
        const Json properties = schema.value("properties", Json::object());
        for (const auto& [name, member] : value.items()) {
            const std::string where = place + "/" + name;
            if (properties.contains(name)) {
                met_.insert(where);
                check(properties[name], member, where, faults);
            } else if (const Json others = schema.value("additionalProperties", Json(true)); others.is_object()) {
                check(others, member, where, faults);
            } else if (!others.get<bool>()) {
                faults.push_back(where + ": unknown");
            }
        }
        for (const Json& name : schema.value("required", Json::array())) {
            if (!value.contains(name.get<std::string>())) {
                faults.push_back(place + "/" + name.get<std::string>() + ": missing");
            }
        }
    }

    void check_items(const Json& schema, const Json& value, const std::string& place, Faults& faults) {
        if (value.size() < schema.value("minItems", std::size_t{0}) ||
            value.size() > schema.value("maxItems", value.size())) {
            faults.push_back(place + ": has " + std::to_string(value.size()) + " items");
        }
        for (const Json& item : value) {
            if (schema.contains("items")) {
                check(schema["items"], item, place + "/*", faults);
            }
        }
    }

    void check(const Json& schema, const Json& value, const std::string& place, Faults& faults) {
        static const std::set<std::string> known{
            "$schema", "title",    "description", "type",    "properties", "required", "additionalProperties",
            "items",   "minItems", "maxItems",    "minimum", "enum",       "const",    "oneOf",
            "if",      "then",     "else"};
        for (const auto& [keyword, ignored] : schema.items()) {
            if (known.count(keyword) == 0) {
                throw std::invalid_argument("unknown keyword " + keyword);
            }
        }
        if (schema.contains("type")) {
            const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
            if (std::none_of(types.begin(), types.end(),
                             [&](const Json& type) { return is_of_type(value, type.get<std::string>()); })) {
                faults.push_back(place + ": is " + value.type_name() + ", not " + schema["type"].dump());
                return;
            }
        }
        if ((schema.contains("const") && value != schema["const"]) ||
            (schema.contains("enum") &&
             std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end()) ||
            (schema.contains("minimum") && value.is_number() && value < schema["minimum"])) {
            faults.push_back(place + ": " + value.dump() + " is no value of it");
        }
        if (schema.contains("oneOf")) {
            const auto fitting = std::count_if(schema["oneOf"].begin(), schema["oneOf"].end(),
                                               [&](const Json& one) { return holds(one, value); });
            if (fitting != 1) {
                faults.push_back(place + ": fits " + std::to_string(fitting) + " of its forms");
            }
            for (const Json& one : schema["oneOf"]) {
                if (one.contains("type") && is_of_type(value, one["type"].get<std::string>())) {
                    check(one, value, place, faults); // says what is wrong with the form that is meant
                }
            }
        }
        if (schema.contains("if")) {
            const char* const branch = holds(schema["if"], value) ? "then" : "else";
            if (schema.contains(branch)) {
                check(schema[branch], value, place, faults);
            }
        }
        if (value.is_object()) {
            check_members(schema, value, place, faults);
        } else if (value.is_array()) {
            check_items(schema, value, place, faults);
        }
    }

    static void collect(const Json& schema, const std::string& place, std::vector<std::string>& places) {
        const Json properties = schema.value("properties", Json::object());
        for (const auto& [name, member] : properties.items()) {
            const std::string where = place + "/" + name;
            places.push_back(where);
            collect(member, where, places);
        }
        if (schema.contains("items")) {
            collect(schema["items"], place + "/*", places);
        }
        for (const Json& one : schema.value("oneOf", Json::array())) {
            collect(one, place, places);
        }
    }

    Json schema_;
    std::set<std::string> met_;
};

} // namespace difusa::test
