#include "scene/keys.hpp"

#include "perimpm/scene/scene.hpp"

namespace perimpm {
namespace {

using enum ParamKind;
constexpr const char* kFaceWords = "sticky|slip|separate|open|symmetry|periodic";

constexpr ParamSpec kSceneTable[] = {
    {.key = "format", .kind = integer, .doc = "version of the scene format: 1"},
    {.key = "title", .kind = text, .default_text = "", .doc = "shown in reports"},
    {.key = "simulation", .kind = table, .doc = "duration and time step"},
    {.key = "grid", .kind = table, .optional = true, .doc = "background grid and domain"},
    {.key = "transfer", .kind = table, .doc = "{ type = transfer plugin, its parameters }: how particles move"},
    {.key = "material", .kind = table, .doc = "materials by name, written [material.NAME]"},
    {.key = "body", .kind = list, .optional = true, .doc = "solids, each written [[body]]; at least one"},
    {.key = "collider", .kind = list, .optional = true, .doc = "rigid obstacles, each written [[collider]]"},
    {.key = "condition",
     .kind = list,
     .optional = true,
     .doc = "boundary conditions and loads on regions, each written [[condition]]"},
    {.key = "crack",
     .kind = list,
     .optional = true,
     .doc = "cuts that are there from the start, each written [[crack]]"},
    {.key = "output", .kind = table, .optional = true, .doc = "what frames hold"},
};
constexpr ParamSpec kSimulationTable[] = {
    {.key = "end_time", .unit = "s", .range = above(0.0), .doc = "simulated time"},
    {.key = "frame_rate", .unit = "1/s", .range = above(0.0), .default_value = 24.0, .doc = "frames per second"},
    {.key = "dt",
     .unit = "s",
     .range = above(0.0),
     .default_text = "auto",
     .choices = "auto",
     .doc = "time step, shortened so that equal ones fill a frame; \"auto\" takes `safety` times the stable one; on a "
            "grid "
            "smaller steps damp more"},
    {.key = "safety",
     .range = {.low = 0.0, .high = 1.0, .high_open = false},
     .default_value = 0.8,
     .doc = "share of the stable time step that \"auto\" takes"},
    {.key = "allow_unstable_dt", .kind = boolean, .default_value = 0.0, .doc = "accept a dt above the stable one"},
    {.key = "precision",
     .kind = choice,
     .default_text = "float",
     .choices = "float|double",
     .doc = "of particles and grid"},
    {.key = "gravity", .kind = vector, .unit = "m/s^2", .default_text = "[0, -9.81, 0]", .doc = "acceleration, Y up"},
    {.key = "damping",
     .unit = "1/s",
     .range = at_least(0.0),
     .default_value = 0.0,
     .doc = "mass-proportional: free motion decays as exp(-damping t), amplitudes of vibration at half that rate"},
};
constexpr ParamSpec kGridTable[] = {
    {.key = "spacing",
     .unit = "m",
     .range = above(0.0),
     .optional = true,
     .doc = "cell size; required unless the transfer has no grid"},
    {.key = "domain", .kind = table, .optional = true, .doc = "box that particles must stay in; absent: unbounded"},
};
constexpr ParamSpec kDomainTable[] = {
    {.key = "min", .kind = vector, .unit = "m", .doc = "lower corner"},
    {.key = "max", .kind = vector, .unit = "m", .doc = "upper corner"},
    {.key = "faces",
     .kind = table,
     .default_text = "separate",
     .choices = kFaceWords,
     .doc = "one word for all six faces or a table by face"},
    {.key = "friction", .range = at_least(0.0), .default_value = 0.0, .doc = "Coulomb coefficient"},
};
constexpr ParamSpec face(const char* key) {
    return {.key = key,
            .kind = choice,
            .default_text = "separate",
            .choices = kFaceWords,
            .doc = "what particles meet at this face"};
}
constexpr ParamSpec kFacesTable[] = {face("min_x"), face("max_x"), face("min_y"),
                                     face("max_y"), face("min_z"), face("max_z")};
constexpr ParamSpec kMaterialTable[] = {
    {.key = "density", .unit = "kg/m^3", .range = above(0.0), .doc = "reference mass density"},
    {.key = "constitutive", .kind = table, .doc = "{ type = constitutive plugin, its parameters }"},
    {.key = "fracture",
     .kind = table,
     .optional = true,
     .doc = "{ type = fracture plugin, its parameters }; absent: nothing breaks"},
    {.key = "pieces",
     .kind = integer,
     .range = at_least(2.0),
     .optional = true,
     .doc = "bonds break only between so many Voronoi pieces of each body"},
    {.key = "pieces_seed", .kind = integer, .range = at_least(0.0), .default_value = 1.0, .doc = "of the pieces"},
    {.key = "crack_surface",
     .kind = choice,
     .default_text = "particle",
     .choices = "particle|fragment|grid",
     .doc =
         "how particles with broken bonds move: by the forces of their own bonds and by contact, so that the two sides "
         "of a crack part; with their fragment; or on one grid with everything else, which holds fragments together; "
         "fragments of a solid have velocity fields of their own unless it is \"grid\""},
};
constexpr ParamSpec kBodyTable[] = {
    {.key = "name", .kind = text, .optional = true, .doc = "default: body N"},
    {.key = "material", .kind = text, .doc = "name of a material"},
    {.key = "shape",
     .kind = table,
     .doc = "{ type = box, sphere, cylinder, mesh; rectangle for a sheet, polyline for a strand; its parameters }"},
    {.key = "thickness",
     .unit = "m",
     .range = above(0.0),
     .optional = true,
     .doc =
         "makes the body a sheet, one layer of particles: shape rectangle, or mesh, of which it is then the surface"},
    {.key = "cross_section",
     .unit = "m^2",
     .range = above(0.0),
     .optional = true,
     .doc = "area of a strand's section; shape polyline, a row of particles"},
    {.key = "particles_per_cell",
     .range = above(0.0),
     .default_value = 8.0,
     .doc = "mean number of particles in a grid cell"},
    {.key = "particle_spacing",
     .unit = "m",
     .range = above(0.0),
     .optional = true,
     .doc = "distance of particles, instead of particles_per_cell"},
    {.key = "sampling",
     .kind = choice,
     .default_text = "lattice",
     .choices = "lattice|poisson",
     .doc = "cubic lattice or Poisson-disk points"},
    {.key = "jitter",
     .unit = "spacings",
     .range = closed(0.0, 0.5),
     .default_value = 0.0,
     .doc =
         "how far points of the lattice are moved along each axis, at most, at random; 0.5: anywhere in their cells"},
    {.key = "seed",
     .kind = integer,
     .range = at_least(0.0),
     .default_value = 1.0,
     .doc = "of Poisson points and jitter"},
    {.key = "initial_velocity", .kind = vector, .unit = "m/s", .default_text = "[0, 0, 0]", .doc = "of the centre"},
    {.key = "initial_angular_velocity",
     .kind = vector,
     .unit = "rad/s",
     .default_text = "[0, 0, 0]",
     .doc = "about the centre of mass"},
};
constexpr ParamSpec kColliderTable[] = {
    {.key = "name", .kind = text, .optional = true, .doc = "default: collider N"},
    {.key = "shape", .kind = table, .doc = "{ type = plane, box, sphere, cylinder or mesh, its parameters }"},
    {.key = "contact",
     .kind = choice,
     .default_text = "separate",
     .choices = "sticky|slip|separate",
     .doc = "separate lets material leave; slip holds its normal motion; sticky holds all"},
    {.key = "friction", .range = at_least(0.0), .default_value = 0.0, .doc = "Coulomb coefficient"},
    {.key = "velocity", .kind = vector, .unit = "m/s", .default_text = "[0, 0, 0]", .doc = "of the pivot"},
    {.key = "angular_velocity",
     .kind = vector,
     .unit = "rad/s",
     .default_text = "[0, 0, 0]",
     .doc = "about the pivot; planes do not turn"},
    {.key = "pivot", .kind = vector, .unit = "m", .default_text = "[0, 0, 0]", .doc = "centre of rotation at t = 0"},
};
constexpr ParamSpec kConditionTable[] = {
    {.key = "name", .kind = text, .optional = true, .doc = "default: condition N"},
    {.key = "shape",
     .kind = table,
     .optional = true,
     .doc = "{ type = box, sphere, cylinder, mesh or plane, its parameters }: particles inside at t = 0; absent: all"},
    {.key = "body", .kind = text, .optional = true, .doc = "only particles of this body"},
    {.key = "material", .kind = text, .optional = true, .doc = "only particles of this material"},
    {.key = "velocity",
     .kind = list,
     .unit = "m/s",
     .optional = true,
     .doc = "prescribed velocity, three components, each a number or \"free\""},
    {.key = "clamped", .kind = boolean, .optional = true, .doc = "true: the same as velocity = [0, 0, 0]"},
    {.key = "acceleration", .kind = vector, .unit = "m/s^2", .optional = true, .doc = "on top of gravity"},
    {.key = "body_force", .kind = vector, .unit = "N/m^3", .optional = true, .doc = "force per reference volume"},
    {.key = "force",
     .kind = vector,
     .unit = "N",
     .optional = true,
     .doc = "total, shared out by volume; a traction: times the loaded area, on a layer of particles under it"},
    {.key = "times", .kind = list, .unit = "s", .optional = true, .doc = "rising times for `factors`"},
    {.key = "factors",
     .kind = list,
     .optional = true,
     .doc = "of the value at `times`, linear between them, constant before and after"},
};
constexpr ParamSpec kCrackTable[] = {
    {.key = "name", .kind = text, .optional = true, .doc = "default: crack N"},
    {.key = "shape",
     .kind = table,
     .doc = "{ type = rectangle, disc, plane or mesh, its parameters }: bonds that cross it at t = 0 are broken"},
    {.key = "body", .kind = text, .optional = true, .doc = "only bonds of this body"},
};
constexpr ParamSpec kOutputTable[] = {
    {.key = "fields", .kind = list, .default_text = "[\"x\", \"v\", \"id\"]", .doc = "particle fields in frames"},
    {.key = "formats",
     .kind = list,
     .default_text = "[\"hdf5\"]",
     .doc = "file formats; an empty list writes no frames"},
};
constexpr ParamSpec kBoxTable[] = {
    {.key = "min", .kind = vector, .unit = "m", .doc = "lower corner"},
    {.key = "max", .kind = vector, .unit = "m", .doc = "upper corner"},
};
constexpr ParamSpec kSphereTable[] = {
    {.key = "center", .kind = vector, .unit = "m", .doc = "centre"},
    {.key = "radius", .unit = "m", .range = above(0.0), .doc = "radius"},
};
constexpr ParamSpec kCylinderTable[] = {
    {.key = "start", .kind = vector, .unit = "m", .doc = "one end of the axis"},
    {.key = "end", .kind = vector, .unit = "m", .doc = "other end of the axis"},
    {.key = "radius", .unit = "m", .range = above(0.0), .doc = "radius"},
};
constexpr ParamSpec kRectangleTable[] = {
    {.key = "corner", .kind = vector, .unit = "m", .doc = "one corner"},
    {.key = "edge_u", .kind = vector, .unit = "m", .doc = "from there to the next corner"},
    {.key = "edge_v", .kind = vector, .unit = "m", .doc = "from there to the other next corner, at right angles"},
};
constexpr ParamSpec kDiscTable[] = {
    {.key = "center", .kind = vector, .unit = "m", .doc = "centre"},
    {.key = "normal", .kind = vector, .doc = "at right angles to the disc; any length"},
    {.key = "radius", .unit = "m", .range = above(0.0), .doc = "radius"},
};
constexpr ParamSpec kPolylineTable[] = {
    {.key = "points", .kind = list, .unit = "m", .doc = "corners of the line, two or more points"},
};
constexpr ParamSpec kPlaneTable[] = {
    {.key = "point", .kind = vector, .unit = "m", .doc = "a point of the plane"},
    {.key = "normal", .kind = vector, .doc = "points out of the solid half; any length"},
};
constexpr ParamSpec kMeshTable[] = {
    {.key = "file",
     .kind = text,
     .doc = "triangle mesh (obj, ply, stl, gltf, glb), relative to the scene; closed unless for a sheet or a crack"},
    {.key = "scale", .range = above(0.0), .default_value = 1.0, .doc = "applied first"},
    {.key = "rotation",
     .kind = vector,
     .unit = "deg",
     .default_text = "[0, 0, 0]",
     .doc = "about x, then y, then z through the origin"},
    {.key = "translation", .kind = vector, .unit = "m", .default_text = "[0, 0, 0]", .doc = "applied last"},
};
constexpr ParamSpec kRampTable[] = {
    {.key = "from", .doc = "value at `start` and before, in the parameter's unit"},
    {.key = "to", .doc = "value at `end` and beyond, in the parameter's unit"},
    {.key = "start", .kind = vector, .unit = "m", .doc = "where the ramp begins"},
    {.key = "end", .kind = vector, .unit = "m", .doc = "where the ramp ends"},
};

SectionDoc section(const char* topic, const char* name, const char* doc, std::span<const ParamSpec> keys) {
    return {topic, name, doc, {keys.begin(), keys.end()}};
}

}  // namespace

namespace keys {
constinit const std::span<const ParamSpec> kScene = kSceneTable;
constinit const std::span<const ParamSpec> kSimulation = kSimulationTable;
constinit const std::span<const ParamSpec> kGrid = kGridTable;
constinit const std::span<const ParamSpec> kDomain = kDomainTable;
constinit const std::span<const ParamSpec> kFaces = kFacesTable;
constinit const std::span<const ParamSpec> kMaterial = kMaterialTable;
constinit const std::span<const ParamSpec> kBody = kBodyTable;
constinit const std::span<const ParamSpec> kCollider = kColliderTable;
constinit const std::span<const ParamSpec> kCondition = kConditionTable;
constinit const std::span<const ParamSpec> kCrack = kCrackTable;
constinit const std::span<const ParamSpec> kOutput = kOutputTable;
constinit const std::span<const ParamSpec> kBox = kBoxTable;
constinit const std::span<const ParamSpec> kSphere = kSphereTable;
constinit const std::span<const ParamSpec> kCylinder = kCylinderTable;
constinit const std::span<const ParamSpec> kRectangle = kRectangleTable;
constinit const std::span<const ParamSpec> kDisc = kDiscTable;
constinit const std::span<const ParamSpec> kPolyline = kPolylineTable;
constinit const std::span<const ParamSpec> kPlane = kPlaneTable;
constinit const std::span<const ParamSpec> kMesh = kMeshTable;
}  // namespace keys

std::vector<SectionDoc> scene_reference() {
    return {
        section("scene", "top level", "all quantities in SI units, Y up", kSceneTable),
        section("simulation", "[simulation]", "duration, frames and time step", kSimulationTable),
        section("grid", "[grid]", "background grid", kGridTable),
        section("domain", "domain = { ... }", "in [grid]", kDomainTable),
        section("faces", "faces = { ... }", "in a domain", kFacesTable),
        section("material", "[material.NAME]", "one solid material", kMaterialTable),
        section("ramp", "{ from, to, start, end }", "a ramp, in place of a number that may vary per particle",
                kRampTable),
        section("body", "[[body]]", "one solid made of particles", kBodyTable),
        section("collider", "[[collider]]", "one rigid obstacle", kColliderTable),
        section("condition", "[[condition]]", "a boundary condition or load on a region", kConditionTable),
        section("crack", "[[crack]]", "a cut that is there from the start", kCrackTable),
        section("box", "shape = { type = \"box\" }", "box along the axes", kBoxTable),
        section("sphere", "shape = { type = \"sphere\" }", "ball", kSphereTable),
        section("cylinder", "shape = { type = \"cylinder\" }", "solid cylinder", kCylinderTable),
        section("rectangle", "shape = { type = \"rectangle\" }", "sheet; bodies with a thickness, and cracks",
                kRectangleTable),
        section("disc", "shape = { type = \"disc\" }", "flat round piece; cracks only", kDiscTable),
        section("polyline", "shape = { type = \"polyline\" }", "strand; bodies with a cross_section only",
                kPolylineTable),
        section("plane", "shape = { type = \"plane\" }",
                "half space below a plane; colliders and conditions; the plane itself: cracks", kPlaneTable),
        section("mesh", "shape = { type = \"mesh\" }",
                "solid inside a mesh, or with a thickness its surface; cracks: its surface", kMeshTable),
        section("output", "[output]", "what the folder of a run holds besides run.json and energy.csv", kOutputTable),
    };
}

}  // namespace perimpm
