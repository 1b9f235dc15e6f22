#include "frame_file.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numeric>

#include "handle.hpp"

namespace perimpm::hdf5 {
namespace {

constexpr hsize_t kChunkRows = 16384;
constexpr unsigned kDeflateLevel = 1;

/// One open file being written.
class File {
public:
    explicit File(const std::string& path)
        : path_{path},
          file_{H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, path, "create the file"} {}

    hid_t root() const { return file_; }
    void close() { file_.close(path_); }

    template <class T>
    void attribute(hid_t object, const char* name, T value, hid_t type) const {
        attribute_of_type(object, name, &value, type);
    }
    void attribute(hid_t object, const char* name, const std::string& text) const {
        const Handle type{H5Tcopy(H5T_C_S1), H5Tclose, path_, "make a text type"};
        check(H5Tset_size(type, H5T_VARIABLE), path_, "make a text type");
        check(H5Tset_cset(type, H5T_CSET_UTF8), path_, "make a text type");
        const char* pointer = text.c_str();
        attribute_of_type(object, name, &pointer, type);
    }

    /// Dataset of the given shape, compressed in chunks of whole rows.
    Handle dataset(const std::string& name, const std::vector<hsize_t>& shape, hid_t type, const void* data) const {
        const Handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose, path_,
                           "describe a dataset"};
        const Handle layout{H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path_, "describe a dataset"};
        check(H5Pset_obj_track_times(layout, false), path_, "leave out the time");  // the same run: the same file
        if (shape[0] > 0) compress(layout, shape);
        Handle set{H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose, path_,
                   "create a dataset"};
        if (shape[0] > 0) check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), path_, "write a dataset");
        return set;
    }

private:
    void compress(hid_t layout, std::vector<hsize_t> chunk) const {
        chunk[0] = std::min(chunk[0], kChunkRows);
        check(H5Pset_chunk(layout, static_cast<int>(chunk.size()), chunk.data()), path_, "set the chunks");
        check(H5Pset_shuffle(layout), path_, "set the shuffle filter");
        check(H5Pset_deflate(layout, kDeflateLevel), path_, "set the compression");
    }

    void attribute_of_type(hid_t object, const char* name, const void* value, hid_t type) const {
        const Handle space{H5Screate(H5S_SCALAR), H5Sclose, path_, "describe an attribute"};
        const Handle attribute{H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, path_,
                               "create an attribute"};
        check(H5Awrite(attribute, type, value), path_, "write an attribute");
    }

    std::string path_;
    Handle file_;
};

hid_t number_type(NumberType type) {
    switch (type) {
        case NumberType::float32:
            return H5T_NATIVE_FLOAT;
        case NumberType::float64:
            return H5T_NATIVE_DOUBLE;
        case NumberType::uint32:
            break;
    }
    return H5T_NATIVE_UINT32;
}

/// (n), (n, c), and (n, 3, 3) for tensors.
std::vector<hsize_t> shape_of(std::uint64_t rows, std::uint32_t components) {
    if (components == 1) return {rows};
    if (components == 9) return {rows, 3, 3};
    return {rows, components};
}

void write_head(const File& file, const Frame& frame) {
    file.attribute(file.root(), "time", frame.time, H5T_NATIVE_DOUBLE);
    file.attribute(file.root(), "step", frame.step, H5T_NATIVE_UINT64);
    file.attribute(file.root(), "frame", frame.number, H5T_NATIVE_UINT32);
    file.attribute(file.root(), "metersPerUnit", 1.0, H5T_NATIVE_DOUBLE);
    file.attribute(file.root(), "upAxis", "Y");
}

/// XDMF needs the trivial connectivity spelt out: ParaView makes no cells without it.
void write_connectivity(const File& file, std::uint64_t rows) {
    std::vector<std::uint32_t> index(rows);
    std::iota(index.begin(), index.end(), 0U);
    const Handle set = file.dataset("connectivity", {rows}, H5T_NATIVE_UINT32, index.data());
    file.attribute(set, "unit", "1");
    file.attribute(set, "source", "io");
}

void write_content(const std::string& path, const Frame& frame) {
    File file(path);
    write_head(file, frame);
    for (const FrameField& field : frame.fields) {
        const Handle set = file.dataset(field.name, shape_of(frame.rows, field.components), number_type(field.type),
                                        field.data.data());
        file.attribute(set, "unit", field.unit);
        file.attribute(set, "source", field.source);
    }
    write_connectivity(file, frame.rows);
    file.close();
}

FrameInfo::Field read_field_info(hid_t file, const std::string& name, const std::string& path, std::uint64_t& rows) {
    const Handle set{H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, path, "open a dataset"};
    const Handle space{H5Dget_space(set), H5Sclose, path, "read a dataset's shape"};
    const Handle type{H5Dget_type(set), H5Tclose, path, "read a dataset's type"};
    std::vector<hsize_t> shape(
        static_cast<std::size_t>(check(H5Sget_simple_extent_ndims(space), path, "read a shape")));
    H5Sget_simple_extent_dims(space, shape.data(), nullptr);
    rows = shape.at(0);
    const hsize_t components = std::accumulate(shape.begin() + 1, shape.end(), hsize_t{1}, std::multiplies<>());
    return {name, H5Tget_class(type) == H5T_FLOAT ? "Float" : "UInt", components, H5Tget_size(type)};
}

std::vector<std::string> dataset_names(hid_t file, const std::string& path) {
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->emplace_back(name);
        return 0;
    };
    check(H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names), path, "list the datasets");
    return names;
}

double read_time(hid_t file, const std::string& path) {
    const Handle attribute{H5Aopen(file, "time", H5P_DEFAULT), H5Aclose, path, "find the attribute 'time'"};
    double time = 0;
    check(H5Aread(attribute, H5T_NATIVE_DOUBLE, &time), path, "read the attribute 'time'");
    return time;
}

}  // namespace

void write_frame_file(const std::string& path, const Frame& frame) {
    const std::string aside = path + ".part";
    try {
        write_content(aside, frame);
        if (std::rename(aside.c_str(), path.c_str()) != 0) throw InputError(path, "cannot rename the finished file");
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(aside, ignored);
        throw;
    }
}

FrameInfo read_frame_info(const std::string& path) {
    const Handle file{H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, path, "open the file"};
    FrameInfo info{std::filesystem::path(path).filename().string(), read_time(file, path), 0, {}};
    for (const std::string& name : dataset_names(file, path))
        info.fields.push_back(read_field_info(file, name, path, info.rows));
    return info;
}

}  // namespace perimpm::hdf5
