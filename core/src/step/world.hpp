#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "perimpm/model/transfer_kernel.hpp"
#include "perimpm/plugin/registry.hpp"
#include "perimpm/scene/scene.hpp"
#include "perimpm/step/simulation.hpp"
#include "state/array.hpp"
#include "state/grid.hpp"
#include "state/threads.hpp"
#include "step/collider.hpp"
#include "step/conditions.hpp"
#include "step/contact.hpp"
#include "step/faces.hpp"
#include "step/material.hpp"
#include "step/velocity_fields.hpp"

namespace perimpm {

inline constexpr std::uint64_t kMeasureInterval = 10;  ///< steps between two measurements of the wave speed

/// What the sort works with, kept from one to the next. By particle of the world: its block's key. By particle of the
/// material in hand: its block's number; then, in the new order, indices and keys within the block.
template <class Real>
struct SortBuffers {
    std::vector<std::uint64_t> block;
    std::vector<std::vector<std::uint64_t>> found;  ///< blocks by piece of the particles
    std::vector<std::uint64_t> blocks;              ///< all of them, in order
    std::vector<std::uint32_t> slot, count, index, other_index;
    std::vector<std::uint16_t> key, other_key;
    std::vector<Real> values;

    std::size_t bytes() const {
        return 8 * (block.capacity() + blocks.capacity()) +
               4 * (slot.capacity() + count.capacity() + index.capacity() + other_index.capacity()) +
               2 * (key.capacity() + other_key.capacity()) + sizeof(Real) * values.capacity();
    }
};

/// Which obstacles can touch a block of nodes.
struct NearObstacles {
    std::vector<const Collider*> colliders;
    bool faces;
};

/// A tile, and a second one where the grid keeps the velocity before forces.
template <class Real>
struct Tiles {
    AlignedArray<Real> tile{kTileValues + kTilePadding}, increment{kTileValues + kTilePadding};
};

/// Buffers of one worker.
template <class Real>
struct Scratch {
    Tiles<Real> now, next;  ///< to gather from or scatter to; to scatter to while `now` is gathered from
    static constexpr std::size_t kRoom =
        kRun + 64 / sizeof(Real);  ///< a line more, or components would meet in one set
    FieldArray<Real> tau{kRoom, 6};
    FieldArray<Real> x{kRoom, 3}, v{kRoom, 3}, C{kRoom, 9},
        force{kRoom, 3};  ///< bond laws' particles in grid order; v and C on their way from gather to scatter
    AlignedArray<Real> mass{kRoom}, volume{kRoom};
    AlignedArray<BondCandidate> candidates;
    AlignedArray<Real> own_energy, other_energy;  ///< criteria that ask for them: of a chunk's bonds
    NearObstacles near;
    ContactSearch<Real> contact;
    std::vector<FieldAtNode<Real>> present;  ///< velocity fields at a node
};

/// Wall time of the passes of a step, in order of first use.
class PassTimer {
public:
    template <class Body>
    void operator()(const char* name, const Body& body) {
        const auto start = std::chrono::steady_clock::now();
        body();
        PassTime& pass = find(name);
        ++pass.calls;
        pass.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    const std::vector<PassTime>& passes() const { return passes_; }

private:
    PassTime& find(const char* name) {
        for (PassTime& pass : passes_)
            if (pass.name == name) return pass;
        return passes_.emplace_back(PassTime{name, 0, 0.0});
    }
    std::vector<PassTime> passes_;
};

/// The step whose velocities the grid holds.
struct GridMotion {
    std::uint64_t step = 0;    ///< its number
    double start = 0, dt = 0;  ///< [s]
    double fastest = 0;        ///< largest speed of a node with mass, infinite when one is not finite [m/s]
    bool owed = false;         ///< particles have not moved with it yet
};

/// The first step above the stable one, which simulation.allow_unstable_dt let pass; number 0: none was.
struct UnstableStep {
    std::uint64_t step = 0;
    double dt = 0, bound = 0;  ///< [s]
};

/// What a gather, and what is done with the particles in the same pass, found in a block.
struct BlockFindings {
    double speed2 = 0;    ///< largest squared grid velocity at a particle, not a number if one is not finite [m^2/s^2]
    double collided = 0;  ///< largest sum of a velocity's changes by colliders [m/s]
    double wave_speed = 0;            ///< largest, if it was measured [m/s]
    std::exception_ptr refusal = {};  ///< what a law threw

    /// Block by block; a speed that is not a number stays.
    void add(const BlockFindings& more) {
        speed2 = std::isnan(speed2) || std::isnan(more.speed2) ? std::nan("") : std::max(speed2, more.speed2);
        collided = std::max(collided, more.collided);
        wave_speed = std::max(wave_speed, more.wave_speed);
        if (!refusal) refusal = more.refusal;
    }
};

/// Everything a step works on. The stages are free functions over it, one file each.
template <class Real>
struct World {
    World(Scene scene, int thread_count) : scene{std::move(scene)}, threads{thread_count} {}

    Scene scene;
    Threads threads;
    ModelPtr<TransferKernel, Real> transfer;
    TransferNeeds transfer_needs;
    ParticleIntegrator<Real>* integrator = nullptr;  ///< `transfer` when it has no grid
    std::vector<Material<Real>> materials;           ///< those with particles, in scene order
    std::vector<std::uint32_t> body_begin;           ///< by body: its first particle id, then the total
    std::vector<Collider> colliders;
    Conditions<Real> conditions;

    std::size_t count = 0;
    FieldArray<Real> x, v, C;
    AlignedArray<Real> mass, volume;
    AlignedArray<std::uint32_t> id;

    BlockGrid<Real> grid;
    DomainImages images;                 ///< of the domain's faces that are mirrors or periodic
    std::vector<Scratch<Real>> scratch;  ///< by worker
    std::vector<double> partial;         ///< by block or chunk, for ordered reductions
    std::vector<BlockFindings> found;    ///< by particle block

    double time = 0;
    std::uint64_t steps = 0;
    double dt = 0;  ///< of the step being taken
    UnstableStep unstable;
    bool defers_gather =
        false;  ///< gathers may wait for the scatter of the next step: on a grid, where neither bonds nor
                ///< conditions act between the two
    /// Largest speed of the grid at particles as the next step may know it [m/s]. Where gathers may be deferred it is one
    /// step old, so that steps are chosen alike whether the last gather has been done or not.
    double max_speed = 0;
    double gathered_speed = 0;  ///< as the last gather found it
    GridMotion motion;
    double wave_speed = 0;      ///< last measured [m/s]
    StableStep bond_steps;      ///< of what moves by forces of bonds: at crack surfaces, without a grid everything
    double extension = 0;       ///< largest (|Y| - |X|)/|Y| of the bonds so far
    double drift = 0;           ///< how far any particle may have moved since the sort [m]
    double farthest = 0;        ///< bound of |x| along any axis, since the sort [m]
    bool forces_known = false;  ///< particle transfer: forces belong to the present positions
    std::uint64_t generation = 0;
    std::uint64_t sorts = 0;
    bool has_crack_surfaces = false;  ///< some particles have left the grid
    ContactPairs<Real> contact;
    VelocityFields<Real> fields;
    bool relaxing = false;  ///< on the way to equilibrium: prescribed particles stand still
    SortBuffers<Real> sort;
    PassTimer timer;

    double spacing() const { return scene.grid.spacing; }
    void set_speed(double speed) { max_speed = gathered_speed = speed; }
    Scratch<Real>& own_scratch() { return scratch[Threads::current()]; }
};

template <class Real>
bool any_can_break(const World<Real>& w) {
    return std::any_of(w.materials.begin(), w.materials.end(), [](const auto& m) { return m.can_break(); });
}

template <class Real>
bool parts_fragments(const World<Real>& w) {
    return std::any_of(w.materials.begin(), w.materials.end(), [](const auto& m) { return m.parts_fragments; });
}
template <class Real>
bool has_own_fields(const World<Real>& w) {
    return std::any_of(w.materials.begin(), w.materials.end(), [](const auto& m) { return m.has_own_fields(); });
}

/// The block of `size` particles from index `first` of the material, counted in storage order.
template <class Real>
Block<Real> make_block(World<Real>& w, Material<Real>& m, std::size_t first, std::size_t size) {
    Block<Real> b;
    const std::size_t at = m.begin + first;
    b.size = static_cast<std::uint32_t>(size);
    b.first = static_cast<std::uint32_t>(first);
    b.dt = static_cast<Real>(w.dt);
    b.x = w.x.view().from(at);
    b.v = w.v.view().from(at);
    b.mass = w.mass.data() + at;
    b.volume = w.volume.data() + at;
    b.F = m.F.view().from(m.F.empty() ? 0 : first);
    b.force = m.force.view().from(m.force.empty() ? 0 : first);
    b.tau = m.stress.view().from(m.stress.empty() ? 0 : first);
    for (std::size_t k = 0; k < m.varying.size(); ++k)
        if (!m.varying[k].second.empty()) b.param[k] = m.varying[k].second.data() + first;
    for (std::size_t k = 0; k < m.particle_state.size(); ++k) {
        b.family_state[k] = m.particle_state[k].values.view();
        b.particle_state[k] = m.particle_state[k].values.from(first);
    }
    for (std::size_t k = 0; k < m.bond_state.size(); ++k) b.bond_state[k] = m.bond_state[k].data();
    for (std::size_t k = 0; k < m.constants.declared.size(); ++k) b.bond_constants[k] = m.constants.declared[k].data();
    if (m.has_bonds()) {
        b.family.row = m.bonds.row.data() + first;
        b.family.neighbour = m.bonds.neighbour.data();
        if (!m.bonds.broken.empty()) {
            b.family.broken = m.bonds.broken.data();
            b.family.damage = m.bonds.damage.data() + first;
            b.family.is_cut = m.bonds.is_cut;
        }
        b.family.position = m.position.data();
        b.family.reference = m.reference.data();
        b.family.volume = w.volume.data() + m.begin;
        b.family.shape = m.constants.shape.data() + first;
        b.family.length = m.constants.length.data();
        b.family.slices = m.constants.slices.view();
        b.family.rows = m.constants.rows.view();
        b.family.y = w.x.view().from(m.begin);
    }
    return b;
}

/// Whether the state at the start of this step is measured; the next steps are chosen by what is found.
template <class Real>
bool measures_now(const World<Real>& w) {
    return w.transfer_needs.grid && w.steps > 0 && w.steps % kMeasureInterval == 0;
}

/// Calls body(chunk number, block) for every fixed chunk of the material, in parallel.
template <class Real, class Body>
void for_each_chunk(World<Real>& w, Material<Real>& m, const Body& body) {
    w.threads.run(m.chunks(), [&](std::size_t c) {
        Block<Real> b = make_block(w, m, c * kChunk, std::min<std::size_t>(kChunk, m.size - c * kChunk));
        body(c, b);
    });
}

/// Sum (or largest) of value(block) over all chunks, taken in the order of chunks.
template <class Real, class Value, class Combine>
double reduce_chunks(World<Real>& w, Material<Real>& m, double start, const Value& value, const Combine& combine) {
    w.partial.resize(std::max(w.partial.size(), m.chunks()));
    for_each_chunk(w, m, [&](std::size_t c, Block<Real>& b) { w.partial[c] = value(b); });
    for (std::size_t c = 0; c < m.chunks(); ++c) start = combine(start, w.partial[c]);
    return start;
}

}  // namespace perimpm
