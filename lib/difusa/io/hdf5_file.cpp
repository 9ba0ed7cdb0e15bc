#include <difusa/io/hdf5_file.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>
#include <type_traits>
#include <utility>

#include <hdf5.h>

namespace difusa {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

namespace {

/// For the duration of a call: no other thread is in HDF5, and HDF5 prints nothing.
class Hdf5Call {
  public:
    Hdf5Call() : lock_(guard()) {
        H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~Hdf5Call() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
    Hdf5Call(const Hdf5Call&) = delete;
    Hdf5Call& operator=(const Hdf5Call&) = delete;

  private:
    static std::mutex& guard() {
        static std::mutex one;
        return one;
    }
    std::lock_guard<std::mutex> lock_;
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

/// Closes what HDF5 has opened.
class Hdf5Handle {
  public:
    Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Hdf5Handle() {
        if (id_ >= 0) {
            close_(id_);
        }
    }
    Hdf5Handle(const Hdf5Handle&) = delete;
    Hdf5Handle& operator=(const Hdf5Handle&) = delete;
    hid_t id() const { return id_; }
    explicit operator bool() const { return id_ >= 0; }

  private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

void require_hdf5(bool done, const char* what) {
    if (!done) {
        throw ResourceError(std::string("the HDF5 library cannot ") + what + ": make sure that memory suffices");
    }
}

/// Files in memory are told apart by their names.
std::string name_in_memory() {
    static std::atomic<unsigned> counter{0};
    return "difusa-" + std::to_string(counter++);
}

/// Also that of the numbers in memory.
template <class T> hid_t stored_type() {
    static_assert(std::endian::native == std::endian::little);
    if constexpr (std::is_same_v<T, std::uint8_t>) {
        return H5T_STD_U8LE;
    } else if constexpr (std::is_same_v<T, std::uint32_t>) {
        return H5T_STD_U32LE;
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
        return H5T_STD_U64LE;
    } else {
        return H5T_IEEE_F64LE;
    }
}

/// A property list of this class, with what would depend on the time switched off.
hid_t timeless(hid_t property_class) {
    const hid_t list = H5Pcreate(property_class);
    H5Pset_obj_track_times(list, false);
    return list;
}

void put_attribute(hid_t object, const std::string& name, hid_t type, const void* value) {
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle attribute(H5Acreate2(object, name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    require_hdf5(attribute && H5Awrite(attribute.id(), type, value) >= 0, "store an attribute");
}

void put_text(hid_t object, const std::string& name, const std::string& text) {
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.id(), text.size() + 1);
    H5Tset_cset(type.id(), H5T_CSET_UTF8);
    H5Tset_strpad(type.id(), H5T_STR_NULLTERM);
    put_attribute(object, name, type.id(), text.c_str());
}

/// HDF5 makes copies of a file in memory, one for the list of properties and one for the open file. These are the bytes
/// themselves, which nobody writes to.
H5FD_file_image_callbacks_t uncopied(char* bytes) {
    H5FD_file_image_callbacks_t in_place{};
    in_place.image_malloc = [](std::size_t, H5FD_file_image_op_t, void* data) { return data; };
    in_place.image_memcpy = [](void* to, const void*, std::size_t, H5FD_file_image_op_t, void*) { return to; };
    in_place.image_realloc = [](void*, std::size_t, H5FD_file_image_op_t, void*) -> void* { return nullptr; };
    in_place.image_free = [](void*, H5FD_file_image_op_t, void*) -> herr_t { return 0; };
    in_place.udata_copy = [](void* data) { return data; };
    in_place.udata_free = [](void*) -> herr_t { return 0; };
    in_place.udata = bytes;
    return in_place;
}

} // namespace

Hdf5Writer::Hdf5Writer(std::size_t offset) : file_(-1) {
    const Hdf5Call call;
    constexpr std::size_t step = std::size_t{4} << 20U; // by which the memory grows
    const Hdf5Handle creation(timeless(H5P_FILE_CREATE), H5Pclose), access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    require_hdf5(H5Pset_userblock(creation.id(), offset) >= 0 && H5Pset_fapl_core(access.id(), step, false) >= 0,
                 "make a file in memory");
    file_ = H5Fcreate(name_in_memory().c_str(), H5F_ACC_EXCL, creation.id(), access.id());
    require_hdf5(file_ >= 0, "make a file in memory");
}

Hdf5Writer::~Hdf5Writer() {
    const Hdf5Call call;
    H5Fclose(file_);
}

// What these change is behind the handle.
// NOLINTBEGIN(readability-make-member-function-const)

void Hdf5Writer::group(const std::string& path) {
    const Hdf5Call call;
    const Hdf5Handle creation(timeless(H5P_GROUP_CREATE), H5Pclose);
    const Hdf5Handle group(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), H5Gclose);
    require_hdf5(static_cast<bool>(group), "make a group");
}

void Hdf5Writer::attribute(const std::string& group, const std::string& name, double value) {
    const Hdf5Call call;
    const Hdf5Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    put_attribute(object.id(), name, stored_type<double>(), &value);
}

void Hdf5Writer::attribute(const std::string& group, const std::string& name, std::uint64_t value) {
    const Hdf5Call call;
    const Hdf5Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    put_attribute(object.id(), name, stored_type<std::uint64_t>(), &value);
}

void Hdf5Writer::attribute(const std::string& group, const std::string& name, const std::string& text) {
    const Hdf5Call call;
    const Hdf5Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    put_text(object.id(), name, text);
}

template <Hdf5Number T>
void Hdf5Writer::array(const std::string& path, std::span<const T> values, std::size_t columns,
                       const std::string& meaning) {
    DIFUSA_REQUIRE(columns > 0 && values.size() % columns == 0, path);
    const Hdf5Call call;
    const hsize_t size[2] = {values.size() / columns, columns};
    const Hdf5Handle space(H5Screate_simple(columns == 1 ? 1 : 2, size, nullptr), H5Sclose);
    const Hdf5Handle creation(timeless(H5P_DATASET_CREATE), H5Pclose);
    const Hdf5Handle array(
        H5Dcreate2(file_, path.c_str(), stored_type<T>(), space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
        H5Dclose);
    require_hdf5(array && (values.empty() ||
                           H5Dwrite(array.id(), stored_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0),
                 "store an array");
    put_text(array.id(), "meaning", meaning);
}

template void Hdf5Writer::array(const std::string&, std::span<const std::uint8_t>, std::size_t, const std::string&);
template void Hdf5Writer::array(const std::string&, std::span<const std::uint32_t>, std::size_t, const std::string&);
template void Hdf5Writer::array(const std::string&, std::span<const std::uint64_t>, std::size_t, const std::string&);
template void Hdf5Writer::array(const std::string&, std::span<const double>, std::size_t, const std::string&);

std::string Hdf5Writer::finish() {
    const Hdf5Call call;
    H5Fflush(file_, H5F_SCOPE_GLOBAL);
    const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
    require_hdf5(size > 0, "make a file in memory");
    std::string bytes(static_cast<std::size_t>(size), '\0');
    require_hdf5(H5Fget_file_image(file_, bytes.data(), bytes.size()) == size, "make a file in memory");
    return bytes;
}

// NOLINTEND(readability-make-member-function-const)

Hdf5Reader::Hdf5Reader(std::string bytes, std::filesystem::path file, std::string remedy)
    : bytes_(std::move(bytes)), name_(std::move(file)), remedy_(std::move(remedy)) {
    const Hdf5Call call;
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_fapl_core(access.id(), 1U << 20U, false);
    H5FD_file_image_callbacks_t in_place = uncopied(bytes_.data());
    H5Pset_file_image_callbacks(access.id(), &in_place);
    require_hdf5(H5Pset_file_image(access.id(), bytes_.data(), bytes_.size()) >= 0, "hold the file in memory");
    file_ = H5Fopen(name_in_memory().c_str(), H5F_ACC_RDONLY, access.id());
    if (file_ < 0) {
        throw InputError(name_.string() + ": its content is not an HDF5 file; " + remedy_);
    }
}

Hdf5Reader::~Hdf5Reader() {
    const Hdf5Call call;
    H5Fclose(file_);
}

void Hdf5Reader::refuse(const std::string& what, const std::string& why) const {
    throw InputError(name_.string() + ": `" + what + "` " + why + "; " + remedy_);
}

bool Hdf5Reader::has(const std::string& path) const {
    const Hdf5Call call;
    return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5Reader::attribute_names(const std::string& group) const {
    const Hdf5Call call;
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
    };
    const Hdf5Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object || H5Aiterate2(object.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) < 0) {
        refuse(group, "is missing");
    }
    return names;
}

/// Eight bytes of a number, or those of a text.
std::vector<std::uint8_t> Hdf5Reader::attribute_bytes(const std::string& group, const std::string& name,
                                                      bool is_text) const {
    const Hdf5Call call;
    const std::string path = group + " " + name;
    const Hdf5Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object || H5Aexists(object.id(), name.c_str()) <= 0) {
        refuse(path, "is missing");
    }
    const Hdf5Handle attribute(H5Aopen(object.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
    const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose), type(H5Aget_type(attribute.id()), H5Tclose);
    if (!attribute || !space || !type || H5Sget_simple_extent_npoints(space.id()) != 1) {
        refuse(path, "is not a single value");
    }
    const std::size_t length = H5Tget_size(type.id());
    const bool is_string = H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0;
    if (is_text ? !is_string || length > bytes_.size() : is_string || length != sizeof(std::uint64_t)) {
        refuse(path, "has another type than expected");
    }
    std::vector<std::uint8_t> bytes(length);
    if (H5Aread(attribute.id(), type.id(), bytes.data()) < 0) {
        refuse(path, "cannot be read");
    }
    return bytes;
}

double Hdf5Reader::number(const std::string& group, const std::string& name) const {
    const std::vector<std::uint8_t> bytes = attribute_bytes(group, name, false);
    double value = 0.0;
    std::memcpy(&value, bytes.data(), sizeof value);
    if (!std::isfinite(value)) {
        refuse(group + " " + name, "is not a finite number");
    }
    return value;
}

std::uint64_t Hdf5Reader::whole(const std::string& group, const std::string& name) const {
    const std::vector<std::uint8_t> bytes = attribute_bytes(group, name, false);
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

std::string Hdf5Reader::text(const std::string& group, const std::string& name) const {
    const std::vector<std::uint8_t> bytes = attribute_bytes(group, name, true);
    return {bytes.begin(), std::find(bytes.begin(), bytes.end(), std::uint8_t{0})};
}

template <Hdf5Number T> std::vector<T> Hdf5Reader::array(const std::string& path, std::size_t columns) const {
    const Hdf5Call call;
    const Hdf5Handle array(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!array) {
        refuse(path, "is missing");
    }
    const Hdf5Handle space(H5Dget_space(array.id()), H5Sclose), type(H5Dget_type(array.id()), H5Tclose);
    hsize_t size[2] = {0, 1};
    const int dimensions = H5Sget_simple_extent_ndims(space.id());
    if (dimensions != (columns == 1 ? 1 : 2) || H5Sget_simple_extent_dims(space.id(), size, nullptr) < 0 ||
        size[1] != columns) {
        refuse(path, "does not have " + std::to_string(columns) + " numbers in a row");
    }
    if (H5Tequal(type.id(), stored_type<T>()) <= 0) {
        refuse(path, "has another type than expected");
    }
    // What is not in the file would be filled in, however large it claims to be.
    const Hdf5Handle creation(H5Dget_create_plist(array.id()), H5Pclose);
    if (H5Pget_layout(creation.id()) != H5D_CONTIGUOUS || H5Pget_external_count(creation.id()) != 0 ||
        size[0] > bytes_.size() / (columns * sizeof(T)) ||
        H5Dget_storage_size(array.id()) != size[0] * columns * sizeof(T)) {
        refuse(path, "is not stored completely");
    }
    std::vector<T> values(size[0] * columns);
    if (!values.empty() && H5Dread(array.id(), stored_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
        refuse(path, "cannot be read");
    }
    return values;
}

template <Hdf5Number T>
std::vector<T> Hdf5Reader::array(const std::string& path, std::size_t columns, std::size_t rows) const {
    std::vector<T> values = array<T>(path, columns);
    if (values.size() != rows * columns) {
        refuse(path, "has " + std::to_string(values.size() / columns) + " rows, not " + std::to_string(rows));
    }
    return values;
}

template std::vector<std::uint8_t> Hdf5Reader::array(const std::string&, std::size_t) const;
template std::vector<std::uint32_t> Hdf5Reader::array(const std::string&, std::size_t) const;
template std::vector<std::uint64_t> Hdf5Reader::array(const std::string&, std::size_t) const;
template std::vector<double> Hdf5Reader::array(const std::string&, std::size_t) const;
template std::vector<std::uint8_t> Hdf5Reader::array(const std::string&, std::size_t, std::size_t) const;
template std::vector<std::uint32_t> Hdf5Reader::array(const std::string&, std::size_t, std::size_t) const;
template std::vector<std::uint64_t> Hdf5Reader::array(const std::string&, std::size_t, std::size_t) const;
template std::vector<double> Hdf5Reader::array(const std::string&, std::size_t, std::size_t) const;

} // namespace difusa
