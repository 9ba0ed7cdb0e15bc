// Fuzz target: saved transports with a good seal and sound HDF5 structure whose content is not what a bake writes. An
// input is the number of one of the files in transports/ and a list of edits to its attributes and arrays. (Raw bytes
// are refused by the checksum, and the structure of HDF5 files is that library's to defend.)
#include "fuzz_file.h"

#include <difusa/bake/saved_transport.h>
#include <difusa/bake/transport_file.h>
#include <difusa/import/file_content.h>
#include <difusa/io/hdf5_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include <hdf5.h>

namespace {

using Bytes = std::vector<std::uint8_t>;

/// An attribute, or an array with `columns` numbers in a row.
struct Item {
    enum class Type { text, byte, index, whole, real };
    Type type = Type::byte;
    std::string group, name; ///< of an array: its path is the name
    std::size_t columns = 0; ///< 0: an attribute
    Bytes bytes;

    std::size_t width() const { return type == Type::text || type == Type::byte ? 1 : type == Type::index ? 4 : 8; }
};

struct Content {
    std::vector<std::string> groups;
    std::vector<Item> items;
};

Item::Type type_of(hid_t type) {
    switch (H5Tget_class(type)) {
    case H5T_STRING:
        return Item::Type::text;
    case H5T_FLOAT:
        return Item::Type::real;
    default:
        return H5Tget_size(type) == 1   ? Item::Type::byte
               : H5Tget_size(type) == 4 ? Item::Type::index
                                        : Item::Type::whole;
    }
}

void read_attributes(hid_t file, const std::string& group, Content& content) {
    const hid_t object = H5Oopen(file, group.c_str(), H5P_DEFAULT);
    const int count = H5Aget_num_attrs(object);
    for (int k = 0; k < count; ++k) {
        const hid_t attribute =
            H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, static_cast<hsize_t>(k), H5P_DEFAULT, H5P_DEFAULT);
        const hid_t type = H5Aget_type(attribute);
        std::array<char, 64> name{};
        H5Aget_name(attribute, name.size(), name.data());
        Item item{type_of(type), group, name.data(), 0, Bytes(H5Tget_size(type))};
        fuzz::hold(H5Aread(attribute, type, item.bytes.data()) >= 0, "the attributes of the seeds can be read");
        content.items.push_back(std::move(item));
        H5Tclose(type);
        H5Aclose(attribute);
    }
    H5Oclose(object);
}

void read_array(hid_t file, const std::string& path, Content& content) {
    const hid_t array = H5Dopen2(file, path.c_str(), H5P_DEFAULT), space = H5Dget_space(array),
                type = H5Dget_type(array);
    std::array<hsize_t, 2> size{0, 1};
    H5Sget_simple_extent_dims(space, size.data(), nullptr);
    Item item{type_of(type), "", path, static_cast<std::size_t>(size[1]), {}};
    item.bytes.resize(size[0] * size[1] * item.width());
    fuzz::hold(H5Dread(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, item.bytes.data()) >= 0,
               "the arrays of the seeds can be read");
    content.items.push_back(std::move(item));
    H5Tclose(type);
    H5Sclose(space);
    H5Dclose(array);
}

Content content_of(const char* file) {
    std::string bytes = difusa::read_file(file);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fapl_core(access, 1U << 20U, false);
    H5Pset_file_image(access, bytes.data(), bytes.size());
    const hid_t opened = H5Fopen("seed", H5F_ACC_RDONLY, access); // no file may have the name of one in memory
    fuzz::hold(opened >= 0, "the seeds are HDF5 files");
    std::vector<std::string> paths;
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->push_back(std::string("/") + name);
        return 0;
    };
    H5Lvisit(opened, H5_INDEX_NAME, H5_ITER_INC, add, &paths);
    Content content;
    read_attributes(opened, "/", content);
    for (const std::string& path : paths) {
        const hid_t object = H5Oopen(opened, path.c_str(), H5P_DEFAULT);
        const bool is_group = H5Iget_type(object) == H5I_GROUP;
        H5Oclose(object);
        if (is_group) {
            content.groups.push_back(path);
            read_attributes(opened, path, content);
        } else {
            read_array(opened, path, content);
        }
    }
    H5Fclose(opened);
    H5Pclose(access);
    return content;
}

/// One edit of one item, as it is in the input.
struct Edit {
    std::uint8_t item, operation;
    std::uint16_t at;
    std::array<std::uint8_t, 8> value;
};
static_assert(sizeof(Edit) == 12);

/// Numbers at the limits of what the reader may expect, as the item stores them.
Bytes remarkable(const Item& item, std::uint8_t which) {
    constexpr std::array<std::uint64_t, 8> wholes{
        0, 1, 2, 0x7fffffff, 0x80000000, 0xffffffff, 0x8000000000000000, 0xffffffffffffffff};
    constexpr std::array<double, 8> reals{0.0,
                                          1.0,
                                          -1.0,
                                          1e-300,
                                          1e300,
                                          -0.0,
                                          std::numeric_limits<double>::infinity(),
                                          std::numeric_limits<double>::quiet_NaN()};
    Bytes bytes(item.width());
    if (item.type == Item::Type::real) {
        std::memcpy(bytes.data(), &reals[which % reals.size()], bytes.size());
    } else {
        std::memcpy(bytes.data(), &wholes[which % wholes.size()], bytes.size());
    }
    return bytes;
}

void apply(const Edit& edit, Content& content) {
    if (content.items.empty()) {
        return;
    }
    const std::size_t number = edit.item % content.items.size();
    Item& item = content.items[number];
    const std::size_t width = item.width(), count = item.bytes.size() / width;
    const std::size_t row = width * std::max<std::size_t>(1, item.columns);
    const auto put = [&](std::size_t k, const std::uint8_t* value) {
        if (count > 0) {
            std::memcpy(item.bytes.data() + k % count * width, value, width);
        }
    };
    switch (edit.operation % 6) {
    case 0:
        put(edit.at, edit.value.data());
        break;
    case 1:
        put(edit.at, remarkable(item, edit.value[0]).data());
        break;
    case 2: // all of one value
        for (std::size_t k = 0; k < count; ++k) {
            put(k, remarkable(item, edit.value[0]).data());
        }
        break;
    case 3: // fewer rows
        if (item.columns > 0) {
            item.bytes.resize(edit.at % (item.bytes.size() / row + 1) * row);
        }
        break;
    case 4: // more rows
        if (item.columns > 0) {
            item.bytes.resize(item.bytes.size() + (1 + edit.at % 64) * row, edit.value[0]);
        }
        break;
    default:
        content.items.erase(content.items.begin() + static_cast<std::ptrdiff_t>(number));
    }
}

template <class T> void write_array(const Item& item, difusa::Hdf5Writer& writer) {
    std::vector<T> values(item.bytes.size() / sizeof(T));
    if (!values.empty()) {
        std::memcpy(values.data(), item.bytes.data(), item.bytes.size());
    }
    writer.array<T>(item.name, values, item.columns, "");
}

void write(const Item& item, difusa::Hdf5Writer& writer) {
    if (item.columns > 0) {
        switch (item.type) {
        case Item::Type::index:
            return write_array<std::uint32_t>(item, writer);
        case Item::Type::whole:
            return write_array<std::uint64_t>(item, writer);
        case Item::Type::real:
            return write_array<double>(item, writer);
        default:
            return write_array<std::uint8_t>(item, writer);
        }
    }
    double real = 0.0;
    std::uint64_t whole = 0;
    switch (item.type) {
    case Item::Type::text:
        return writer.attribute(item.group, item.name,
                                std::string(item.bytes.begin(), std::find(item.bytes.begin(), item.bytes.end(), 0)));
    case Item::Type::real:
        std::memcpy(&real, item.bytes.data(), sizeof real);
        return writer.attribute(item.group, item.name, real);
    default:
        std::memcpy(&whole, item.bytes.data(), std::min(sizeof whole, item.bytes.size()));
        return writer.attribute(item.group, item.name, whole);
    }
}

/// With a good seal.
std::string file_of(const Content& content) {
    difusa::Hdf5Writer writer(difusa::seal_size);
    for (const std::string& group : content.groups) {
        writer.group(group);
    }
    for (const Item& item : content.items) {
        write(item, writer);
    }
    const std::string bytes = writer.finish();
    return difusa::seal_of(difusa::transport_seal(), bytes) + bytes;
}

/// What relighting relies on without asking again.
void check(const difusa::SavedTransport& saved) {
    const difusa::LightTransport& gathered = saved.gathered;
    const std::size_t points = gathered.points();
    fuzz::hold(gathered.sky.size() == points && gathered.back.size() == points, "shares for all points");
    fuzz::hold(saved.sites->size() <= points && saved.sites->radius.size() == saved.sites->size() &&
                   saved.sites->area.size() == saved.sites->size(),
               "as many points as sites at least");
    fuzz::hold(gathered.W->columns() > gathered.surfels, "columns for surfels and sky");
    if (gathered.W->columns() > 100'000) {
        return;
    }
    const difusa::Execution execution;
    const auto columns = static_cast<Eigen::Index>(gathered.W->columns());
    difusa::Values h, b;
    for (const Eigen::Index channels : {1, 3}) {
        if (gathered.back_in_mirrors.cols() == 3 && channels == 1) {
            continue;
        }
        gathered.W->apply(difusa::Values::Ones(columns, channels), h, execution);
        fuzz::hold(static_cast<std::size_t>(h.rows()) == points, "a value for each point");
        gathered.W->apply_transpose(h, b, execution);
        fuzz::hold(b.rows() == columns, "a value for each column");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::array<Content, 4> seeds{content_of("transports/gathered"), content_of("transports/mirrored"),
                                              content_of("transports/pairwise"), content_of("transports/periodic")};
    if (size == 0) {
        return 0;
    }
    Content content = seeds[data[0] % seeds.size()];
    for (std::size_t k = 1; k + sizeof(Edit) <= size; k += sizeof(Edit)) {
        Edit edit{};
        std::memcpy(&edit, data + k, sizeof edit);
        apply(edit, content);
    }
    const std::string bytes = file_of(content);
    fuzz::read_file_of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), [](const auto& file) {
        const difusa::SavedTransport saved = difusa::load_transport(file, difusa::Execution{});
        check(saved);
    });
    return 0;
}
