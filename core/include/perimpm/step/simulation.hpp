#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "perimpm/io/frame_writer.hpp"
#include "perimpm/scene/scene.hpp"
#include "perimpm/step/plan.hpp"

namespace perimpm {

/// A particle field without a copy: component c of particle i is data[c * stride + i * entry], in `bytes` per number.
struct FieldView {
    std::string name, unit, doc;
    std::string source;  ///< who computes it: "core", or the model
    void* data;
    std::size_t size, components, stride, entry;
    NumberType type;
    bool writable = true;  ///< false: what others count on, as numbers of particles and of broken bonds
};

/// Sums over all particles (SI). Angular momentum about the origin, with the affine (APIC) part.
struct Ledger {
    double time, kinetic, elastic, potential;
    std::array<double, 3> momentum, angular_momentum;
};

/// A piece of matter: particles that live bonds join, or a whole body where nothing can break.
struct Fragment {
    std::uint32_t id = 0;  ///< the least id of its particles
    std::uint64_t particles = 0;
    double mass = 0;                                   ///< [kg]
    std::array<double, 3> center = {}, velocity = {};  ///< of the mass [m], [m/s]
};

struct PassTime {
    std::string name;
    std::uint64_t calls;
    double seconds;
};

/// Values of a condition for n particles at time t [s], three each, row by row; X: where the particles were when the
/// condition was made [m]. NaN leaves a component of a velocity free.
using ConditionFunction = std::function<void(double t, std::size_t n, const double* X, double* values)>;

/// How a search for equilibrium ended.
struct Relaxation {
    std::uint64_t steps;
    double residual;  ///< root mean square of unbalanced accelerations over their largest so far, or gravity
};

/// A scene in motion. Not thread-safe; uses its own worker threads.
class PERIMPM_API Simulation {
public:
    /// Builds particles, bonds and the plan. threads: 0 takes every core. Throws InputError.
    explicit Simulation(Scene scene, int threads = 0);
    ~Simulation();
    Simulation(Simulation&&) noexcept;

    /// What comes after a step: somebody may look at the particles through views, or a further step or settle() follows at
    /// once. Before a step, where the scene allows it, particles are moved and scattered in one pass, which saves half the
    /// memory traffic. All members see the particles as they should be in either case, since they settle first (and may
    /// throw SimulationError); bits are the same.
    enum class Next { look, step };
    /// Advances one step, the first of equal ones that fill `whole` [s]; by default as long as is stable. Returns the step
    /// taken [s]. Throws SimulationError.
    double step(double whole = 1e300, Next next = Next::look);
    /// Moves particles that wait for the next step. Throws SimulationError.
    void settle();

    /// Adds a condition before the first step: as in a scene's [[condition]], or with values from `function`, which is
    /// called once per step (twice without a grid) on the stepping thread. Throws InputError, also after a step.
    void add_condition(const ConditionSpec& spec, ConditionFunction function = {});
    /// Steps at the present time, stopping all motion at each maximum of its energy, until the forces balance to
    /// `residual`. Prescribed particles stand still. Throws SimulationError when `most_steps` do not suffice.
    /// `after_step` may end the search by an exception.
    Relaxation relax(double residual, std::uint64_t most_steps, const std::function<void()>& after_step = {});

    double time() const;
    std::uint64_t steps() const;
    std::uint64_t particle_count() const;
    const Scene& scene() const;
    const Plan& plan() const;
    Ledger ledger() const;
    std::vector<PassTime> pass_times() const;
    /// The pieces that the scene consists of now, ascending by id.
    std::vector<Fragment> fragments() const;
    /// Whether bonds of this scene can break.
    bool can_break() const;

    /// Names of the fields that exist, for all particles or those of one material (its state fields included).
    std::vector<std::string> fields(const std::string& material = "") const;
    /// Throws InputError for an unknown material or field, with the closest name.
    FieldView field(const std::string& name, const std::string& material = "") const;
    /// Counts the re-sorts: when it changes, slots of local laws' particles hold other particles than before.
    std::uint64_t generation() const;
    /// To be called after a field was written from outside. The next step takes note of "x" (it sorts anew and takes new
    /// forces), "v", "mass", "volume" and "F" (it is chosen for the speeds, masses and strains as they are then); others
    /// need no notice. It throws SimulationError, naming the particle, for a value that is not finite, a mass or volume that
    /// is not above 0, and a volume that bonds keep.
    void written(const std::string& field);

    /// Every name that `frame` accepts in this scene: the fields of all materials, and "body".
    std::vector<std::string> frame_fields() const;
    /// The scene's output fields in the order of ids. `number` is the frame number to put into the frame.
    Frame frame(std::uint32_t number) const;
    /// The same with other fields.
    Frame frame(std::uint32_t number, const std::vector<std::string>& names) const;

private:
    class Engine;
    std::unique_ptr<Engine> engine_;
};

}  // namespace perimpm
