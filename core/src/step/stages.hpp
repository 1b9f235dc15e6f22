#pragma once

#include <span>

#include "step/world.hpp"

namespace perimpm {

// The stages, in the order of a step (METHOD section 2).
template <class Real>
void build_world(World<Real>& w);
/// Brings particles that left through a periodic face back in at the other one.
template <class Real>
void wrap_particles(World<Real>& w);
template <class Real>
void sort_particles(World<Real>& w);
/// Cells that particles may move after a sort before their stencils can leave their tiles, less rounding.
constexpr double sort_margin(std::uint32_t order) { return order == 3 ? 0.49 : 0.98; }
template <class Real>
void pack_positions(World<Real>& w, Material<Real>& m);
template <class Real>
void compute_bond_forces(World<Real>& w);
template <class Real>
void scatter(World<Real>& w);
/// Nodes behind mirrors and periodic borders give mass and momentum to the nodes that they are images of.
template <class Real>
void fold_images(World<Real>& w);
/// Whose velocity fields there are, after bonds broke; false: as before.
template <class Real>
bool find_owners(World<Real>& w);
/// After a sort has found blocks: the numbers of velocity fields, into the keys of the blocks of w.sort.
template <class Real>
void assign_fields(World<Real>& w);
/// After a sort: what contact between fields must know of the blocks that they share.
template <class Real>
void prepare_field_contact(World<Real>& w);
/// Velocity fields that approach each other where their surfaces meet exchange momentum.
template <class Real>
void resolve_field_contact(World<Real>& w);
template <class Real>
void update_grid(World<Real>& w);
/// The way back: nodes behind take the velocities of those nodes.
template <class Real>
void unfold_images(World<Real>& w);
template <class Real>
void gather(World<Real>& w);
/// Notes how far a gather moved particles. Returns what was found in all blocks.
template <class Real>
BlockFindings note_findings(World<Real>& w);
/// Whether the next step need not sort first, so that its scatter can follow the owed gather block by block.
template <class Real>
bool gather_can_wait(const World<Real>& w);
/// The owed gather and the scatter of the present step in one pass over the particles.
template <class Real>
void gather_and_scatter(World<Real>& w);
template <class Real>
void integrate_particles(World<Real>& w);
template <class Real>
void collide_particles(World<Real>& w);
/// Step 6 for `size` particles with positions x and velocities v. Returns the largest sum of changes of a velocity [m/s].
template <class Real>
double collide_run(World<Real>& w, const Field<Real>& x, const Field<Real>& v, std::size_t size);
/// The largest speed of a collider [m/s].
template <class Real>
double fastest_collider(const World<Real>& w);
template <class Real>
Relaxation relax(World<Real>& w, double residual, std::uint64_t most_steps, const std::function<void()>& step);
/// Forces of one chunk's block, from packed positions; notes its largest stretch where a criterion may ask for it.
template <class Real>
void evaluate_bonds(World<Real>& w, Material<Real>& m, std::size_t chunk, Block<Real>& b);
template <class Real>
void fracture(World<Real>& w, Material<Real>& m);
/// Angular momentum that a particle's affine velocity field carries: m e_ijk B_kj (Jiang et al. 2015, section 5.3.1).
template <class Real>
Vec3 affine_spin(const World<Real>& w, std::size_t p);
/// The material's particles that lost their first bond leave the grid: their families take over what their affine velocity
/// fields carry.
template <class Real>
void leave_grid(World<Real>& w, Material<Real>& m, std::span<const std::uint32_t> particles);
/// Particles at crack surfaces move by the forces of their own bonds.
template <class Real>
void move_crack_surfaces(World<Real>& w);
/// Particles at crack surfaces repel what they touch and are not bonded to.
template <class Real>
void apply_contact(World<Real>& w);
/// What is stored in it [J].
template <class Real>
double contact_energy(World<Real>& w);
/// Cuts the bonds that cross the scene's cracks, before the first step. Throws InputError for a crack that crosses none.
template <class Real>
void open_cracks(World<Real>& w);
/// By particle in storage order: the least id in its fragment, the particles that live bonds join (its body, where nothing
/// can break).
template <class Real>
std::vector<std::uint32_t> label_fragments(const World<Real>& w);
/// The scene's fragments, ascending by id.
template <class Real>
std::vector<Fragment> list_fragments(const World<Real>& w);
/// On a grid: the laws' largest wave speed in the present state, into w.wave_speed.
template <class Real>
void measure_wave_speed(World<Real>& w);
/// How far bonds are stretched at present positions, which are packed, into w.extension.
template <class Real>
void measure_extension(World<Real>& w);
/// The steps that bonds allow where they move particles by themselves, into w.bond_steps.
template <class Real>
void measure_bond_steps(World<Real>& w);
/// The largest speed of particles or colliders [m/s].
template <class Real>
double fastest_motion(const World<Real>& w);
/// What a grid allows a material with this wave speed at the present speeds [s].
template <class Real>
double grid_bound(const World<Real>& w, double wave_speed);
/// The least bound: of the grid for the wave speed given, and of crack surfaces; without a grid the last measured one [s].
template <class Real>
double time_step_bound(const World<Real>& w, double wave_speed);
/// The step to take, the first of equal ones that fill `whole` [s].
template <class Real>
double choose_time_step(World<Real>& w, double whole);
template <class Real>
Ledger take_ledger(World<Real>& w);
template <class Real>
Plan make_plan(World<Real>& w);
template <class Real>
std::vector<FieldView> list_fields(World<Real>& w, const std::string& material);
template <class Real>
std::vector<std::string> list_frame_fields(World<Real>& w);
template <class Real>
Frame make_frame(World<Real>& w, std::uint32_t number, const std::vector<std::string>& names);
/// What a step must know after positions, velocities, masses and volumes, or deformation gradients were written from outside. Throws
/// SimulationError for a value that is not finite, or not above 0, and for volumes that bonds have kept.
template <class Real>
void accept_positions(World<Real>& w);
template <class Real>
void accept_velocities(World<Real>& w);
template <class Real>
void accept_weights(World<Real>& w);
template <class Real>
void accept_deformations(World<Real>& w);
/// One message for every body with particles inside a collider at the start.
template <class Real>
std::vector<std::string> starting_overlaps(const World<Real>& w);

}  // namespace perimpm
