// Inline binary (base64 and zlib) rather than VTK's default of raw appended data: current versions of expat refuse to
// parse beyond the point where that begins.
#include <difusa/io/field_writers.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/io/vtk_threads.h>

#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkZLibDataCompressor.h>

#include <algorithm>
#include <exception>
#include <ostream>
#include <span>
#include <streambuf>
#include <unordered_map>
#include <utility>
#include <vector>

namespace difusa {

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double), "vectors are passed to VTK as stored in memory");

/// A VTK array over memory that we own and that outlives it. VTK only reads it, but cannot express that. It writes
/// names into XML attributes as they are.
template <typename Array, typename T>
vtkSmartPointer<Array> view(const std::string& name, const T* values, std::size_t count, int components) {
    const auto array = vtkSmartPointer<Array>::New();
    array->SetName(xml_attribute(name).c_str());
    array->SetNumberOfComponents(components);
    array->SetArray(const_cast<T*>(values), static_cast<vtkIdType>(count), 1);
    return array;
}

vtkSmartPointer<vtkDoubleArray> view(const std::string& name, const std::vector<Vec3>& vectors) {
    return view<vtkDoubleArray>(name, vectors.empty() ? nullptr : vectors.front().data(), 3 * vectors.size(), 3);
}

vtkSmartPointer<vtkDataArray> view(const FieldArray& field) {
    struct Visitor {
        const std::string& name;
        int components;
        vtkSmartPointer<vtkDataArray> operator()(const Values& data) const {
            return view<vtkDoubleArray>(name, data.data(), static_cast<std::size_t>(data.size()), components);
        }
        vtkSmartPointer<vtkDataArray> operator()(const ValuesView& data) const { return (*this)(data.get()); }
        vtkSmartPointer<vtkDataArray> operator()(const std::vector<std::uint8_t>& data) const {
            return view<vtkUnsignedCharArray>(name, data.data(), data.size(), components);
        }
        vtkSmartPointer<vtkDataArray> operator()(const std::vector<std::int32_t>& data) const {
            return view<vtkIntArray>(name, data.data(), data.size(), components);
        }
    };
    const auto components = static_cast<int>(field.components.size());
    const auto array = std::visit(Visitor{field.name, std::max(1, components)}, field.data);
    for (int c = 0; c < components; ++c) {
        array->SetComponentName(c, xml_attribute(field.components[static_cast<std::size_t>(c)]).c_str());
    }
    if (!field.unit.empty()) {
        array->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), field.unit.c_str());
    }
    return array;
}

/// `count` cells of `size` points each; `point(i)` is the i-th of all their corners.
template <typename Point> vtkSmartPointer<vtkCellArray> make_cells(std::size_t count, std::size_t size, Point point) {
    vtkNew<vtkTypeInt64Array> offsets, corners;
    offsets->SetNumberOfValues(static_cast<vtkIdType>(count + 1));
    corners->SetNumberOfValues(static_cast<vtkIdType>(count * size));
    for (std::size_t i = 0; i <= count; ++i) {
        offsets->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt64>(i * size));
    }
    for (std::size_t i = 0; i < count * size; ++i) {
        corners->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt64>(point(i)));
    }
    const auto cells = vtkSmartPointer<vtkCellArray>::New();
    cells->SetData(offsets, corners);
    return cells;
}

void add_note(vtkFieldData* data, const FieldNote& note) {
    if (const std::string* text = std::get_if<std::string>(&note.value)) {
        vtkNew<vtkStringArray> array;
        array->SetName(xml_attribute(note.name).c_str());
        array->InsertNextValue(*text);
        data->AddArray(array);
    } else {
        const auto& numbers = std::get<std::vector<double>>(note.value);
        data->AddArray(view<vtkDoubleArray>(note.name, numbers.data(), numbers.size(), 1));
    }
}

vtkSmartPointer<vtkPolyData> make_poly_data(const FieldFile& field) {
    const auto mesh = vtkSmartPointer<vtkPolyData>::New();
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetData(view("Points", field.points));
    mesh->SetPoints(points);
    if (field.triangles.empty()) {
        mesh->SetVerts(make_cells(field.points.size(), 1, [](std::size_t i) { return i; }));
    } else {
        const auto corner = [&](std::size_t i) { return field.triangles[i / 3][i % 3]; };
        mesh->SetPolys(make_cells(field.triangles.size(), 3, corner));
    }
    if (!field.normals.empty()) {
        mesh->GetPointData()->SetNormals(view("Normals", field.normals));
    }
    for (const FieldArray& array : field.point_arrays) {
        mesh->GetPointData()->AddArray(view(array));
    }
    for (const FieldArray& array : field.cell_arrays) {
        mesh->GetCellData()->AddArray(view(array));
    }
    if (!field.active_colours.empty()) {
        mesh->GetPointData()->SetActiveScalars(xml_attribute(field.active_colours).c_str());
    }
    for (const FieldNote& note : field.notes) {
        add_note(mesh->GetFieldData(), note);
    }
    return mesh;
}

/// Passes VTK's bytes to the file. VTK does not survive every failure of a stream (on a disk that is full from the
/// start it ends the process), so failures are hidden from it: the first is kept and thrown by `finish`.
class FileBuffer : public std::streambuf {
  public:
    explicit FileBuffer(WholeFile& file) : file_(file) { setp(buffer_.data(), buffer_.data() + buffer_.size()); }

    void finish() {
        drain();
        if (failure_) {
            std::rethrow_exception(failure_);
        }
    }

  protected:
    int_type overflow(int_type c) override {
        drain();
        return traits_type::eq_int_type(c, traits_type::eof()) ? traits_type::not_eof(c)
                                                               : sputc(traits_type::to_char_type(c));
    }

    /// VTK seeks back to each array's table of compressed sizes once it knows them.
    pos_type seekoff(off_type offset, std::ios_base::seekdir direction, std::ios_base::openmode mode) override {
        const off_type here = start_ + (pptr() - pbase());
        if (direction == std::ios_base::end) {
            return pos_type(off_type(-1));
        }
        return seekpos(direction == std::ios_base::beg ? offset : here + offset, mode);
    }
    pos_type seekpos(pos_type position, std::ios_base::openmode) override {
        if (position != start_ + (pptr() - pbase())) {
            drain();
            start_ = position;
        }
        return position;
    }

  private:
    void drain() {
        const auto count = pptr() - pbase();
        try {
            if (!failure_ && count > 0) {
                file_.seek(start_);
                file_.write({pbase(), static_cast<std::size_t>(count)});
            }
        } catch (...) {
            failure_ = std::current_exception();
        }
        start_ += count;
        setp(buffer_.data(), buffer_.data() + buffer_.size());
    }

    WholeFile& file_;
    std::vector<char> buffer_ = std::vector<char>(std::size_t{1} << 20);
    off_type start_ = 0; ///< file position of the start of the buffer
    std::exception_ptr failure_;
};

/// VTK's writer with our own stream instead of a file name.
class StreamWriter : public vtkXMLPolyDataWriter {
  public:
    static StreamWriter* New();
    void set_stream(std::ostream* stream) { this->Stream = stream; }
    vtkTypeMacro(StreamWriter, vtkXMLPolyDataWriter)
};
vtkStandardNewMacro(StreamWriter);

/// VTK's compressor, except that for arrays whose memory is known it also compresses the next blocks, in parallel. VTK
/// requests one block after another; the bytes are the same.
class AheadCompressor : public vtkZLibDataCompressor {
  public:
    static AheadCompressor* New();

    void set_execution(const Execution& execution) { execution_ = execution.silent(); }

    /// Memory that VTK will ask to compress, from its begin to its end.
    void expect(vtkDataArray* array) {
        const auto* begin = static_cast<const unsigned char*>(array->GetVoidPointer(0));
        const vtkIdType bytes = array->GetNumberOfValues() * array->GetDataTypeSize();
        arrays_.emplace_back(begin, static_cast<std::size_t>(bytes));
    }

  protected:
    std::size_t CompressBuffer(const unsigned char* data, std::size_t size, unsigned char* compressed,
                               std::size_t space) override {
        auto ready = ahead_.find(data);
        if (ready == ahead_.end() || ready->second.size != size) {
            compress_from(data, size);
            ready = ahead_.find(data);
        }
        if (ready == ahead_.end() || ready->second.compressed.size() > space) {
            return vtkZLibDataCompressor::CompressBuffer(data, size, compressed, space);
        }
        const std::vector<unsigned char>& bytes = ready->second.compressed;
        std::copy(bytes.begin(), bytes.end(), compressed);
        return bytes.size();
    }

  private:
    struct Block {
        const unsigned char* data;
        std::size_t size;
        std::vector<unsigned char> compressed;
    };

    /// The block and those following it in the array.
    void compress_from(const unsigned char* data, std::size_t size) {
        constexpr std::size_t most = 256;
        ahead_.clear();
        std::vector<Block> blocks;
        for (const auto& array : arrays_) {
            if (array.data() <= data && data + size <= array.data() + array.size()) {
                auto left = static_cast<std::size_t>(array.data() + array.size() - data);
                for (; left > 0 && blocks.size() < most; data += size) {
                    size = std::min(size, left);
                    blocks.push_back({data, size, {}});
                    left -= size;
                }
                break;
            }
        }
        parallel_for(blocks.size(), 1, execution_, [&](std::size_t begin, std::size_t end, unsigned) {
            for (std::size_t i = begin; i < end; ++i) {
                std::vector<unsigned char>& to = blocks[i].compressed;
                to.resize(GetMaximumCompressionSpace(blocks[i].size));
                to.resize(vtkZLibDataCompressor::CompressBuffer(blocks[i].data, blocks[i].size, to.data(), to.size()));
            }
        });
        for (Block& block : blocks) {
            if (!block.compressed.empty()) { // otherwise VTK should fail when it asks
                ahead_.emplace(block.data, std::move(block));
            }
        }
    }

    Execution execution_;
    std::vector<std::span<const unsigned char>> arrays_;
    std::unordered_map<const unsigned char*, Block> ahead_; ///< already compressed
};
vtkStandardNewMacro(AheadCompressor);

/// Captures VTK's error messages, which would otherwise go to the terminal.
void keep_message(vtkObject*, unsigned long, void* messages, void* text) {
    *static_cast<std::string*>(messages) += static_cast<const char*>(text);
}

} // namespace

void write_vtp(const FieldFile& field, WholeFile& file, const Execution& execution) {
    std::string complaints;
    vtkNew<vtkCallbackCommand> keep;
    keep->SetCallback(keep_message);
    keep->SetClientData(&complaints);

    FileBuffer buffer(file);
    std::ostream stream(&buffer);
    vtkNew<StreamWriter> writer;
    for (vtkObject* source : {static_cast<vtkObject*>(writer), static_cast<vtkObject*>(writer->GetExecutive())}) {
        source->AddObserver(vtkCommand::ErrorEvent, keep);
        source->AddObserver(vtkCommand::WarningEvent, keep);
    }
    const vtkSmartPointer<vtkPolyData> mesh = make_poly_data(field);
    vtkNew<AheadCompressor> compressor;
    compressor->set_execution(execution);
    compressor->expect(mesh->GetPoints()->GetData());
    for (vtkDataSetAttributes* data : {static_cast<vtkDataSetAttributes*>(mesh->GetPointData()),
                                       static_cast<vtkDataSetAttributes*>(mesh->GetCellData())}) {
        for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
            compressor->expect(data->GetArray(i));
        }
    }
    writer->SetInputData(mesh);
    writer->SetDataModeToBinary();
    writer->SetCompressor(compressor);
    writer->SetCompressionLevel(2); // four times as fast as VTK's 5, and 7 % larger
    writer->set_stream(&stream);
    int written = 0;
    without_vtk_threads([&] { written = writer->Write(); });
    buffer.finish();
    DIFUSA_REQUIRE(written == 1 && stream.good(), complaints);
}

} // namespace difusa
