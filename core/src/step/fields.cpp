#include <algorithm>
#include <cmath>

#include "perimpm/error.hpp"
#include "step/world.hpp"

namespace perimpm {

namespace {

template <class Real>
constexpr FieldView::Type kType = std::is_same_v<Real, float> ? FieldView::Type::float32 : FieldView::Type::float64;

template <class Real>
FieldView view(std::string name, std::string unit, std::string doc, Field<Real> f, std::size_t first, std::size_t size,
               std::size_t components) {
    return {std::move(name), std::move(unit), std::move(doc), f.data + first, size, components, f.stride, kType<Real>};
}

/// Fields of all particles, or of the range of one material.
template <class Real>
void add_common(World<Real>& w, std::size_t first, std::size_t size, std::vector<FieldView>& out) {
    out.push_back(view("x", "m", "position", w.x.view(), first, size, 3));
    out.push_back(view("v", "m/s", "velocity", w.v.view(), first, size, 3));
    if (!w.C.empty())
        out.push_back(view("C", "1/s", "affine velocity of the transfer, row-major", w.C.view(), first, size, 9));
    out.push_back(view("mass", "kg", "mass", Field<Real>{w.mass.data(), 0}, first, size, 1));
    out.push_back(view("volume", "m^3", "reference volume", Field<Real>{w.volume.data(), 0}, first, size, 1));
    out.push_back({"id", "1", "number of the particle, the same for the whole run", w.id.data() + first, size, 1, 0,
                   FieldView::Type::uint32});
}

template <class Real>
void add_own(Material<Real>& m, std::vector<FieldView>& out) {
    if (!m.F.empty()) out.push_back(view("F", "1", "deformation gradient, row-major", m.F.view(), 0, m.size, 9));
    if (!m.force.empty()) out.push_back(view("force", "N", "internal force", m.force.view(), 0, m.size, 3));
    for (StateField<Real>& s : m.particle_state)
        out.push_back(view(s.spec.name, s.spec.unit, s.spec.doc, s.values.view(), 0, m.size, s.spec.components));
    for (auto& [spec, values] : m.varying)
        if (!values.empty())
            out.push_back(view(spec->key, spec->unit, spec->doc, Field<Real>{values.data(), 0}, 0, m.size, 1));
    if (!m.bonds.damage.empty())
        out.push_back({"broken_bonds", "1", "number of broken bonds", m.bonds.damage.data(), m.size, 1, 0,
                       FieldView::Type::uint32});
}

/// Rows of a frame field in order of ids; particles without the field keep the fill value.
template <class T>
void place_rows(FrameField& f, const std::uint32_t* id, const FieldView& v) {
    auto* out = reinterpret_cast<T*>(f.data.data());
    const auto* in = static_cast<const T*>(v.data);
    for (std::size_t p = 0; p < v.size; ++p)
        for (std::size_t c = 0; c < v.components; ++c) out[id[p] * v.components + c] = in[c * v.stride + p];
}

void place(FrameField& f, const std::uint32_t* id, const FieldView& v) {
    if (v.type == FieldView::Type::float32)
        place_rows<float>(f, id, v);
    else if (v.type == FieldView::Type::float64)
        place_rows<double>(f, id, v);
    else
        place_rows<std::uint32_t>(f, id, v);
}

FrameField empty_field(const FieldView& v, std::string source, std::size_t rows) {
    FrameField f{v.name, v.unit, std::move(source), static_cast<std::uint32_t>(v.components), FrameField::Type::float32,
                 {}};
    f.type = v.type == FieldView::Type::float32   ? FrameField::Type::float32
             : v.type == FieldView::Type::float64 ? FrameField::Type::float64
                                                  : FrameField::Type::uint32;
    const std::size_t bytes = v.type == FieldView::Type::float64 ? 8 : 4;
    f.data.assign(rows * v.components * bytes,
                  std::byte{0xff});  // all ones: NaN in both precisions, 2^32 - 1 in integers
    return f;
}

/// "body" exists only in frames: which body each particle belongs to.
template <class Real>
FrameField body_field(const World<Real>& w) {
    FrameField f{"body", "1", "core", 1, FrameField::Type::uint32, std::vector<std::byte>(4 * w.count)};
    auto* out = reinterpret_cast<std::uint32_t*>(f.data.data());
    for (std::uint32_t b = 0; b + 1 < w.body_begin.size(); ++b)
        std::fill(out + w.body_begin[b], out + w.body_begin[b + 1], b);
    return f;
}

/// Every name that output.fields may hold in this scene, once.
template <class Real>
std::vector<std::string> frame_field_names(World<Real>& w) {
    std::vector<std::string> names{"body"};
    for (Material<Real>& m : w.materials)
        for (const FieldView& v : list_fields(w, m.name)) names.push_back(v.name);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

}  // namespace

template <class Real>
std::vector<FieldView> list_fields(World<Real>& w, const std::string& material) {
    std::vector<FieldView> out;
    std::vector<std::string> names;
    for (Material<Real>& m : w.materials) {
        names.push_back(m.name);
        if (material.empty() ? w.materials.size() > 1 : m.name != material) continue;
        add_common(w, m.begin, m.size, out);
        add_own(m, out);
        return out;
    }
    if (!material.empty())
        throw InputError("no material '" + material + "' has particles\n  " + suggestion(material, names));
    add_common(w, 0, w.count, out);
    return out;
}

template <class Real>
Frame make_frame(World<Real>& w, std::uint32_t number) {
    Frame frame{number, w.time, w.steps, w.count, {}};
    for (const std::string& name : w.scene.output.fields) {
        if (name == "body") {
            frame.fields.push_back(body_field(w));
            continue;
        }
        FrameField* field = nullptr;
        for (Material<Real>& m : w.materials)
            for (const FieldView& v : list_fields(w, m.name)) {
                if (v.name != name) continue;
                if (!field) field = &frame.fields.emplace_back(empty_field(v, m.law_name, w.count));
                if (field->components != v.components)
                    throw InputError("output.fields: '" + name + "' has different shapes in different materials");
                place(*field, w.id.data() + m.begin, v);
            }
        if (!field)
            throw InputError(w.scene.source.place.text(), "output.fields: no field '" + name + "' in this scene\n  " +
                                                              suggestion(name, frame_field_names(w)));
    }
    return frame;
}

template std::vector<FieldView> list_fields(World<float>&, const std::string&);
template std::vector<FieldView> list_fields(World<double>&, const std::string&);
template Frame make_frame(World<float>&, std::uint32_t);
template Frame make_frame(World<double>&, std::uint32_t);

}  // namespace perimpm
