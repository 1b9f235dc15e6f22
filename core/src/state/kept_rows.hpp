#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace perimpm {

/// Where rows are kept, those of the same bits once.
class KeptRows {
public:
    struct Row {
        std::size_t first, size;
    };
    std::vector<Row> rows;

    /// First item of the kept row that is_same(first) as one of this hash and size; a new row is kept at `otherwise`.
    template <class Same>
    std::size_t find(std::size_t hash, std::size_t size, std::size_t otherwise, const Same& is_same) {
        for (auto [known, end] = known_.equal_range(hash); known != end; ++known) {
            const Row& row = rows[known->second];
            if (row.size == size && is_same(row.first)) return row.first;
        }
        known_.emplace(hash, rows.size());
        rows.push_back({otherwise, size});
        return otherwise;
    }

private:
    std::unordered_multimap<std::size_t, std::size_t> known_;
};

template <class T>
std::string_view bits(const T* first, std::size_t size) {
    return {reinterpret_cast<const char*>(first), size * sizeof(T)};
}

/// Rows of plain data.
template <class T>
struct Rows {
    std::vector<T> items;
    KeptRows kept;

    /// Index of the row's first item.
    std::size_t keep(const std::vector<T>& row) {
        const std::string_view own = bits(row.data(), row.size());
        const std::size_t first = kept.find(std::hash<std::string_view>()(own), row.size(), items.size(),
                                            [&](std::size_t at) { return bits(items.data() + at, row.size()) == own; });
        if (first == items.size()) items.insert(items.end(), row.begin(), row.end());
        return first;
    }
};

}  // namespace perimpm
