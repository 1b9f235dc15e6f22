#pragma once

#include <cstdint>
#include <vector>

#include "perimpm/scene/scene.hpp"
#include "perimpm/step/simulation.hpp"
#include "state/array.hpp"

namespace perimpm {

/// A condition and the particles that it was given at the start.
struct Condition {
    ConditionSpec spec;
    ConditionFunction function;     ///< empty: the value that the scene gives
    std::vector<std::uint32_t> id;  ///< ascending
    std::vector<double> X;          ///< with a function: positions at the start, by particle [m]
    std::vector<double> values;     ///< with a function: what it returned last, by particle
    double inverse_volume = 0;      ///< of the region [1/m^3]
};

/// All of a scene's conditions. Empty when there are none.
template <class Real>
struct Conditions {
    std::vector<Condition> list;
    std::vector<std::uint32_t> slot;  ///< by id: where the particle lies
    std::vector<std::uint32_t> held;  ///< by id: its number among the held ones, or kFree
    std::vector<std::uint32_t> id;    ///< by number: its id
    std::vector<Real> velocity;       ///< by number, three each: prescribed [m/s], NaN where free
    std::vector<Real> start;          ///< by number: x before the particles move [m]

    // Grids: what prescribed particles bring to each node.
    std::vector<char> block_holds;  ///< by particle block
    std::vector<char> near;         ///< by grid block
    AlignedArray<Real> momentum;    ///< of the prescribed components [kg m/s]
    AlignedArray<Real> mass;        ///< by component, of the particles that prescribe it [kg]
    std::uint64_t sorts = 0;        ///< number of the sort that slots belong to

    static constexpr std::uint32_t kFree = 0xffffffff;
    bool holds() const { return !id.empty(); }
    std::size_t bytes() const {
        std::size_t own = 4 * (slot.capacity() + held.capacity() + id.capacity()) +
                          sizeof(Real) * (velocity.capacity() + start.capacity()) + momentum.bytes() + mass.bytes();
        for (const Condition& c : list) own += 4 * c.id.capacity() + 8 * (c.X.capacity() + c.values.capacity());
        return own;
    }
};

template <class Real>
struct World;

/// Gives the condition the particles that lie in its region now.
template <class Real>
void add_condition(World<Real>& w, const ConditionSpec& spec, ConditionFunction function);
template <class Real>
void apply_loads(World<Real>& w, double t, double dt);
template <class Real>
void prescribe_velocities(World<Real>& w, double t);
template <class Real>
void move_held_particles(World<Real>& w);
template <class Real>
void prepare_held_nodes(World<Real>& w);
template <class Real>
void scatter_held(World<Real>& w);
/// Nodes with a share of mass from prescribed particles move as prescribed.
template <class Real>
void hold_nodes(World<Real>& w);

}  // namespace perimpm
