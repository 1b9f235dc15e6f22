#include "xdmf.hpp"

#include <fmt/format.h>

namespace perimpm::hdf5 {
namespace {

const char* attribute_type(std::uint64_t components) {
    switch (components) {
        case 1:
            return "Scalar";
        case 3:
            return "Vector";
        case 6:
            return "Tensor6";
        case 9:
            return "Tensor";
        default:
            return "Matrix";
    }
}

std::string data_item(const FrameInfo& frame, const FrameInfo::Field& field) {
    std::string shape = std::to_string(frame.rows);
    if (field.components == 9)
        shape += " 3 3";
    else if (field.components > 1)
        shape += fmt::format(" {}", field.components);
    return fmt::format(R"(<DataItem Dimensions="{}" NumberType="{}" Precision="{}" Format="HDF">{}:/{}</DataItem>)",
                       shape, field.type, field.bytes, frame.file, field.name);
}

std::string field_text(const FrameInfo& frame, const FrameInfo::Field& field) {
    const std::string item = data_item(frame, field);
    if (field.name == "x") return fmt::format("        <Geometry GeometryType=\"XYZ\">{}</Geometry>\n", item);
    if (field.name == "connectivity")
        return fmt::format(
            R"(        <Topology TopologyType="Polyvertex" NodesPerElement="1" NumberOfElements="{}">{}</Topology>
)",
            frame.rows, item);
    return fmt::format(R"(        <Attribute Name="{}" AttributeType="{}" Center="Node">{}</Attribute>
)",
                       field.name, attribute_type(field.components), item);
}

std::string frame_text(const FrameInfo& frame) {
    std::string text = fmt::format(R"(      <Grid Name="{}" GridType="Uniform">
        <Time Value="{}"/>
)",
                                   frame.file, frame.time);
    for (const FrameInfo::Field& field : frame.fields) text += field_text(frame, field);
    return text + "      </Grid>\n";
}

}  // namespace

std::string xdmf_text(const std::vector<FrameInfo>& frames) {
    std::string text = R"(<?xml version="1.0" ?>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="particles" GridType="Collection" CollectionType="Temporal">
)";
    for (const FrameInfo& frame : frames) text += frame_text(frame);
    return text + "    </Grid>\n  </Domain>\n</Xdmf>\n";
}

}  // namespace perimpm::hdf5
