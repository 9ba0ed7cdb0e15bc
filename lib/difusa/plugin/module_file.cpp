#include <difusa/core/error.h>
#include <difusa/plugin/module_file.h>

#include <dlfcn.h>
#include <elf.h>
#include <link.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace difusa {

namespace {

using ElfHeader = ElfW(Ehdr); // of this process' word size
using ProgramHeader = ElfW(Phdr);
using Section = ElfW(Shdr);

constexpr std::string_view section_name = ".difusa_plugin";
constexpr std::uint64_t longest_tag = 4096;

/// The shared object containing this code, as mapped by the dynamic linker.
Dl_info own_object() {
    Dl_info info{};
    if (dladdr(reinterpret_cast<const void*>(&own_object), &info) == 0 || info.dli_fbase == nullptr ||
        info.dli_fname == nullptr) {
        throw InternalError("the dynamic linker does not know the file of the difusa library");
    }
    return info;
}

/// A mapped object starts with its ELF header: what a module for this process must match.
ElfHeader own_header() {
    ElfHeader header;
    std::memcpy(&header, own_object().dli_fbase, sizeof header);
    return header;
}

/// Random access to a file, never reading past its end.
class BoundedFile {
  public:
    explicit BoundedFile(const std::filesystem::path& file) {
        std::error_code error;
        // Only regular files: opening a pipe would wait for a writer.
        if (!std::filesystem::is_regular_file(file, error)) {
            throw ModuleRefused("not a regular file");
        }
        size_ = std::filesystem::file_size(file, error);
        stream_.open(file, std::ios::binary);
        if (error || !stream_) {
            throw ModuleRefused("the file cannot be opened for reading");
        }
    }

    bool contains(std::uint64_t offset, std::uint64_t length) const {
        return offset <= size_ && length <= size_ - offset;
    }

    void read(std::uint64_t offset, void* target, std::uint64_t length) {
        if (!contains(offset, length)) {
            throw ModuleRefused("the file is truncated: it has " + std::to_string(size_) + " bytes and needs " +
                                std::to_string(offset) + " + " + std::to_string(length));
        }
        stream_.seekg(static_cast<std::streamoff>(offset));
        stream_.read(static_cast<char*>(target), static_cast<std::streamsize>(length));
        if (!stream_) {
            throw ModuleRefused("the file cannot be read");
        }
    }

    template <class T> std::vector<T> read_table(std::uint64_t offset, std::uint64_t count) {
        // Checked before allocating memory for it; `count` has at most 32 bits, so the product cannot overflow.
        if (!contains(offset, count * sizeof(T))) {
            throw ModuleRefused("the file is truncated: it has " + std::to_string(size_) + " bytes, but its tables " +
                                "would end at " + std::to_string(offset) + " + " + std::to_string(count * sizeof(T)));
        }
        std::vector<T> table(count);
        read(offset, table.data(), count * sizeof(T));
        return table;
    }

  private:
    std::ifstream stream_;
    std::uint64_t size_ = 0;
};

ElfHeader read_header(BoundedFile& file) {
    unsigned char ident[EI_NIDENT] = {};
    if (!file.contains(0, sizeof ident)) {
        throw ModuleRefused("not a shared object: the file is too short");
    }
    file.read(0, ident, sizeof ident);
    if (std::memcmp(ident, ELFMAG, SELFMAG) != 0) {
        throw ModuleRefused("not a shared object: the file does not begin with the ELF magic number");
    }
    const ElfHeader own = own_header();
    if (ident[EI_CLASS] != own.e_ident[EI_CLASS] || ident[EI_DATA] != own.e_ident[EI_DATA]) {
        throw ModuleRefused("built for a machine with another word size or byte order");
    }
    ElfHeader header;
    file.read(0, &header, sizeof header);
    if (header.e_machine != own.e_machine) {
        throw ModuleRefused("built for another processor: its ELF machine number is " +
                            std::to_string(header.e_machine) + ", expected " + std::to_string(own.e_machine));
    }
    if (header.e_type != ET_DYN) {
        throw ModuleRefused("not a shared object but another kind of ELF file (type " + std::to_string(header.e_type) +
                            ", expected " + std::to_string(ET_DYN) + ")");
    }
    if (header.e_shentsize != sizeof(Section) || header.e_phentsize != sizeof(ProgramHeader) || header.e_shoff == 0 ||
        header.e_shnum == 0 || header.e_shstrndx >= header.e_shnum) {
        throw ModuleRefused("damaged: its ELF header describes no usable tables of sections and segments");
    }
    return header;
}

void check_segments(BoundedFile& file, const ElfHeader& header) {
    for (const auto& segment : file.read_table<ProgramHeader>(header.e_phoff, header.e_phnum)) {
        if (!file.contains(segment.p_offset, segment.p_filesz)) {
            throw ModuleRefused("the file is truncated: one of its segments would end at " +
                                std::to_string(segment.p_offset) + " + " + std::to_string(segment.p_filesz));
        }
    }
}

/// The text of the section with the tag.
std::string read_tag_section(BoundedFile& file, const ElfHeader& header) {
    const auto sections = file.read_table<Section>(header.e_shoff, header.e_shnum);
    const auto& names_section = sections[header.e_shstrndx];
    if (names_section.sh_type != SHT_STRTAB || names_section.sh_size > UINT32_MAX) {
        throw ModuleRefused("damaged: it has no valid table of section names");
    }
    const auto names = file.read_table<char>(names_section.sh_offset, names_section.sh_size);
    const std::string_view all_names(names.data(), names.size());
    for (const auto& section : sections) {
        if (section.sh_name >= all_names.size() || section.sh_type == SHT_NOBITS) {
            continue;
        }
        const std::string_view name = all_names.substr(section.sh_name);
        if (name.substr(0, name.find('\0')) != section_name) {
            continue;
        }
        if (section.sh_size > longest_tag) {
            throw ModuleRefused("damaged: its plugin tag has " + std::to_string(section.sh_size) + " bytes");
        }
        const auto content = file.read_table<char>(section.sh_offset, section.sh_size);
        std::string text(content.begin(), std::find(content.begin(), content.end(), '\0'));
        if (std::any_of(content.begin() + static_cast<std::ptrdiff_t>(text.size()), content.end(),
                        [](char c) { return c != '\0'; })) {
            throw ModuleRefused("it has more than one plugin tag; a module holds one plugin");
        }
        return text;
    }
    throw ModuleRefused("not a difusa plugin: it has no section " + std::string(section_name) +
                        " (made by the macro DIFUSA_PLUGIN)");
}

bool is_name(std::string_view word) {
    return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    });
}

} // namespace

ModuleTag parse_module_tag(std::string_view text) {
    constexpr std::string_view mark = "difusa-plugin";
    const std::string whole(text);
    std::vector<std::pair<std::string, std::string>> fields;
    if (text.substr(0, text.find(';')) != mark) {
        throw ModuleRefused("damaged: its plugin tag does not begin with \"" + std::string(mark) + "\"");
    }
    text.remove_prefix(mark.size());
    while (!text.empty()) {
        text.remove_prefix(1); // the ';'
        const std::string_view field = text.substr(0, text.find(';'));
        const std::size_t equals = field.find('=');
        if (equals == std::string_view::npos) {
            throw ModuleRefused("damaged: its plugin tag \"" + whole + "\" has a part without '='");
        }
        fields.emplace_back(field.substr(0, equals), field.substr(equals + 1));
        text.remove_prefix(field.size());
    }
    if (fields.size() < 2 || fields[0].first != "kind" || fields[1].first != "name") {
        throw ModuleRefused("damaged: its plugin tag \"" + whole + "\" does not begin with kind and name");
    }
    if (!is_name(fields[0].second) || !is_name(fields[1].second)) {
        throw ModuleRefused("its plugin tag \"" + whole +
                            "\" has a kind or name with characters other than lower-case letters, digits and '-'");
    }
    return {fields[0].second, fields[1].second, {fields.begin() + 2, fields.end()}};
}

ModuleTag read_module_tag(const std::filesystem::path& path) {
    BoundedFile file(path);
    const ElfHeader header = read_header(file);
    check_segments(file, header);
    return parse_module_tag(read_tag_section(file, header));
}

std::filesystem::path library_directory() {
    return std::filesystem::canonical(own_object().dli_fname).parent_path();
}

} // namespace difusa
