#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perimpm/model/params.hpp"
#include "perimpm/scene/tree.hpp"

namespace perimpm {

/// A parameter that varies over a body: `from` at `start` and before, `to` at `end` and beyond, linear between.
struct Ramp {
    double from, to;                   ///< in the parameter's unit
    std::array<double, 3> start, end;  ///< [m]
};

struct ModelSpec;

/// Checked values of one scene table against its declaration; the only place where keys, types and ranges are judged.
/// The table must outlive the reader.
class PERIMPM_API Reader {
public:
    /// Throws InputError for the first unknown key (with the closest one), missing key, wrong type or value out of
    /// range. `what` names the table in messages, e.g. "body 0" or "material.rubber.constitutive ('pd_elastic')".
    /// Keys in `extra` are let through unread (a model's "type", which was looked at before).
    Reader(const Value& table, std::span<const ParamSpec> specs, std::string what,
           std::span<const char* const> extra = {});

    double number(const char* key) const;
    std::int64_t integer(const char* key) const;
    bool flag(const char* key) const;
    std::string text(const char* key) const;
    /// Fixed-length list of numbers, e.g. a point; `fallback` when absent and optional.
    std::array<double, 3> vector(const char* key, std::array<double, 3> fallback = {}) const;
    bool given(const char* key) const;
    /// The raw value, for tables and lists; null when absent.
    const Value* value(const char* key) const;
    /// The ramp { from, to, start, end } that the scene gives for a per-particle parameter; `number` is its `from`.
    std::optional<Ramp> ramp(const char* key) const;
    /// The model that a key of kind `model` names; null when absent.
    const ModelSpec* model(const char* key) const;
    /// The values as a plugin receives them; texts live as long as the table.
    std::span<const ParamValue> values() const { return values_; }
    std::span<const ParamSpec> specs() const { return specs_; }
    const Value& table() const { return *table_; }
    const std::string& what() const { return what_; }
    /// Throws InputError at the place of `key`; "law.key" is the key of the model that `law` names.
    [[noreturn]] void fail(const char* key, const std::string& message) const;

private:
    std::size_t index(const char* key) const;
    void refuse_unknown_keys(std::span<const char* const> extra) const;
    ParamValue read(const ParamSpec& spec);
    const ModelChoice* read_inner(const Value& table, const ParamSpec& spec);

    const Value* table_;
    std::span<const ParamSpec> specs_;
    std::string what_;
    std::vector<ParamValue> values_;
    struct Inner;
    std::vector<std::shared_ptr<const Inner>> inner_;
};

/// Reads "type" of a table that chooses a model or shape; the error lists `accepted`. Empty: any text is accepted.
PERIMPM_API std::string read_type(const Value& table, const std::string& what,
                                  const std::vector<std::string>& accepted);

}  // namespace perimpm
