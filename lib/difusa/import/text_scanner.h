// Tokens of a text file with their line numbers, and locale-independent parsing of numbers.
#pragma once

#include <difusa/import/file_content.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace difusa {

/// White space within a line.
constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

/// Reads a text once, from front to back. Tokens are separated by white space; lines end with LF, CR LF or CR; a
/// leading UTF-8 byte order mark is skipped. The text must outlive the scanner.
class TextScanner {
  public:
    /// What counts as white space besides blanks.
    struct Syntax {
        bool comments = false;     ///< `#` to the end of the line
        bool continuation = false; ///< `\` before a line end joins the lines; not inside a comment
    };
    /// How far to look for a token.
    enum class Reach { line, file };

    /// `file` is for messages, and the number of the text's first line in it. Throws InputError for a text in UTF-16.
    TextScanner(std::string_view content, std::string file, Syntax syntax, std::uint32_t first_line = 1);

    /// Takes the next token; false if there is none within reach.
    bool next(std::string_view& token, Reach reach);

    /// Moves to the start of the next token, across line ends; false if there is none.
    bool to_token() { return seek(Reach::file); }

    /// True if the line has no further token.
    bool at_line_end() { return !seek(Reach::line); }

    /// Takes the rest of the line, without surrounding blanks and without a comment after a blank.
    std::string_view rest_of_line();

    /// Takes a number. Besides decimal notation this accepts `nan` and `inf` as printed by the usual libraries; values
    /// too large for a double become infinite, values too small 0 or subnormal.
    /// Throws InputError if the next token within reach is missing or anything else.
    double real(const Expected& expected, Reach reach);

    /// Takes a whole number. Throws like `real`.
    std::int64_t integer(const Expected& expected, Reach reach);

    /// Number of the current line, from 1: that of the last token taken.
    std::uint32_t line() const { return line_; }

    /// Number of bytes not taken yet.
    std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

    /// Number of bytes taken so far.
    std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }

    /// Number of lines from here on that contain a token.
    std::size_t count_lines() const;

    /// True if the last line has no line end, as in a truncated file.
    bool ends_abruptly() const;

    /// Throws InputError "file:line: problem".
    [[noreturn]] void fail(const std::string& problem) const { fail_at(line_, problem); }
    [[noreturn]] void fail_at(std::uint32_t line, const std::string& problem) const;
    [[noreturn]] void fail_missing(const Expected& expected, Reach reach) const;
    [[noreturn]] void fail_unexpected(std::string_view token, const Expected& expected) const;

  private:
    bool seek(Reach reach);
    void take_line_end();

    std::string file_;
    Syntax syntax_;
    const char* begin_;
    const char* at_;
    const char* end_;
    std::uint32_t line_;
};

/// The number spelled by a token, see TextScanner::real; false if it is not one.
bool parse_real(std::string_view token, double& value);

/// The whole number spelled by a token, with an optional sign; false if it is not one or does not fit.
bool parse_integer(std::string_view token, std::int64_t& value);

/// `word` in lower case, ASCII letters only.
std::string lower_case(std::string_view word);

} // namespace difusa
