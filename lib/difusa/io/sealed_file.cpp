#include <difusa/io/sealed_file.h>

#include <difusa/core/error.h>
#include <difusa/import/file_content.h>
#include <difusa/io/checksum.h>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <optional>
#include <system_error>

namespace difusa {

namespace {

std::string seal_text(const SealKind& kind, unsigned version, std::uint64_t length, std::uint32_t checksum) {
    char hex[16];
    std::snprintf(hex, sizeof hex, "%08x", checksum);
    std::string text = kind.name + "\nversion " + std::to_string(version) + "\nbytes " + std::to_string(length) +
                       "\ncrc32 " + hex + "\nThe content follows from byte " + std::to_string(seal_size) + " on.\n";
    DIFUSA_REQUIRE(text.size() < seal_size, kind.name);
    text.resize(seal_size, '\0');
    return text;
}

/// The number that follows `label` in a seal.
std::optional<std::uint64_t> sealed_number(std::string_view seal, std::string_view label, int base) {
    const std::size_t at = seal.find(label);
    if (at == std::string_view::npos) {
        return std::nullopt;
    }
    const char* const begin = seal.data() + at + label.size();
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(begin, seal.data() + seal.size(), number, base);
    return error == std::errc() && end != begin ? std::optional(number) : std::nullopt;
}

} // namespace

std::string seal_of(const SealKind& kind, std::string_view content) {
    return seal_text(kind, kind.version, content.size(), crc32_of(content));
}

void write_sealed(WholeFile& file, const SealKind& kind, std::string_view content) {
    file.write(seal_of(kind, content));
    file.write(content);
}

bool begins_as_sealed(const std::filesystem::path& file, const SealKind& kind) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) {
        return false; // a pipe can be read only once
    }
    const std::string wanted = kind.name + "\n";
    std::string begin(wanted.size(), '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
    return in && begin == wanted;
}

std::string read_sealed(const std::filesystem::path& file, const SealKind& kind) {
    const auto refuse = [&](const std::string& why) {
        throw InputError(file.string() + ": " + why + "; " + kind.remedy);
    };
    check_readable(file);
    std::error_code ignored;
    if (std::filesystem::file_size(file, ignored) == 0) {
        refuse("is empty");
    }
    std::string bytes = read_file(file);
    if (bytes.compare(0, kind.name.size() + 1, kind.name + "\n") != 0) {
        refuse("is not a file of the kind `" + kind.name + "`, or its beginning is damaged");
    }
    const std::string_view seal = std::string_view(bytes).substr(0, seal_size);
    const auto version = sealed_number(seal, "\nversion ", 10), length = sealed_number(seal, "\nbytes ", 10),
               checksum = sealed_number(seal, "\ncrc32 ", 16);
    if (seal.size() < seal_size || !version || !length || !checksum ||
        seal != seal_text(kind, static_cast<unsigned>(*version), *length, static_cast<std::uint32_t>(*checksum))) {
        refuse("the first " + std::to_string(seal_size) + " bytes are damaged or missing");
    }
    if (*version != kind.version) {
        refuse("has version " + std::to_string(*version) + " of its format, and this program reads version " +
               std::to_string(kind.version));
    }
    const std::string_view content = std::string_view(bytes).substr(seal_size);
    if (content.size() != *length) {
        refuse("is " + std::string(content.size() < *length ? "cut short" : "too long") + ": " +
               std::to_string(content.size()) + " bytes follow its first " + std::to_string(seal_size) + ", not " +
               std::to_string(*length));
    }
    if (crc32_of(content) != *checksum) {
        refuse("is damaged: its content does not have the checksum that it states");
    }
    return bytes;
}

} // namespace difusa
