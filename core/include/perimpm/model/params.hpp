#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "perimpm/export.hpp"

namespace perimpm {

/// model: a constitutive law inside a model, { type = plugin, its parameters }.
enum class ParamKind : std::uint32_t { number, integer, boolean, text, choice, vector, table, list, model };

/// Allowed values of a number; open ends exclude the bound itself.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_open = true;
    bool high_open = true;
};
constexpr Range above(double low) { return {.low = low}; }
constexpr Range at_least(double low) { return {.low = low, .low_open = false}; }
constexpr Range open(double low, double high) { return {.low = low, .high = high}; }
constexpr Range closed(double low, double high) {
    return {.low = low, .high = high, .low_open = false, .high_open = false};
}

inline constexpr double kRequired = std::numeric_limits<double>::quiet_NaN();

/// Declaration of one key of a scene table: parsing, errors, `describe` and the reference page all come from it.
struct ParamSpec {
    const char* key;
    ParamKind kind = ParamKind::number;
    const char* unit = "1";
    Range range = {};
    double default_value = kRequired;    ///< numbers, integers, booleans (0 or 1)
    const char* default_text = nullptr;  ///< texts and choices; for the other kinds only shown
    const char* choices = nullptr;       ///< "a|b|c"; for kinds other than choice: words accepted instead of a value
    bool optional = false;               ///< may be absent without having a default
    bool per_particle = false;           ///< may be given as a ramp over the body, one value per particle
    const char* doc = "";
};

struct ModelChoice;

/// One value as it crosses the library border; `given` tells whether the scene gave it or the default stands.
struct ParamValue {
    double number = kRequired;
    const char* text = nullptr;
    bool given = false;
    const ModelChoice* model = nullptr;
    double vector[3] = {kRequired, kRequired, kRequired};
};

/// A model that a parameter names: its plugin and its own checked values.
struct ModelChoice {
    const char* type;
    const ParamSpec* specs;
    const ParamValue* values;
    std::uint32_t count;
};

/// Share of a neighbour's volume that counts in a bond of length |X|: clip((radius - |X|)/rim + 1/2, 0, 1), and all of it
/// where rim = 0. Metres.
struct BondVolumes {
    double radius = 0, rim = 0;

    double operator()(double X) const {
        return rim > 0 ? std::fmin(std::fmax((radius - X) / rim + 0.5, 0.0), 1.0) : 1.0;
    }
};

/// What a model may ask about its surroundings; SI units, 0 where unknown.
struct ModelContext {
    double density = 0;           ///< of the material [kg/m^3]
    double particle_spacing = 0;  ///< lattice spacing h of the material's bodies [m]
    double grid_spacing = 0;      ///< dx [m]
    std::uint32_t dimension = 3;  ///< of the material's bodies: 3 solids, 2 sheets, 1 strands
    double across = 1;            ///< what a particle spans across its body: 1, thickness [m], cross-section [m^2]
    double opening_energy = 0;    ///< criteria: LawNeeds::opening_energy of the material's law [J/m^2]
    double horizon = 0;           ///< criteria: LawNeeds::horizon of the material's law [m]
    BondVolumes volumes = {};     ///< criteria: LawNeeds::volumes of the material's law
};

/// Read access for a model's constructor. A key that the model's table does not declare is a programming error.
class PERIMPM_API Params {
public:
    Params(const ParamSpec* specs, const ParamValue* values, std::uint32_t count, ModelContext context)
        : specs_{specs}, values_{values}, count_{count}, context_{context} {}

    double operator[](const char* key) const { return at(key).number; }
    const char* text(const char* key) const { return at(key).text; }
    bool flag(const char* key) const { return at(key).number != 0.0; }
    /// Three numbers; NaN when an optional key is absent.
    const double* vector(const char* key) const { return at(key).vector; }
    bool given(const char* key) const { return at(key).given; }
    /// Of a key of kind `model`; null when the scene does not give it.
    const ModelChoice* model(const char* key) const { return at(key).model; }
    /// True when the text or choice `key` has the value `value`.
    bool is(const char* key, const char* value) const;
    const ModelContext& context() const { return context_; }

private:
    const ParamValue& at(const char* key) const;

    const ParamSpec* specs_;
    const ParamValue* values_;
    std::uint32_t count_;
    ModelContext context_;
};

}  // namespace perimpm
