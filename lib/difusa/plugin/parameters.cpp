#include <difusa/core/error.h>
#include <difusa/plugin/parameters.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>

namespace difusa {

namespace {

using ParameterType = ParameterSpec::Type;

/// A bound not worth mentioning to the user.
constexpr double unbounded = 1e300;

std::string canonical(std::string_view name) {
    std::string result(name);
    std::replace(result.begin(), result.end(), '_', '-');
    return result;
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blank = " \t\r\n";
    const std::size_t first = text.find_first_not_of(blank);
    return first == std::string_view::npos ? std::string_view{}
                                           : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t begin = 0, end = 0; end != std::string_view::npos; begin = end + 1) {
        end = text.find(separator, begin);
        parts.push_back(trimmed(text.substr(begin, end == std::string_view::npos ? end : end - begin)));
    }
    return parts;
}

/// Parses the whole text as a number; finite, independent of the locale.
template <class T> std::optional<T> parse_number(std::string_view text) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
        text.remove_prefix(1);
    }
    T number{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc{} || stop != end || !std::isfinite(static_cast<double>(number))) {
        return std::nullopt;
    }
    return number;
}

std::optional<std::vector<double>> parse_vector(std::string_view text) {
    std::vector<double> numbers;
    if (text.empty()) {
        return numbers;
    }
    for (const std::string_view part : split(text, '/')) {
        const std::optional<double> number = parse_number<double>(part);
        if (!number) {
            return std::nullopt;
        }
        numbers.push_back(*number);
    }
    return numbers;
}

std::string join(const std::vector<std::string>& words, const char* separator) {
    std::string text;
    for (const std::string& word : words) {
        text += (text.empty() ? "" : separator) + word;
    }
    return text;
}

/// "a number from 0 to 1", "one of gaussian, cubic".
std::string expectation(const ParameterSpec& spec) {
    if (spec.type == ParameterType::word) {
        return "one of " + join(spec.words, ", ");
    }
    if (spec.type == ParameterType::vector) {
        return "numbers separated by '/', like 1/2/3";
    }
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << (spec.type == ParameterType::real ? "a number" : "a whole number");
    const bool below = spec.minimum > -unbounded, above = spec.maximum < unbounded;
    if (below && above) {
        text << " from " << spec.minimum << " to " << spec.maximum;
    } else if (below) {
        text << " of at least " << spec.minimum;
    } else if (above) {
        text << " of at most " << spec.maximum;
    }
    return text.str();
}

bool acceptable(const ParameterSpec& spec, std::string_view value) {
    const auto in_range = [&](auto number) {
        return number && static_cast<double>(*number) >= spec.minimum && static_cast<double>(*number) <= spec.maximum;
    };
    switch (spec.type) {
    case ParameterType::real:
        return in_range(parse_number<double>(value));
    case ParameterType::integer:
        return in_range(parse_number<long>(value));
    case ParameterType::word:
        return std::find(spec.words.begin(), spec.words.end(), value) != spec.words.end();
    case ParameterType::vector:
        return parse_vector(value).has_value();
    }
    return false;
}

const ParameterSpec* find_spec(const std::vector<ParameterSpec>& specs, std::string_view name) {
    const auto found = std::find_if(specs.begin(), specs.end(), [wanted = canonical(name)](const ParameterSpec& spec) {
        return canonical(spec.name) == wanted;
    });
    return found == specs.end() ? nullptr : &*found;
}

std::string unknown_parameter(const std::string& owner, std::string_view name,
                              const std::vector<ParameterSpec>& specs) {
    std::string message = owner + " has no parameter '" + std::string(name) + "'";
    if (specs.empty()) {
        return message + "; it has none";
    }
    std::vector<std::string> names;
    for (const ParameterSpec& spec : specs) {
        names.push_back(spec.name);
    }
    const std::string near = nearest_name(name, names);
    message += near.empty() ? "." : "; did you mean '" + near + "'?";
    return message + " It has: " + join(names, ", ");
}

} // namespace

Parameters::Parameters(std::string_view text, std::vector<ParameterSpec> specs, std::string owner)
    : specs_(std::move(specs)), owner_(std::move(owner)) {
    for (const ParameterSpec& spec : specs_) {
        // An empty default means "as `meaning` says".
        if (!spec.default_value.empty() && !acceptable(spec, spec.default_value)) {
            throw InternalError(owner_ + ": the default '" + spec.default_value + "' of parameter '" + spec.name +
                                "' is not " + expectation(spec));
        }
        if (!values_.emplace(spec.name, spec.default_value).second) {
            throw InternalError(owner_ + " declares parameter '" + spec.name + "' twice");
        }
    }
    if (trimmed(text).empty()) {
        return;
    }
    for (const std::string_view assignment : split(text, ',')) {
        const std::size_t equals = assignment.find('=');
        const std::string_view name = trimmed(assignment.substr(0, equals));
        if (equals == std::string_view::npos || name.empty()) {
            throw UsageError(owner_ + ": '" + std::string(assignment) +
                             "' is not of the form name=value (several are separated by ',')");
        }
        const ParameterSpec* spec = find_spec(specs_, name);
        if (spec == nullptr) {
            throw UsageError(unknown_parameter(owner_, name, specs_));
        }
        if (given(spec->name)) {
            throw UsageError(owner_ + ": parameter '" + spec->name + "' is given twice");
        }
        const std::string_view value = trimmed(assignment.substr(equals + 1));
        if (!acceptable(*spec, value)) {
            throw UsageError(owner_ + ": parameter '" + spec->name + "' is '" + std::string(value) + "'; it must be " +
                             expectation(*spec));
        }
        values_[spec->name] = value;
        given_.push_back(spec->name);
    }
}

const std::string& Parameters::value(std::string_view name, ParameterSpec::Type type) const {
    const ParameterSpec* spec = find_spec(specs_, name);
    if (spec == nullptr || spec->type != type) {
        throw InternalError((owner_.empty() ? "plugin" : owner_) + " requests a parameter '" + std::string(name) +
                            (spec == nullptr ? "' that it does not declare" : "' as a type other than declared"));
    }
    return values_.find(spec->name)->second;
}

double Parameters::real(std::string_view name) const {
    const std::optional<double> number = parse_number<double>(value(name, ParameterType::real));
    if (!number) {
        throw InternalError(owner_ + " requests the value of parameter '" + std::string(name) + "', which has none");
    }
    return *number;
}

long Parameters::integer(std::string_view name) const {
    const std::optional<long> number = parse_number<long>(value(name, ParameterType::integer));
    if (!number) {
        throw InternalError(owner_ + " requests the value of parameter '" + std::string(name) + "', which has none");
    }
    return *number;
}

const std::string& Parameters::word(std::string_view name) const {
    return value(name, ParameterType::word);
}

std::vector<double> Parameters::vector(std::string_view name) const {
    return parse_vector(value(name, ParameterType::vector)).value();
}

bool Parameters::given(std::string_view name) const {
    return std::any_of(given_.begin(), given_.end(),
                       [wanted = canonical(name)](const std::string& known) { return canonical(known) == wanted; });
}

std::string Parameters::text() const {
    std::string text;
    for (const ParameterSpec& spec : specs_) {
        if (const std::string& value = values_.find(spec.name)->second; !value.empty()) {
            text += (text.empty() ? "" : ",") + spec.name + "=" + value;
        }
    }
    return text;
}

namespace {

/// Letters to insert, delete, replace or swap with their neighbour to turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::swap(before_last, last);
        std::swap(last, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
                row[j] = std::min(row[j], before_last[j - 2] + 1);
            }
        }
    }
    return row[b.size()];
}

} // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& known) {
    const std::size_t near = std::max<std::size_t>(1, name.size() / 3);
    std::size_t best_distance = near + 1;
    std::string best;
    for (const std::string& candidate : known) {
        const std::size_t distance = edit_distance(canonical(name), canonical(candidate));
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

} // namespace difusa
