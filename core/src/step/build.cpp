#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "perimpm/error.hpp"
#include "perimpm/math/bspline.hpp"
#include "state/morton.hpp"
#include "step/pieces.hpp"
#include "step/sampling.hpp"
#include "step/stages.hpp"

namespace perimpm {

namespace {

template <template <class> class Interface, class Real>
ModelPtr<Interface, Real> create_model(const ModelSpec& spec, const ModelContext& context) {
    const Reader& reader = *spec.params;
    try {
        return create<Interface, Real>(spec.type, Params(reader.specs().data(), reader.values().data(),
                                                         static_cast<std::uint32_t>(reader.specs().size()), context));
    } catch (const InvalidParameter& e) {
        reader.fail(e.key().c_str(), e.what());
    }
}

/// Whether what a plugin declares makes sense, before anything is allocated from it.
void require_sound(bool sound, const ModelSpec& spec, const char* what) {
    if (!sound) throw InputError(spec.source.place.text(), fmt::format("plugin '{}' is faulty: {}", spec.type, what));
}

bool sound_packing(const LawNeeds& needs, const FieldSpec& field) {
    return field.packed == 0 || (needs.bonds && field.packed % 4 == 0 && field.packed >= field.components);
}

void require_sound_law(const LawNeeds& needs, const ModelSpec& spec) {
    require_sound(needs.bonds != needs.deformation_gradient, spec,
                  "a law needs either bonds or a deformation gradient");
    require_sound(!needs.stress || needs.bonds, spec, "only a law with bonds says that it writes stress");
    require_sound(!needs.bonds || needs.horizon > 0, spec, "a law with bonds needs a horizon above 0");
    require_sound(needs.lanes == 0 || (std::has_single_bit(needs.lanes) && needs.lanes <= Slices<float>::kMostLanes),
                  spec, "families go side by side in 1, 2, 4, 8 or 16 lanes");
    require_sound(!needs.rows || needs.lanes > 0, spec, "a law takes rows of a lattice only beside slices");
    require_sound(
        std::max({needs.particle_state.size, needs.bond_state.size, needs.bond_constants.size}) <= kMaxStateFields,
        spec, fmt::format("it declares more than {} state fields", kMaxStateFields).c_str());
    const auto is_constant = [&](int index) { return index < static_cast<int>(needs.bond_constants.size); };
    require_sound(
        is_constant(needs.axial) && is_constant(needs.shared) && (needs.axial < 0 || needs.axial != needs.shared), spec,
        "`axial` and `shared` are two of its constants of bonds, or -1");
    for (std::uint32_t k = 0; k < needs.particle_state.size; ++k)
        require_sound(sound_packing(needs, needs.particle_state.data[k]), spec,
                      "a packed field needs bonds and a width that is a multiple of 4 and holds its components");
    const auto specs = spec.params->specs();
    require_sound(std::count_if(specs.begin(), specs.end(), [](const ParamSpec& p) { return p.per_particle; }) <=
                      kMaxVaryingParams,
                  spec, "it declares more than 8 parameters that vary per particle");
}

/// Before anything is made of the particles, so that the scene is blamed and not the simulation.
template <class Real>
void refuse_beyond_grid(const World<Real>& w, const BodySample& s) {
    const double reach = farthest_cell<Real>() * w.spacing();
    for (const Vec3& x : s.points)
        for (int c = 0; c < 3; ++c) {
            if (std::abs(static_cast<double>(static_cast<Real>(x[c]))) < reach) continue;
            throw InputError(
                s.spec->source.place.text(),
                fmt::format("body '{}' reaches {:g} m along axis {}: on a grid of spacing {:g} m particles in {} "
                            "precision must stay within {:g} m of the origin\n  move the scene nearer to the origin{}",
                            s.spec->name, x[c], "xyz"[c], w.spacing(),
                            std::is_same_v<Real, float> ? "single" : "double", reach,
                            std::is_same_v<Real, float> ? ", or use precision = \"double\"" : ""));
        }
}

/// Faces act on the grid's nodes: without a grid they would be ignored.
void refuse_closed_faces(const Scene& scene) {
    if (!scene.grid.bounded) return;
    if (std::any_of(std::begin(scene.grid.faces), std::end(scene.grid.faces), [](Face f) { return f != Face::open; }))
        throw InputError(scene.transfer.source.place.text(),
                         fmt::format("transfer '{}' has no grid for the faces of grid.domain to act on: use colliders, "
                                     "or faces = \"open\"",
                                     scene.transfer.type));
}

template <class Real>
void create_transfer(World<Real>& w) {
    w.transfer = create_model<TransferKernel, Real>(w.scene.transfer, {.grid_spacing = w.spacing()});
    w.transfer_needs = w.transfer->needs();
    if (w.transfer_needs.grid) {
        require_sound(w.transfer_needs.order >= 1 && w.transfer_needs.order <= 3 && w.transfer_needs.courant > 0,
                      w.scene.transfer, "a grid transfer needs an order of 1 to 3 and a Courant number above 0");
        return;
    }
    w.integrator = dynamic_cast<ParticleIntegrator<Real>*>(w.transfer.get());
    require_sound(w.integrator != nullptr, w.scene.transfer, "without a grid it must be a ParticleIntegrator");
}

/// The spacing that horizons are counted in: one per material of a bond law.
double common_spacing(const MaterialSpec& spec, const std::vector<BodySample>& bodies) {
    for (const BodySample& body : bodies)
        if (std::abs(body.spacing - bodies.front().spacing) > 1e-9 * body.spacing)
            throw InputError(body.spec->source.place.text(),
                             fmt::format("particle spacing {:g} m differs from {:g} m of another body of material "
                                         "'{}': bond laws count their horizon in "
                                         "spacings; use one material per spacing",
                                         body.spacing, bodies.front().spacing, spec.name));
    return bodies.front().spacing;
}

/// One calibration per material: all of its bodies are solids, or sheets of one thickness, or strands of one section.
void require_same_kind(const MaterialSpec& spec, const std::vector<BodySample>& bodies) {
    const BodySpec& first = *bodies.front().spec;
    for (const BodySample& body : bodies)
        if (body.spec->dimension != first.dimension || body.spec->across != first.across)
            throw InputError(
                body.spec->source.place.text(),
                fmt::format("body '{}' and body '{}' are of material '{}', but one is not as thick as the other: "
                            "solids, sheets and strands of one thickness each need a material of their own",
                            body.spec->name, first.name, spec.name));
}

/// Nothing on a grid tells how a single layer of particles is strained across.
void refuse_thin_local(const MaterialSpec& spec, const BodySpec& body) {
    if (body.dimension == 3) return;
    throw InputError(
        body.source.place.text(),
        fmt::format("law '{}' of material '{}' is for solids: body '{}' is a {}, one {} of particles, which has "
                    "no deformation gradient across; use a bond law (pd_elastic, pd_bond, pd_lps)",
                    spec.law.type, spec.name, body.name, body.dimension == 2 ? "sheet" : "strand",
                    body.dimension == 2 ? "layer" : "row"));
}

/// Families are found once, from positions that do not jump.
void refuse_periodic_faces(const Scene& scene, const MaterialSpec& spec) {
    if (!scene.grid.bounded ||
        std::count(std::begin(scene.grid.faces), std::end(scene.grid.faces), Face::periodic) == 0)
        return;
    throw InputError(
        spec.law.source.place.text(),
        fmt::format("law '{}' has bonds, and bonds do not reach across periodic faces of grid.domain: use a "
                    "local law, or \"symmetry\" faces",
                    spec.law.type));
}

template <class Real>
void create_models(World<Real>& w, Material<Real>& m, const MaterialSpec& spec, const std::vector<BodySample>& bodies) {
    const BodySpec& body = *bodies.front().spec;
    ModelContext context{.density = spec.density,
                         .particle_spacing = bodies.front().spacing,
                         .grid_spacing = w.spacing(),
                         .dimension = body.dimension,
                         .across = body.across};
    require_same_kind(spec, bodies);
    m.name = spec.name, m.law_name = spec.law.type, m.density = spec.density, m.dimension = body.dimension;
    m.law = create_model<ConstitutiveLaw, Real>(spec.law, context);
    m.spacing = bodies.front().spacing;
    m.needs = m.law->needs();
    require_sound_law(m.needs, spec.law);
    if (m.needs.bonds) common_spacing(spec, bodies), refuse_periodic_faces(w.scene, spec);
    if (!m.needs.bonds) refuse_thin_local(spec, body);
    if (!m.needs.bonds && !w.transfer_needs.grid)
        throw InputError(spec.law.source.place.text(),
                         fmt::format("law '{}' needs a deformation gradient, which transfer '{}' does not provide: use "
                                     "a grid transfer (apic, flip, pic) "
                                     "or a bond law",
                                     spec.law.type, w.scene.transfer.type));
    if (m.needs.stress && !w.transfer_needs.grid)
        throw InputError(spec.law.source.place.text(),
                         fmt::format("law '{}' leaves its stress to a grid, which transfer '{}' does not have: let its "
                                     "bonds carry the forces, or use a grid transfer (apic, flip, pic)",
                                     spec.law.type, w.scene.transfer.type));
    if (!spec.criterion.params) return;
    if (!m.needs.bonds)
        throw InputError(
            spec.criterion.source.place.text(),
            fmt::format("criterion '{}' breaks bonds, but law '{}' of material '{}' has none: use a bond law "
                        "(pd_bond, pd_lps, pd_elastic), or no criterion and the law tensile_damage",
                        spec.criterion.type, spec.law.type, spec.name));
    m.criterion_name = spec.criterion.type;
    context.opening_energy = m.needs.opening_energy, context.horizon = m.needs.horizon;
    context.volumes = m.needs.volumes;
    m.criterion = create_model<FractureCriterion, Real>(spec.criterion, context);
    if (m.criterion->asks_bond_energy() && !m.needs.stores_in_bonds)
        throw InputError(
            spec.criterion.source.place.text(),
            fmt::format("criterion '{}' needs the energy of each bond, which law '{}' of material '{}' does "
                        "not know: use pd_bond, pd_lps, pd_elastic or deviatoric_plastic, or another criterion "
                        "(critical_stretch, plane_cut)",
                        spec.criterion.type, spec.law.type, spec.name));
    require_sound(m.criterion->interval() >= 1, spec.criterion,
                  "a criterion is asked every 1 or more steps, not every 0");
}

/// Parameters given as a ramp over space get one value per particle.
template <class Real>
void create_varying(Material<Real>& m, const MaterialSpec& spec, const std::vector<Vec3>& X) {
    for (const ParamSpec& param : spec.law.params->specs()) {
        if (!param.per_particle) continue;
        auto& [declared, values] = m.varying.emplace_back(&param, AlignedArray<Real>());
        const std::optional<Ramp> ramp = spec.law.params->ramp(param.key);
        if (!ramp) continue;
        values = AlignedArray<Real>(m.size);
        for (std::size_t p = 0; p < m.size; ++p) values[p] = static_cast<Real>(value_at(*ramp, X[p]));
    }
}

template <class Real>
void create_fields(World<Real>& w, Material<Real>& m) {
    if (m.needs.deformation_gradient) {
        m.F = FieldArray<Real>(m.size, 9);
        for (int c = 0; c < 9; c += 4) std::fill_n(m.F[c], m.size, Real(1));
    }
    for (std::uint32_t k = 0; k < m.needs.particle_state.size; ++k) {
        const FieldSpec& spec = m.needs.particle_state.data[k];
        m.particle_state.push_back({spec, FieldArray<Real>::of(spec, m.size)});
    }
    if (!m.has_bonds()) return;
    if (m.needs.stress)
        m.stress = FieldArray<Real>(m.size, 6);
    else
        m.force = FieldArray<Real>(m.size, 3);
    m.stretch.resize(m.chunks(), std::numeric_limits<double>::infinity());
    m.position = AlignedArray<Real>(4 * m.size), m.reference = AlignedArray<Real>(4 * m.size);
    for (std::size_t p = 0; p < m.size; ++p) {
        for (int c = 0; c < 3; ++c) m.position[4 * p + c] = m.reference[4 * p + c] = w.x[c][m.begin + p];
        m.reference[4 * p + 3] = w.volume[m.begin + p];
    }
    m.constants = BondConstants<Real>(m.bonds, m.reference.data(), m.needs.bond_constants);
    if (w.transfer_needs.grid) m.order = AlignedArray<std::uint32_t>(m.size);
    for (std::uint32_t k = 0; k < m.needs.bond_state.size; ++k) {
        const FieldSpec& spec = m.needs.bond_state.data[k];
        m.bond_state.emplace_back(m.bonds.size(), kSlotPadding);
        std::fill_n(m.bond_state.back().data(), m.bonds.size(), static_cast<Real>(spec.initial));
    }
    for (std::uint32_t round = 0; round < m.needs.rounds; ++round)
        for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) { m.law->initialise(b, round); });
    m.constants.share(m.bonds, m.reference.data(), m.needs);
}

template <class Real>
void create_candidate_buffers(World<Real>& w) {
    std::size_t longest = 0;
    bool asks_energy = false;
    for (Material<Real>& m : w.materials) {
        if (!m.criterion) continue;
        asks_energy = asks_energy || m.criterion->asks_bond_energy();
        m.found.resize(m.chunks());
        m.touched.resize(m.chunks());
        for (std::size_t c = 0; c < m.chunks(); ++c)
            longest = std::max<std::size_t>(
                longest, m.bonds.row[std::min<std::size_t>(m.size, (c + 1) * kChunk)] - m.bonds.row[c * kChunk]);
    }
    for (Scratch<Real>& s : w.scratch) {
        s.candidates = AlignedArray<BondCandidate>(longest);
        if (!asks_energy) continue;
        s.own_energy = AlignedArray<Real>(longest, kSlotPadding);
        s.other_energy = AlignedArray<Real>(longest, kSlotPadding);
    }
}

template <class Real>
void refuse_crack_surface(const Material<Real>& m, const MaterialSpec& spec, bool parts) {
    const bool fields_only = spec.crack_surface == CrackSurface::fragment;
    if (spec.crack_surface == CrackSurface::particle || (parts && (m.dimension == 3 || !fields_only))) return;
    throw InputError(spec.crack_surface_place.text(),
                     fmt::format("'crack_surface' of material '{}' has nothing to act on: {}", spec.name,
                                 parts ? "\"fragment\" is for solids"
                                       : "no bond of it can break on a grid; it needs a bond law, "
                                         "'fracture' or a [[crack]], and a transfer with a grid"));
}

/// Which materials' cracks leave the grid, and the contact of their surfaces: as stiff as a fourth of the material's own
/// layer of particles, E V/h^2 for a spring across it, for each of about four that touch.
template <class Real>
void prepare_crack_surfaces(World<Real>& w) {
    for (Material<Real>& m : w.materials) {
        const auto largest = [](double a, double b) { return std::max(a, b); };
        const double speed = reduce_chunks(
            w, m, 0.0, [&](Block<Real>& b) { return m.law->max_wave_speed(b); }, largest);
        m.contact_stiffness = 0.25 * static_cast<double>(w.mass[m.begin]) * speed * speed / (m.spacing * m.spacing);
        const CrackSurface way = w.scene.materials[m.number].crack_surface;
        const bool parts = m.can_break() && w.transfer_needs.grid;
        refuse_crack_surface(m, w.scene.materials[m.number], parts);
        m.frees_crack_surfaces = parts && !m.force.empty() && way == CrackSurface::particle;
        m.parts_fragments = parts && m.dimension == 3 && way != CrackSurface::grid;
    }
    const bool may_touch =
        std::any_of(w.materials.begin(), w.materials.end(), [](const auto& m) { return m.frees_crack_surfaces; });
    for (Scratch<Real>& s : w.scratch) s.contact.is_bonded.resize(may_touch ? w.count : 0);
}

template <class Real>
void allocate_particles(World<Real>& w, const std::vector<BodySample>& samples) {
    w.body_begin.push_back(0);
    for (const BodySample& s : samples)
        w.body_begin.push_back(w.body_begin.back() + static_cast<std::uint32_t>(s.points.size()));
    w.count = w.body_begin.back();
    w.x = FieldArray<Real>(w.count, 3), w.v = FieldArray<Real>(w.count, 3);
    if (w.transfer_needs.affine) w.C = FieldArray<Real>(w.count, 9);
    w.mass = AlignedArray<Real>(w.count), w.volume = AlignedArray<Real>(w.count),
    w.id = AlignedArray<std::uint32_t>(w.count);
}

/// A spinning body starts as the affine field that it is.
template <class Real>
void set_affine_velocity(World<Real>& w, const Vec3& angular_velocity, const Vec3& x, std::size_t at) {
    for (int c = 0; c < 9; ++c) {
        const double share = w.transfer_needs.order == 1 ? linear_second_moment(x[c % 3] / w.spacing()) : 1.0;
        w.C[c][at] = static_cast<Real>(share * angular_velocity.cross(Vec3::Unit(c % 3))[c / 3]);
    }
}

/// Puts the particles of a body into the arrays from `at` on, and their positions before rounding into X.
template <class Real>
void place_body(World<Real>& w, const BodySample& body, const Material<Real>& m, std::size_t at, std::vector<Vec3>& X) {
    const BodySpec& spec = *body.spec;
    const std::vector<Vec3> points = m.has_bonds() ? exact_lattice<Real>(body.points, body.spacing) : body.points;
    const std::vector<std::uint32_t> order =
        m.has_bonds() ? row_order(points, body.spacing) : morton_order(points, body.spacing);
    const std::uint32_t first_id = w.body_begin[static_cast<std::size_t>(&spec - w.scene.bodies.data())];
    for (const std::uint32_t p : order) {
        const Vec3& x = points[p];
        const Vec3 v = spec.velocity + spec.angular_velocity.cross(x - body.center);
        for (int c = 0; c < 3; ++c) w.x[c][at] = static_cast<Real>(x[c]), w.v[c][at] = static_cast<Real>(v[c]);
        if (w.transfer_needs.affine) set_affine_velocity(w, spec.angular_velocity, x, at);
        w.volume[at] = static_cast<Real>(body.particle_volume);
        w.mass[at] = static_cast<Real>(m.density * body.particle_volume);
        w.id[at++] = first_id + p;
        w.set_speed(std::max(w.max_speed, v.norm()));
        X.push_back(body.points[p]);
    }
}

/// The material with number `number` in the scene, whose particles start at `begin`.
template <class Real>
void build_material(World<Real>& w, std::uint32_t number, const std::vector<BodySample>& bodies, std::size_t begin) {
    const MaterialSpec& spec = w.scene.materials[number];
    Material<Real>& m = w.materials.emplace_back();
    m.number = number, m.begin = begin;
    create_models(w, m, spec, bodies);
    std::vector<Vec3> X;
    std::vector<std::size_t> begins{0};
    for (const BodySample& body : bodies) {
        m.bodies.push_back(static_cast<std::uint32_t>(X.size()));
        place_body(w, body, m, begin + X.size(), X);
        begins.push_back(X.size());
    }
    m.size = X.size();
    if (m.has_bonds())
        m.bonds = build_bonds(X, begins, m.needs.horizon, m.criterion != nullptr || !w.scene.cracks.empty());
    if (spec.pieces > 0) m.piece = voronoi_pieces(X, begins, spec);
    create_varying(m, spec, X);
    create_fields(w, m);
}

template <class Real>
void build_colliders(World<Real>& w, double voxel) {
    w.threads.execute([&] {
        for (const ColliderSpec& c : w.scene.colliders)
            w.colliders.emplace_back(c, build_shape(c.shape, w.scene.folder, voxel));
    });
    for (Scratch<Real>& s : w.scratch) s.near.colliders.reserve(w.colliders.size());
}

}  // namespace

template <class Real>
void build_world(World<Real>& w) {
    create_transfer(w);
    std::vector<BodySample> samples;
    w.threads.execute([&] { samples = sample_bodies(w.scene); });
    if (w.transfer_needs.grid)
        for (const BodySample& s : samples) refuse_beyond_grid(w, s);
    allocate_particles(w, samples);
    w.scratch.resize(static_cast<std::size_t>(w.threads.count()));
    std::size_t begin = 0;
    for (std::uint32_t number = 0; number < w.scene.materials.size(); ++number) {
        std::vector<BodySample> bodies;
        for (const BodySample& s : samples)
            if (s.spec->material == number) bodies.push_back(s);
        if (bodies.empty()) continue;
        build_material(w, number, bodies, begin);
        begin += w.materials.back().size;
    }
    build_colliders(w, w.spacing() > 0 ? 0.5 * w.spacing() : samples.front().spacing);
    prepare_crack_surfaces(w);
    open_cracks(w);
    create_candidate_buffers(w);
    measure_wave_speed(w);
    measure_bond_steps(w);
    measure_extension(w);
    w.dt = choose_time_step(w, 1.0 / w.scene.simulation.frame_rate);
    w.defers_gather = w.transfer_needs.grid && w.scene.conditions.empty() &&
                      std::none_of(w.materials.begin(), w.materials.end(), [](auto& m) { return m.has_bonds(); });
    if (w.transfer_needs.grid)
        w.images = find_images(w.scene.grid), sort_particles(w);
    else
        refuse_closed_faces(w.scene);
    for (const ConditionSpec& spec : w.scene.conditions) add_condition(w, spec, {});
}

template void build_world(World<float>&);
template void build_world(World<double>&);

}  // namespace perimpm
