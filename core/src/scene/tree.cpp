#include "perimpm/scene/tree.hpp"

#include <fmt/format.h>

namespace perimpm {
namespace {

template <class Table>
auto* find_in(Table* table, const std::string& key) {
    decltype(&table->front().second) found = nullptr;
    if (!table) return found;
    for (auto& entry : *table) {
        if (entry.first == key) found = &entry.second;
    }
    return found;
}

}  // namespace

std::string Place::text() const {
    if (file.empty()) return path;
    if (line == 0) return file;
    return fmt::format("{}:{}:{}", file, line, column);
}

const Value* Value::find(const std::string& key) const { return find_in(std::get_if<Table>(&data), key); }
Value* Value::find(const std::string& key) { return find_in(std::get_if<Table>(&data), key); }

std::string Value::kind() const {
    struct Names {
        const char* operator()(std::monostate) const { return "nothing"; }
        const char* operator()(bool) const { return "a boolean"; }
        const char* operator()(std::int64_t) const { return "an integer"; }
        const char* operator()(double) const { return "a number"; }
        const char* operator()(const std::string&) const { return "a text"; }
        const char* operator()(const List&) const { return "a list"; }
        const char* operator()(const Table&) const { return "a table"; }
    };
    return std::visit(Names{}, data);
}

void set_path(Value& value, const std::string& path) {
    value.place.path = path;
    const std::string prefix = path.empty() ? "" : path + ".";
    if (auto* table = std::get_if<Value::Table>(&value.data)) {
        for (auto& [key, entry] : *table) set_path(entry, prefix + key);
    } else if (auto* list = std::get_if<Value::List>(&value.data)) {
        for (std::size_t i = 0; i < list->size(); ++i) set_path((*list)[i], prefix + std::to_string(i));
    }
}

}  // namespace perimpm
