#include <algorithm>
#include <cmath>

#include "perimpm/error.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

template <class Real>
constexpr NumberType kType = std::is_same_v<Real, float> ? NumberType::float32 : NumberType::float64;

/// Name, unit, meaning and source of a field.
struct Label {
    std::string name, unit, doc, source = "core";
};

template <class Real>
FieldView view(Label l, Field<Real> f, std::size_t first, std::size_t size, std::size_t components,
               std::size_t entry = 1) {
    return {std::move(l.name),
            std::move(l.unit),
            std::move(l.doc),
            std::move(l.source),
            f.data + first * entry,
            size,
            components,
            f.stride,
            entry,
            kType<Real>};
}

FieldView view(Label l, std::uint32_t* data, std::size_t size) {
    return {std::move(l.name),
            std::move(l.unit),
            std::move(l.doc),
            std::move(l.source),
            data,
            size,
            1,
            0,
            1,
            NumberType::uint32,
            false};
}

/// Fields of all particles, or of the range of one material.
template <class Real>
void add_common(World<Real>& w, std::size_t first, std::size_t size, std::vector<FieldView>& out) {
    out.push_back(view({"x", "m", "position"}, w.x.view(), first, size, 3));
    out.push_back(view({"v", "m/s", "velocity"}, w.v.view(), first, size, 3));
    if (!w.C.empty())
        out.push_back(
            view({"C", "1/s", "affine velocity of the transfer, row-major; with linear splines times D / dx^2",
                  w.scene.transfer.type},
                 w.C.view(), first, size, 9));
    out.push_back(view({"mass", "kg", "mass"}, Field<Real>{w.mass.data(), 0}, first, size, 1));
    out.push_back(view({"volume", "m^3", "reference volume"}, Field<Real>{w.volume.data(), 0}, first, size, 1));
    out.push_back(view({"id", "1", "number of the particle, the same for the whole run"}, w.id.data() + first, size));
}

template <class Real>
void add_own(Material<Real>& m, std::vector<FieldView>& out) {
    if (!m.F.empty()) out.push_back(view({"F", "1", "deformation gradient, row-major"}, m.F.view(), 0, m.size, 9));
    if (!m.stress.empty())
        out.push_back(
            view({"stress", "Pa", "Kirchhoff stress: xx xy xz yy yz zz", m.law_name}, m.stress.view(), 0, m.size, 6));
    if (!m.force.empty())
        out.push_back(view({"force", "N", "internal force", m.law_name}, m.force.view(), 0, m.size, 3));
    for (StateField<Real>& s : m.particle_state)
        out.push_back(view({s.spec.name, s.spec.unit, s.spec.doc, m.law_name}, s.values.view(), 0, m.size,
                           s.spec.components, s.values.entry()));
    for (auto& [spec, values] : m.varying)
        if (!values.empty())
            out.push_back(
                view({spec->key, spec->unit, spec->doc, m.law_name}, Field<Real>{values.data(), 0}, 0, m.size, 1));
    if (!m.can_break()) return;
    const std::string source = m.criterion ? m.criterion_name : "core";
    out.push_back(view({"broken_bonds", "1", "number of broken bonds", source}, m.bonds.damage.data(), m.size));
    out.push_back({"damage", "1", "broken bonds over bonds at the start", source, m.bonds.share.data(), m.size, 1, 0, 1,
                   NumberType::float32, false});
}

/// Rows of a frame field in order of ids; particles without the field keep the fill value.
template <class T>
void place_rows(FrameField& f, const std::uint32_t* id, const FieldView& v) {
    auto* out = reinterpret_cast<T*>(f.data.data());
    const auto* in = static_cast<const T*>(v.data);
    for (std::size_t p = 0; p < v.size; ++p)
        for (std::size_t c = 0; c < v.components; ++c) out[id[p] * v.components + c] = in[c * v.stride + p * v.entry];
}

void place(FrameField& f, const std::uint32_t* id, const FieldView& v) {
    if (f.source.find(v.source) == std::string::npos) f.source += ", " + v.source;
    if (v.type == NumberType::float32)
        place_rows<float>(f, id, v);
    else if (v.type == NumberType::float64)
        place_rows<double>(f, id, v);
    else
        place_rows<std::uint32_t>(f, id, v);
}

FrameField empty_field(const FieldView& v, std::size_t rows) {
    return {v.name,
            v.unit,
            v.source,
            static_cast<std::uint32_t>(v.components),
            v.type,
            std::vector<std::byte>(rows * v.components * bytes_of(v.type),
                                   std::byte{0xff})};  // all ones: NaN in both precisions, 2^32 - 1 in integers
}

bool is_of_breaking(const std::string& name) {
    return name == "damage" || name == "broken_bonds" || name == "fragment";
}

/// "body" exists only in frames: which body each particle belongs to.
template <class Real>
FrameField body_field(const World<Real>& w) {
    FrameField f{"body", "1", "core", 1, NumberType::uint32, std::vector<std::byte>(4 * w.count)};
    auto* out = reinterpret_cast<std::uint32_t*>(f.data.data());
    for (std::uint32_t b = 0; b + 1 < w.body_begin.size(); ++b)
        std::fill(out + w.body_begin[b], out + w.body_begin[b + 1], b);
    return f;
}

/// "fragment" likewise: which piece each particle belongs to, by the least id in it. What no bonds hold together is not
/// told apart: a body of a local law is one piece.
template <class Real>
FrameField fragment_field(const World<Real>& w) {
    FrameField f{"fragment", "1", "core", 1, NumberType::uint32, std::vector<std::byte>(4 * w.count)};
    const std::vector<std::uint32_t> label = label_fragments(w);
    auto* out = reinterpret_cast<std::uint32_t*>(f.data.data());
    for (std::size_t p = 0; p < w.count; ++p) out[w.id[p]] = label[p];
    return f;
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

/// Every name that output.fields may hold in this scene, once.
template <class Real>
std::vector<std::string> list_frame_fields(World<Real>& w) {
    std::vector<std::string> names{"body", "fragment"};
    for (Material<Real>& m : w.materials)
        for (const FieldView& v : list_fields(w, m.name)) names.push_back(v.name);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

/// Where the scene asks for the field in its frames; the scene as a whole where it does not say.
std::string place_of_output(const Scene& scene, const std::string& field) {
    const Value* output = scene.source.find("output");
    const Value* fields = output ? output->find("fields") : nullptr;
    if (fields && fields->is_list())
        for (const Value& name : std::get<Value::List>(fields->data))
            if (const auto* text = std::get_if<std::string>(&name.data); text && *text == field)
                return name.place.text();
    return scene.source.place.text();
}

template <class Real>
Frame make_frame(World<Real>& w, std::uint32_t number, const std::vector<std::string>& names) {
    Frame frame{number, w.time, w.steps, w.count, {}};
    for (const std::string& name : names) {
        if (name == "body") {
            frame.fields.push_back(body_field(w));
            continue;
        }
        if (name == "fragment") {
            frame.fields.push_back(fragment_field(w));
            continue;
        }
        FrameField* field = nullptr;
        for (Material<Real>& m : w.materials)
            for (const FieldView& v : list_fields(w, m.name)) {
                if (v.name != name) continue;
                if (!field) field = &frame.fields.emplace_back(empty_field(v, w.count));
                if (field->components != v.components)
                    throw InputError(place_of_output(w.scene, name),
                                     "output.fields: '" + name + "' has different shapes in different materials");
                place(*field, w.id.data() + m.begin, v);
            }
        if (!field)
            throw InputError(place_of_output(w.scene, name),
                             "output.fields: no field '" + name + "' in this scene" +
                                 (is_of_breaking(name) ? ", in which nothing can break: give a material a fracture "
                                                         "criterion, or the scene a crack"
                                                       : "") +
                                 "\n  " + suggestion(name, list_frame_fields(w)));
    }
    return frame;
}

template std::vector<FieldView> list_fields(World<float>&, const std::string&);
template std::vector<FieldView> list_fields(World<double>&, const std::string&);
template std::vector<std::string> list_frame_fields(World<float>&);
template std::vector<std::string> list_frame_fields(World<double>&);
template Frame make_frame(World<float>&, std::uint32_t, const std::vector<std::string>&);
template Frame make_frame(World<double>&, std::uint32_t, const std::vector<std::string>&);

}  // namespace perimpm
