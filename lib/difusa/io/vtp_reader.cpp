// VTK reports some damage to the observers of its objects and some not at all; what it has read is checked again.
#include <difusa/io/field_readers.h>

#include <difusa/core/error.h>
#include <difusa/import/base64.h>
#include <difusa/import/file_content.h>
#include <difusa/io/vtk_threads.h>

#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDataCompressor.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>

namespace difusa {

namespace {

/// Captures VTK's error messages, which would otherwise go to the terminal. Its warnings are about data it skips.
class Complaints {
  public:
    Complaints() {
        keep_->SetCallback([](vtkObject*, unsigned long event, void* kept, void* text) {
            if (event == vtkCommand::ErrorEvent) {
                static_cast<Complaints*>(kept)->add(static_cast<const char*>(text));
            }
        });
        keep_->SetClientData(this);
    }
    void listen_to(vtkObject* source) {
        source->AddObserver(vtkCommand::ErrorEvent, keep_);
        source->AddObserver(vtkCommand::WarningEvent, keep_);
    }
    vtkCommand* observer() { return keep_; }
    const std::string& first() const { return first_; }

    /// The first error counts: the others follow from it.
    void add(const char* text) {
        if (!first_.empty()) {
            return;
        }
        // "ERROR: In FILE, line N\nCLASS (ADDRESS): message\n\n"
        first_ = text == nullptr ? "" : text;
        const std::size_t place = first_.find("): ");
        first_.erase(0, place == std::string::npos ? 0 : place + 3);
        while (!first_.empty() && (first_.back() == '\n' || first_.back() == '.' || first_.back() == ' ')) {
            first_.pop_back();
        }
        std::replace(first_.begin(), first_.end(), '\n', ' ');
        first_ = first_.empty() ? "unknown error" : first_.substr(0, 300);
    }

  private:
    vtkNew<vtkCallbackCommand> keep_;
    std::string first_;
};

/// Up to `count` bytes of base64, without leading blanks.
std::string decode(std::string_view text, std::size_t count) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    std::string bytes;
    decode_base64(text, Base64::standard, bytes, count);
    return bytes;
}

/// VTK's reader with all parts reporting errors to us, and with counts rejected that the file has no room for: VTK
/// would allocate memory for whatever they say.
class QuietReader : public vtkXMLPolyDataReader {
  public:
    static QuietReader* New();
    vtkTypeMacro(QuietReader, vtkXMLPolyDataReader) void set(Complaints& complaints,
                                                             const std::filesystem::path& file) {
        complaints_ = &complaints;
        content_ = read_file(file);
        // zlib expands one byte to at most 1032 (its FAQ 34), and nothing that is counted takes less than a byte.
        most_ = 1032.0 * static_cast<double>(content_.size());
        SetFileName(file.c_str());
        SetReaderErrorObserver(complaints.observer());
        SetParserErrorObserver(complaints.observer());
        complaints.listen_to(this);
        complaints.listen_to(GetExecutive());
    }

  protected:
    void CreateXMLParser() override {
        Superclass::CreateXMLParser();
        complaints_->listen_to(XMLParser);
    }
    int ReadVTKFile(vtkXMLDataElement* file) override {
        if (!check(*file)) {
            return 0;
        }
        const auto attribute = [&](const char* name) {
            const char* value = file->GetAttribute(name);
            return std::string(value == nullptr ? "" : value);
        };
        wide_header_ = attribute("header_type") == "UInt64";
        big_endian_ = attribute("byte_order") == "BigEndian";
        const int read = Superclass::ReadVTKFile(file);
        if (XMLParser->GetCompressor() != nullptr) {
            complaints_->listen_to(XMLParser->GetCompressor());
        }
        return read;
    }
    void SetupOutputData() override {
        complaints_->listen_to(GetOutput()->GetPointData());
        complaints_->listen_to(GetOutput()->GetCellData());
        Superclass::SetupOutputData();
    }
    int ReadArrayValues(vtkXMLDataElement* element, vtkIdType index, vtkAbstractArray* array, vtkIdType start,
                        vtkIdType count, FieldType type) override {
        if (XMLParser->GetCompressor() != nullptr && !check_blocks(*element, count)) {
            return 0;
        }
        if (auto* texts = vtkStringArray::SafeDownCast(array); texts != nullptr && !make_room(*element, *texts)) {
            return 0;
        }
        const int read = Superclass::ReadArrayValues(element, index, array, start, count, type);
        const char* name = element->GetAttribute("Name");
        vtkDataArray* offsets = vtkDataArray::SafeDownCast(array);
        if (read != 0 && offsets != nullptr && offsets->GetNumberOfTuples() > 0 && name != nullptr &&
            std::string_view(name) == "offsets" &&
            !possible(offsets->GetComponent(offsets->GetNumberOfTuples() - 1, 0), "the last of the offsets")) {
            return 0;
        }
        return read;
    }

  private:
    bool possible(double count, const std::string& what) {
        if (count >= 0.0 && count <= most_) {
            return true;
        }
        return complain(what + " is not possible in a file of this size");
    }

    bool complain(const std::string& what) {
        complaints_->add(what.c_str());
        return false;
    }

    /// Visits all elements of the file, and checks what VTK takes for granted: that counts are possible, and arrays
    /// have known types and, for points, cells and the file, unique names.
    bool check(vtkXMLDataElement& element) {
        complaints_->listen_to(&element);
        for (const char* name : {"NumberOfPoints", "NumberOfVerts", "NumberOfLines", "NumberOfStrips", "NumberOfPolys",
                                 "NumberOfTuples", "NumberOfComponents"}) {
            double count = 0.0;
            if (element.GetScalarAttribute(name, count) != 0 && !possible(count, name)) {
                return false;
            }
        }
        const std::string kind = element.GetName();
        const bool data = kind == "PointData" || kind == "CellData" || kind == "FieldData";
        const bool arrays =
            data || kind == "Points" || kind == "Verts" || kind == "Lines" || kind == "Strips" || kind == "Polys";
        std::set<std::string> names;
        std::vector<vtkXMLDataElement*> unwanted;
        for (int i = 0; i < element.GetNumberOfNestedElements(); ++i) {
            vtkXMLDataElement& nested = *element.GetNestedElement(i);
            const std::string nested_kind = nested.GetName();
            const bool array = nested_kind == "DataArray" || nested_kind == "Array";
            complaints_->listen_to(&nested);
            int type = 0;
            if (arrays != array) {
                return complain("it has " + nested_kind + " in " + kind);
            }
            if (nested_kind == "InformationKey") {
                const char* key = nested.GetAttribute("name");
                if (key == nullptr || std::string_view(key) != "UNITS_LABEL") {
                    unwanted.push_back(&nested); // of others VTK tells the terminal what is wrong with them
                }
                continue;
            }
            if (array && nested.GetWordTypeAttribute("type", type) == 0) {
                return complain("an array in " + kind + " is of unknown type");
            }
            if (array && type == VTK_STRING && kind != "FieldData") {
                unwanted.push_back(&nested); // not needed, and VTK crashes if one of them is too short
            }
            const char* name = nested.GetAttribute("Name");
            if (data && (name == nullptr || !names.insert(name).second)) {
                return complain("an array in " + kind + " has no unique name");
            }
            double components = 0.0;
            if (kind == "Points" &&
                (nested.GetScalarAttribute("NumberOfComponents", components) == 0 || components != 3.0)) {
                return complain("its points do not have three coordinates");
            }
            if (!check(nested)) {
                return false;
            }
        }
        for (vtkXMLDataElement* each : unwanted) {
            element.RemoveNestedElement(each);
        }
        return true;
    }

    /// What an array's header and data begin with.
    struct Encoded {
        std::string_view data;
        bool raw = false; ///< otherwise base64

        std::string first(std::size_t count) const {
            return raw ? std::string(data.substr(0, count)) : decode(data, count);
        }
    };

    /// The file after the first `mark` from a place on.
    std::string_view after(std::size_t from, char mark) const {
        const std::string_view content = content_;
        const std::size_t place = content.find(mark, std::min(from, content.size()));
        return content.substr(place == std::string_view::npos ? content.size() : place + 1);
    }

    /// The attribute `encoding` of an opening tag as it is written; base64 without one, as for VTK.
    static std::string_view encoding_of(std::string_view opening) {
        constexpr std::string_view blanks = " \t\r\n", name = "encoding";
        for (std::size_t at = opening.find(name); at != std::string_view::npos; at = opening.find(name, at + 1)) {
            std::string_view rest = opening.substr(at + name.size());
            rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
            if (blanks.find(opening[at - 1]) == std::string_view::npos || rest.empty() || rest.front() != '=') {
                continue;
            }
            rest.remove_prefix(1);
            rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
            if (rest.empty() || (rest.front() != '"' && rest.front() != '\'')) {
                return "";
            }
            const std::size_t close = rest.find(rest.front(), 1);
            return rest.substr(1, close == std::string_view::npos ? close : close - 1);
        }
        return "base64";
    }

    /// Nothing if it is not where the array says, which is complained about.
    std::optional<Encoded> encoded(vtkXMLDataElement& array) {
        if (std::string_view(array.GetAttribute("format")) != "appended") {
            return Encoded{after(static_cast<std::size_t>(array.GetXMLByteIndex()), '>'), false};
        }
        double offset = 0.0;
        if (array.GetScalarAttribute("offset", offset) == 0 || !possible(offset, "an offset")) {
            return std::nullopt;
        }
        const std::string_view content = content_;
        const std::size_t tag = content.find("<AppendedData"), end = content.find('>', tag);
        std::string_view data = after(end, '_');
        if (after(end, '>').find_first_not_of(" \t\r\n") != after(end, '>').size() - data.size() - 1) {
            complain("its appended data do not begin with '_'");
            return std::nullopt;
        }
        data.remove_prefix(std::min(static_cast<std::size_t>(offset), data.size()));
        const std::string_view encoding = tag < end ? encoding_of(content.substr(tag, end - tag)) : "";
        if (encoding != "raw" && encoding != "base64") {
            complain("its appended data are encoded neither as \"raw\" nor as \"base64\"");
            return std::nullopt;
        }
        return Encoded{data, encoding == "raw"};
    }

    static bool is_ascii(vtkXMLDataElement& array) {
        const char* format = array.GetAttribute("format");
        return format == nullptr || std::string_view(format) == "ascii";
    }

    /// The header of a compressed array: number of blocks, unpacked size of each but the last, and of the last; then
    /// their packed sizes. `count`: of the values that are read from it.
    bool check_blocks(vtkXMLDataElement& array, vtkIdType count) {
        if (is_ascii(array)) {
            return true;
        }
        const std::size_t size = wide_header_ ? 8 : 4;
        const std::optional<Encoded> data = encoded(array);
        if (!data) {
            return false;
        }
        std::string bytes = data->first(size);
        if (bytes.size() < size) {
            return complain("an array has no data");
        }
        const double blocks = number(bytes, 0, size);
        if (!possible(1032.0 * blocks, "the size of a compressed array")) {
            return false;
        }
        bytes = data->first(size * (3 + static_cast<std::size_t>(blocks)));
        if (blocks > 0.0 && bytes.size() < size * (3 + static_cast<std::size_t>(blocks))) {
            return complain("the header of a compressed array is cut short"); // VTK makes up the rest
        }
        for (std::size_t entry = size; entry + size <= bytes.size(); entry += size) {
            const double packed = entry < 3 * size ? 1.0 : 1032.0; // bytes that each byte of it may unpack to
            if (!possible(packed * number(bytes, entry, size), "the size of a compressed array")) {
                return false;
            }
        }
        if (blocks == 0.0 && bytes.size() >= 3 * size && number(bytes, 2 * size, size) > 0.0) {
            return complain("a compressed array has a last block, but no blocks"); // which VTK reads all the same
        }
        const bool sized = bytes.size() >= 2 * size && number(bytes, size, size) > 0.0;
        if (!sized && (blocks > 0.0 || count > 0)) {
            return complain("the blocks of a compressed array have no size"); // VTK divides by it
        }
        return true;
    }

    /// VTK writes as many texts as it finds, however many the array says it has: makes room for one in each byte.
    bool make_room(vtkXMLDataElement& element, vtkStringArray& texts) {
        double bytes = 0.0;
        if (is_ascii(element)) {
            const std::string_view data = after(static_cast<std::size_t>(element.GetXMLByteIndex()), '>');
            bytes = static_cast<double>(std::min(data.find('<'), data.size()));
        } else {
            const std::size_t size = wide_header_ ? 8 : 4;
            const std::optional<Encoded> data = encoded(element);
            if (!data) {
                return false;
            }
            const bool packed = XMLParser->GetCompressor() != nullptr;
            const std::string header = data->first(packed ? 3 * size : size);
            if (header.size() < (packed ? 3 * size : size)) {
                return complain("a text has no data");
            }
            bytes = number(header, 0, size);
            if (packed) { // blocks of equal size; the size of the last is 0 if it is as long as the others
                const double block = number(header, size, size), last = number(header, 2 * size, size);
                bytes = std::max(last > 0.0 ? bytes - 1.0 : bytes, 0.0) * block + last;
            }
        }
        constexpr double most = 4e6; // of all texts: VTK takes time for each byte
        text_bytes_ += bytes;
        if (!(text_bytes_ <= most)) {
            return complain("it has more than 4 MB of text");
        }
        texts.Resize(texts.GetNumberOfValues() + static_cast<vtkIdType>(bytes) + 1);
        return true;
    }

    /// The whole number of `size` bytes at `place`.
    double number(const std::string& bytes, std::size_t place, std::size_t size) const {
        double value = 0.0;
        for (std::size_t k = 0; k < size; ++k) {
            const char byte = bytes[place + (big_endian_ ? k : size - 1 - k)];
            value = 256.0 * value + static_cast<double>(static_cast<unsigned char>(byte));
        }
        return value;
    }

    Complaints* complaints_ = nullptr;
    std::string content_;
    double most_ = 0.0;
    bool wide_header_ = false, big_endian_ = false;
    double text_bytes_ = 0.0; ///< of all arrays of text so far
};
vtkStandardNewMacro(QuietReader);

/// Numbers as stored: bytes, 32-bit numbers, or doubles. `row[i]`: the tuple that is row i of the result.
FieldArray convert(vtkDataArray& array, const std::vector<std::size_t>& row) {
    FieldArray field;
    field.name = array.GetName() == nullptr ? "" : array.GetName();
    const int columns = array.GetNumberOfComponents();
    for (int c = 0; c < columns; ++c) {
        const char* name = array.GetComponentName(c);
        if (name != nullptr || columns > 1) {
            field.components.push_back(name != nullptr ? std::string(name) : std::to_string(c));
        }
    }
    if (array.HasInformation() && array.GetInformation()->Has(vtkDataArray::UNITS_LABEL()) != 0) {
        field.unit = array.GetInformation()->Get(vtkDataArray::UNITS_LABEL());
    }
    Values values(static_cast<Eigen::Index>(row.size()), columns);
    for (std::size_t i = 0; i < row.size(); ++i) {
        for (int c = 0; c < columns; ++c) {
            values(static_cast<Eigen::Index>(i), c) = array.GetComponent(static_cast<vtkIdType>(row[i]), c);
        }
    }
    const int type = array.GetDataType();
    const auto fits = [&](double least, double most) {
        return values.size() == 0 || (values.minCoeff() >= least && values.maxCoeff() <= most);
    };
    if (type == VTK_UNSIGNED_CHAR) {
        field.data = std::vector<std::uint8_t>(values.data(), values.data() + values.size());
    } else if (type != VTK_FLOAT && type != VTK_DOUBLE &&
               fits(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max())) {
        field.data = std::vector<std::int32_t>(values.data(), values.data() + values.size());
    } else {
        field.data = std::move(values);
    }
    return field;
}

/// All numeric arrays except `left_out`.
std::vector<FieldArray> convert(vtkFieldData& data, const std::vector<std::size_t>& row, const vtkDataArray* left_out) {
    std::vector<FieldArray> fields;
    for (int a = 0; a < data.GetNumberOfArrays(); ++a) {
        vtkDataArray* array = data.GetArray(a); // null for text
        if (array != nullptr && array != left_out && array->GetNumberOfComponents() > 0) {
            fields.push_back(convert(*array, row));
        }
    }
    return fields;
}

std::vector<FieldNote> notes_of(vtkFieldData& data) {
    std::vector<FieldNote> notes;
    for (int a = 0; a < data.GetNumberOfArrays(); ++a) {
        vtkAbstractArray* array = data.GetAbstractArray(a);
        FieldNote note;
        note.name = array->GetName() == nullptr ? "" : array->GetName();
        if (vtkStringArray* texts = vtkStringArray::SafeDownCast(array)) {
            std::string text;
            for (vtkIdType i = 0; i < texts->GetNumberOfValues(); ++i) {
                text += (i == 0 ? "" : "\n") + texts->GetValue(i);
            }
            note.value = text;
        } else if (vtkDataArray* numbers = vtkDataArray::SafeDownCast(array)) {
            std::vector<double> values;
            for (vtkIdType i = 0; i < numbers->GetNumberOfValues(); ++i) {
                const int columns = numbers->GetNumberOfComponents();
                values.push_back(numbers->GetComponent(i / columns, static_cast<int>(i % columns)));
            }
            note.value = std::move(values);
        } else {
            continue;
        }
        notes.push_back(std::move(note));
    }
    return notes;
}

std::vector<Vec3> vectors(vtkDataArray& array) {
    std::vector<Vec3> result(static_cast<std::size_t>(array.GetNumberOfTuples()));
    for (std::size_t i = 0; i < result.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            result[i][c] = array.GetComponent(static_cast<vtkIdType>(i), c);
        }
    }
    return result;
}

/// Passes the corners of each cell to `take`. VTK only checks that offsets do not decrease.
template <class Take> void for_each_cell(vtkCellArray& cells, const std::string& file, Take take) {
    const vtkIdType count = cells.GetNumberOfCells(), corners = cells.GetNumberOfConnectivityIds();
    const auto offset = [&](vtkIdType i) {
        return static_cast<vtkIdType>(cells.GetOffsetsArray()->GetComponent(i, 0));
    };
    if (count > 0 && (offset(0) != 0 || offset(count) != corners)) {
        throw InputError(file + ": the offsets of its cells do not fit their connectivity: the file is damaged; write "
                                "it again");
    }
    std::vector<std::int64_t> corner;
    for (vtkIdType i = 0; i < count; ++i) {
        vtkIdType size = 0;
        const vtkIdType* points = nullptr;
        cells.GetCellAtId(i, size, points);
        corner.assign(points, points + size);
        take(std::span<const std::int64_t>(corner), static_cast<std::size_t>(i));
    }
}

/// True if cell i is the point i, for all points.
bool one_vertex_a_point(vtkPolyData& mesh, const std::string& file) {
    bool same = mesh.GetNumberOfVerts() == mesh.GetNumberOfPoints() && mesh.GetNumberOfLines() == 0;
    for_each_cell(*mesh.GetVerts(), file, [&](std::span<const std::int64_t> corners, std::size_t cell) {
        same = same && corners.size() == 1 && static_cast<std::size_t>(corners[0]) == cell;
    });
    return same;
}

FieldFile convert(vtkPolyData& mesh, const std::string& file) {
    FieldFile field;
    if (mesh.GetNumberOfPoints() >= static_cast<vtkIdType>(none)) {
        throw ResourceError(file + ": has " + std::to_string(mesh.GetNumberOfPoints()) + " points, but difusa counts " +
                            "them with 32 bits: split the surface");
    }
    const auto count = static_cast<std::size_t>(mesh.GetNumberOfPoints());
    if (count > 0) {
        field.points = vectors(*mesh.GetPoints()->GetData());
        check_coordinates(field, file);
    }
    // Cells are numbered in the order vertices, lines, polygons, strips.
    Triangles triangles(field, file);
    const auto before = static_cast<std::size_t>(mesh.GetNumberOfVerts() + mesh.GetNumberOfLines());
    const auto polygons = static_cast<std::size_t>(mesh.GetNumberOfPolys());
    for_each_cell(*mesh.GetPolys(), file, [&](std::span<const std::int64_t> corners, std::size_t cell) {
        triangles.add_polygon(corners, before + cell);
    });
    for_each_cell(*mesh.GetStrips(), file, [&](std::span<const std::int64_t> corners, std::size_t cell) {
        triangles.add_strip(corners, before + polygons + cell);
    });

    vtkPointData& points = *mesh.GetPointData();
    vtkDataArray* normals = points.GetNormals() != nullptr ? points.GetNormals() : points.GetArray("Normals");
    if (normals != nullptr && (normals->GetNumberOfComponents() != 3 ||
                               (normals->GetDataType() != VTK_FLOAT && normals->GetDataType() != VTK_DOUBLE))) {
        normals = nullptr;
    }
    if (normals != nullptr) {
        field.normals = vectors(*normals);
    }
    std::vector<std::size_t> row(count);
    std::iota(row.begin(), row.end(), std::size_t{0});
    field.point_arrays = convert(points, row, normals);
    if (!field.triangles.empty()) {
        field.cell_arrays = convert(*mesh.GetCellData(), triangles.cells(), nullptr);
    } else if (one_vertex_a_point(mesh, file)) {
        field.cell_arrays = convert(*mesh.GetCellData(), row, nullptr);
    }
    vtkDataArray* colours = points.GetScalars();
    if (colours != nullptr && colours->GetName() != nullptr && colours->GetNumberOfComponents() == 3 &&
        colours->GetDataType() == VTK_UNSIGNED_CHAR) {
        field.active_colours = colours->GetName();
    }
    field.notes = notes_of(*mesh.GetFieldData());
    return field;
}

} // namespace

FieldFile read_vtp(const std::filesystem::path& file) {
    const std::string name = file.string();
    Complaints complaints;
    try {
        vtkNew<QuietReader> reader;
        reader->set(complaints, file);
        without_vtk_threads([&] { reader->Update(); });
        if (complaints.first().empty() && reader->GetErrorCode() != 0) {
            complaints.add("unexplained error");
        }
        if (!complaints.first().empty()) {
            throw InputError(name + ": is not a complete VTK XML PolyData file (" + complaints.first() +
                             "): if it is truncated or damaged write it again; another format needs its own extension");
        }
        return convert(*reader->GetOutput(), name);
    } catch (const std::bad_alloc&) {
        throw ResourceError(name + ": does not fit into memory, or its counts are damaged: write it again, or use a "
                                   "machine with more memory");
    }
}

} // namespace difusa
