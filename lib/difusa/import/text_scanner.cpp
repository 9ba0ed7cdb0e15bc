#include <difusa/import/text_scanner.h>

#include <difusa/core/error.h>

#include <charconv>
#include <limits>
#include <locale>
#include <sstream>
#include <utility>

namespace difusa {

namespace {

bool is_line_end(char c) {
    return c == '\n' || c == '\r';
}
bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// from_chars accepts no plus sign.
std::string_view without_plus(std::string_view token) {
    const bool plus = token.size() > 1 && token[0] == '+' && token[1] != '-' && token[1] != '+';
    return plus ? token.substr(1) : token;
}

/// The double nearest to a decimal number outside the range of normal doubles.
double beyond_range(std::string_view token) {
    std::istringstream stream{std::string(token)};
    stream.imbue(std::locale::classic());
    double value = 0.0;
    if (stream >> value) {
        return value; // too small
    }
    const double infinity = std::numeric_limits<double>::infinity();
    return token.front() == '-' ? -infinity : infinity;
}

/// The Windows C library printed 1.#INF, -1.#IND, 1.#QNAN and 1.#SNAN for many years.
bool parse_old_windows(std::string_view token, double& value) {
    const bool negative = token.front() == '-';
    token.remove_prefix(negative ? 1 : 0);
    if (!token.starts_with("1.#")) {
        return false;
    }
    const bool infinite = token.substr(3) == "INF";
    value = infinite ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    value = negative ? -value : value;
    return infinite || token.substr(3) == "IND" || token.substr(3) == "QNAN" || token.substr(3) == "SNAN";
}

} // namespace

bool parse_real(std::string_view token, double& value) {
    token = without_plus(token);
    const char* const end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(token.data(), end, value);
    if (stop == end && error == std::errc()) {
        return true;
    }
    if (stop == end && error == std::errc::result_out_of_range) {
        value = beyond_range(token);
        return true;
    }
    return !token.empty() && parse_old_windows(token, value);
}

bool parse_integer(std::string_view token, std::int64_t& value) {
    token = without_plus(token);
    const char* const end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(token.data(), end, value);
    return stop == end && error == std::errc();
}

std::string lower_case(std::string_view word) {
    std::string result(word);
    for (char& c : result) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return result;
}

TextScanner::TextScanner(std::string_view content, std::string file, Syntax syntax, std::uint32_t first_line)
    : file_(std::move(file)), syntax_(syntax), begin_(content.data()), at_(begin_), end_(begin_ + content.size()),
      line_(first_line) {
    if (content.starts_with("\xef\xbb\xbf")) {
        at_ += 3;
    }
    if (content.starts_with("\xff\xfe") || content.starts_with("\xfe\xff")) {
        fail("the text is in UTF-16: save it as UTF-8");
    }
}

void TextScanner::take_line_end() {
    const bool pair = *at_ == '\r' && at_ + 1 < end_ && at_[1] == '\n';
    at_ += pair ? 2 : 1;
    ++line_;
}

bool TextScanner::seek(Reach reach) {
    while (at_ < end_) {
        if (is_blank(*at_)) {
            ++at_;
        } else if (is_line_end(*at_)) {
            if (reach == Reach::line) {
                return false;
            }
            take_line_end();
        } else if (syntax_.comments && *at_ == '#') {
            while (at_ < end_ && !is_line_end(*at_)) {
                ++at_;
            }
        } else if (syntax_.continuation && *at_ == '\\' && at_ + 1 < end_ && is_line_end(at_[1])) {
            ++at_;
            take_line_end();
        } else {
            return true;
        }
    }
    return false;
}

bool TextScanner::next(std::string_view& token, Reach reach) {
    if (!seek(reach)) {
        return false;
    }
    const char* const start = at_;
    for (; at_ < end_ && !is_blank(*at_) && !is_line_end(*at_); ++at_) {
        // A comment may follow a token without a blank; the # of 1.#INF starts none.
        const bool has_next = at_ + 1 < end_;
        if (*at_ == '#' && syntax_.comments && at_ != start && !(at_[-1] == '.' && has_next && is_letter(at_[1]))) {
            break;
        }
        if (*at_ == '\\' && syntax_.continuation && has_next && is_line_end(at_[1])) {
            break;
        }
    }
    token = {start, static_cast<std::size_t>(at_ - start)};
    return true;
}

std::string_view TextScanner::rest_of_line() {
    while (at_ < end_ && is_blank(*at_)) {
        ++at_;
    }
    const char* const start = at_;
    const char* stop = at_; // after the last non-blank character
    bool comment = false;
    for (; at_ < end_ && !is_line_end(*at_); ++at_) {
        comment = comment || (syntax_.comments && *at_ == '#' && (at_ == start || is_blank(at_[-1])));
        if (!comment && !is_blank(*at_)) {
            stop = at_ + 1;
        }
    }
    return {start, static_cast<std::size_t>(stop - start)};
}

double TextScanner::real(const Expected& expected, Reach reach) {
    std::string_view token;
    double value = 0.0;
    if (!next(token, reach)) {
        fail_missing(expected, reach);
    }
    if (!parse_real(token, value)) {
        fail_unexpected(token, expected);
    }
    return value;
}

std::int64_t TextScanner::integer(const Expected& expected, Reach reach) {
    std::string_view token;
    std::int64_t value = 0;
    if (!next(token, reach)) {
        fail_missing(expected, reach);
    }
    if (!parse_integer(token, value)) {
        fail_unexpected(token, expected);
    }
    return value;
}

std::size_t TextScanner::count_lines() const {
    TextScanner ahead(*this);
    std::size_t lines = 0;
    while (ahead.seek(Reach::file)) {
        ++lines;
        while (ahead.at_ < end_ && !is_line_end(*ahead.at_)) {
            ++ahead.at_;
        }
    }
    return lines;
}

bool TextScanner::ends_abruptly() const {
    const char* last = end_;
    while (last > begin_ && is_blank(last[-1])) {
        --last;
    }
    return last > begin_ && !is_line_end(last[-1]);
}

void TextScanner::fail_at(std::uint32_t line, const std::string& problem) const {
    throw InputError(file_ + ":" + std::to_string(line) + ": " + problem);
}

void TextScanner::fail_missing(const Expected& expected, Reach reach) const {
    TextScanner ahead(*this);
    if (reach == Reach::line && ahead.to_token()) {
        fail("the line ends where " + expected.text() + " is expected: complete the line");
    }
    fail("the file ends where " + expected.text() +
         " is expected: it is truncated, or its header announces too much; export it again");
}

void TextScanner::fail_unexpected(std::string_view token, const Expected& expected) const {
    fail("expected " + expected.text() + ", found " + excerpt(token) + ": correct the line, or export the file again");
}

} // namespace difusa
