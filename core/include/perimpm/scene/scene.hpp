#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "perimpm/geometry/patch.hpp"
#include "perimpm/geometry/shape.hpp"
#include "perimpm/plugin/registry.hpp"
#include "perimpm/scene/reader.hpp"

namespace perimpm {

enum class Precision { single_, double_ };
enum class Face { sticky, slip, separate, open, symmetry, periodic };
enum class Contact { sticky, slip, separate };
/// How particles with broken bonds move: by their own forces; on the grid with everything else; with their fragment. Unless
/// it is `grid`, fragments have velocity fields of their own.
enum class CrackSurface { particle, grid, fragment };

/// A model as a scene names it, checked against the model's declared parameters.
struct ModelSpec {
    std::string type;
    std::shared_ptr<const Reader> params;  ///< null when the model is absent
    Value source;                          ///< the model's table as the scene gives it
};

struct SimulationSpec {
    double end_time;           ///< [s]
    double frame_rate;         ///< [1/s]
    std::optional<double> dt;  ///< [s]; absent: automatic
    double safety;             ///< share of the stable step that "auto" takes
    bool allow_unstable_dt;
    Precision precision;
    Vec3 gravity;    ///< [m/s^2]
    double damping;  ///< mass-proportional [1/s]
    Place dt_place;
};

struct GridSpec {
    double spacing;  ///< dx [m]; 0 when absent, which only transfers without a grid allow
    bool bounded;    ///< a domain was given
    Box3 domain;
    Face faces[6];  ///< min x, max x, min y, ...
    double face_friction;
};

/// Whether a position counted in cells is a node or midway between two, to a millionth of a cell.
inline bool on_half_cell(double cells) { return std::abs(2 * cells - std::round(2 * cells)) <= 2e-6; }

struct MaterialSpec {
    std::string name;
    double density;  ///< [kg/m^3]
    ModelSpec law;
    ModelSpec criterion;  ///< params null: nothing breaks
    CrackSurface crack_surface = CrackSurface::particle;
    Place crack_surface_place;
    std::uint32_t pieces = 0;  ///< Voronoi pieces of each body, between which alone bonds break; 0: anywhere
    std::uint64_t pieces_seed = 1;
};

struct BodySpec {
    std::string name;
    std::uint32_t material;                  ///< index
    Value shape;                             ///< checked; built when particles are sampled
    std::optional<double> particle_spacing;  ///< h [m]; else from particles_per_cell
    double particles_per_cell;
    bool poisson;   ///< sampling = "poisson"
    double jitter;  ///< of the lattice [spacings]
    std::uint64_t seed;
    std::uint32_t dimension;  ///< 3: solid, 2: sheet, 1: strand
    double across;            ///< 1, thickness [m], cross-section [m^2]
    Vec3 velocity;            ///< [m/s]
    Vec3 angular_velocity;    ///< [rad/s] about the centre of mass
    Value source;             ///< the body's table, for messages

    /// h [m]: as given, or that of `particles_per_cell` lattice points in a grid cell.
    double spacing(const GridSpec& grid) const {
        return particle_spacing ? *particle_spacing : grid.spacing / std::cbrt(particles_per_cell);
    }
};

struct ColliderSpec {
    std::string name;
    Value shape;
    Contact contact;
    double friction;
    Vec3 velocity;          ///< [m/s]
    Vec3 angular_velocity;  ///< [rad/s] about `pivot`, which moves with `velocity`
    Vec3 pivot;             ///< [m]
    Value source;
};

/// A cut through bodies that is there from the start.
struct CrackSpec {
    std::string name;
    std::optional<Patch> patch;         ///< absent: the triangles of a mesh
    std::optional<std::uint32_t> body;  ///< index; absent: any
    Value source;
};

/// What a condition sets: velocities; or accelerations, forces per volume, a total force.
enum class Drive { velocity, acceleration, body_force, force };

/// Something that happens to the particles of a region, chosen at t = 0.
struct ConditionSpec {
    std::string name;
    std::optional<Value> shape;             ///< absent: everywhere
    std::optional<std::uint32_t> body;      ///< index; absent: any
    std::optional<std::uint32_t> material;  ///< index; absent: any
    Drive drive = Drive::velocity;
    Vec3 value = Vec3::Zero();                     ///< [m/s], [m/s^2], [N/m^3] or [N]
    bool free[3] = {};                             ///< velocity: components left to the motion
    std::vector<double> times = {}, factors = {};  ///< [s], [1]: of `value`, linear between; empty: 1 at all times
    Value source;
};

struct OutputSpec {
    std::vector<std::string> fields;
    std::vector<std::string> formats;
};

/// A validated scene. Shapes are not built yet, plugins named by it are open.
struct Scene {
    std::string title;
    std::string folder;  ///< relative file names start here
    SimulationSpec simulation;
    GridSpec grid;
    ModelSpec transfer;
    std::vector<MaterialSpec> materials;
    std::vector<BodySpec> bodies;
    std::vector<ColliderSpec> colliders;
    std::vector<ConditionSpec> conditions;
    std::vector<CrackSpec> cracks;
    OutputSpec output;
    Value source;
};

/// Validates a tree. `folder`: where relative file names start. Throws InputError.
PERIMPM_API Scene read_scene(Value tree, const std::string& folder);

/// Reads one [[condition]], the scene's `index`-th. With `function` its values come from elsewhere and what they are is
/// given here instead of in the table.
PERIMPM_API ConditionSpec read_condition(const Value& table, std::size_t index, const Scene& scene,
                                         std::optional<Drive> function = {});

/// The scene's tree with the default of every key filled in and mesh files by absolute name: it reads back to the same
/// scene from any folder. Defaults that a model refuses beside the keys given (they belong to another choice) stay out.
PERIMPM_API Value resolved_scene(const Scene& scene);

/// Builds a shape from its checked table; relative files start in `folder`; meshes get level sets of `voxel_size`.
PERIMPM_API ShapePtr build_shape(const Value& shape, const std::string& folder, double voxel_size);

/// A scene table with the keys it accepts; the reference page and `describe` come from these.
struct SectionDoc {
    std::string topic;  ///< one word, e.g. "simulation", "box"
    std::string name;   ///< as a scene writes it, e.g. "[simulation]", "shape = { type = \"box\" }"
    std::string doc;
    std::vector<ParamSpec> keys;
};
PERIMPM_API std::vector<SectionDoc> scene_reference();

}  // namespace perimpm
