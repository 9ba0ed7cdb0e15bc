// Tokens of a text file with the lines they stand on, and numbers out of them, the same in every locale.
#pragma once

#include <difusa/import/file_content.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace difusa {

/// Walks over a text once, from front to back. Tokens are separated by white space; lines end with LF, CR LF or CR;
/// a UTF-8 byte order mark at the front is passed over. The text must outlive the scanner.
class TextScanner {
  public:
    /// What counts as white space besides blanks.
    struct Syntax {
        bool comments = false;     ///< `#` to the end of the line
        bool continuation = false; ///< `\` before a line end joins the lines; not inside a comment
    };
    /// How far a token may be away.
    enum class Reach { line, file };

    /// `file` is for messages. Throws InputError for a text in UTF-16.
    TextScanner(std::string_view content, std::string file, Syntax syntax);

    /// Takes the next token; false if there is none within reach.
    bool next(std::string_view& token, Reach reach);

    /// Moves to where the next token starts, over line ends; false if the file has no more.
    bool to_token() { return seek(Reach::file); }

    /// True if the line has no further token.
    bool at_line_end() { return !seek(Reach::line); }

    /// Takes what is left of the line, without blanks around it and without a comment after a blank.
    std::string_view rest_of_line();

    /// Takes a number. Besides decimal notation this accepts `nan` and `inf` as printed by the usual libraries;
    /// what is too large for a double becomes infinite, what is too small 0 or subnormal.
    /// Throws InputError if the next token within reach is missing or anything else.
    double real(const Expected& expected, Reach reach);

    /// Takes a whole number. Throws like `real`.
    std::int64_t integer(const Expected& expected, Reach reach);

    /// Number of the current line, from 1: that of the token taken last.
    std::uint32_t line() const { return line_; }

    /// Number of bytes not taken yet.
    std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

    /// Number of bytes taken so far.
    std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }

    /// Number of lines from here on with a token in them.
    std::size_t count_lines() const;

    /// True if the last line has no end, as in a file that was cut short.
    bool ends_abruptly() const;

    /// Throws InputError "file, line n: problem".
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
    std::uint32_t line_ = 1;
};

/// The number a token spells, see TextScanner::real; false if it spells none.
bool parse_real(std::string_view token, double& value);

/// The whole number a token spells, with an optional sign; false if it spells none or does not fit.
bool parse_integer(std::string_view token, std::int64_t& value);

/// `word` in lower case, ASCII letters only.
std::string lower_case(std::string_view word);

} // namespace difusa
