#pragma once

#include <algorithm>

#include "perimpm/math/simd.hpp"
#include "perimpm/model/block.hpp"

namespace perimpm::peridynamics {

/// Calls body(row, begin, end) for the rows of the block, [begin, end) their particles as numbers of the block.
template <class Real, class Body>
void for_each_row(const Block<Real>& b, Body body) {
    const LatticeRows<Real>& rows = b.family.rows;
    const LatticeRow* const all = rows.row + rows.count;
    const auto* row =
        std::partition_point(rows.row, all, [&](const LatticeRow& each) { return each.first + each.size <= b.first; });
    for (; row != all && row->first < b.first + b.size; ++row)
        body(*row, std::max(row->first, b.first) - b.first,
             std::min(row->first + row->size, b.first + b.size) - b.first);
}

/*! sum w V_q H_q X over the families of a row of a lattice, H a 3x3 field: a convolution along the row. Particle q of a
    neighbouring row gives to the one d places before it
      w_d V H_q (X_0 + d h e),  X_0 across the rows, e along them, h the spacing,
    and d places behind it the same with -d. So H_q is read once for all d, multiplied with X_0 and e once, and summed over
    the neighbouring rows by the place of q:
      even_d = sum w_d V H X_0,  odd_d = sum w_d V d h H e,
      sum at place z = even_0(z) + sum_d (even_d + odd_d)(z + d) + (even_d - odd_d)(z - d).
    One component and a few packs of places at a time: their sums stay in registers. */
template <class Real>
class RowSums {
    using P = Pack<Real>;
    using Neighbour = RowNeighbour<Real>;
    static constexpr std::int32_t kReach = Neighbour::kMostReach, kLanesOfPack = kLanes<Real>;
    static constexpr std::int32_t kPacks = kRegisters < 32 ? 2 : 3;  ///< whose sums registers hold
    static constexpr std::int32_t kPlaces = 64;  ///< whose sums are kept: a few packs, in the first-level cache

public:
    RowSums(const LatticeRows<Real>& rows, const LatticeRow& row, const Field<Real>& H)
        : row_{row},
          axis_{(row.axis + 1) % 3, (row.axis + 2) % 3, row.axis},
          first_{rows.neighbour + row.neighbours},
          last_{first_ + row.count},
          H_{H} {}

    /// Component r of the sums of the places [begin, end) of the row, to `to`, where the row begins.
    void operator()(std::size_t r, std::int32_t begin, std::int32_t end, Real* to) {
        constexpr std::int32_t kStrip = kPlaces - 2 * kReach;
        for (std::int32_t from = begin; from < end; from += kStrip) {
            const std::int32_t behind = std::min(from + kStrip, end);
            sum_by_source(r, from, behind);
            for (std::int32_t place = from; place < behind; place += kLanesOfPack)
                store(to + place, sum_at(place, from), static_cast<std::size_t>(behind - place));
        }
    }

private:
    /// Sums for one distance along the row, by place of q, from `kReach` before the strip on.
    struct Shifted {
        alignas(P) Real numbers[kPlaces + 2 * kLanesOfPack];
    };
    std::int32_t reach() const { return static_cast<std::int32_t>(first_->reach); }

    void sum_by_source(std::size_t r, std::int32_t from, std::int32_t to) {
        const std::int32_t begin = std::max(from - reach(), row_.begin), end = std::min(to + reach(), row_.end),
                           first_whole = std::max(begin, row_.whole_begin), end_whole = std::min(end, row_.whole_end);
        for (std::int32_t place = begin; place < end;) {
            // the last pack of whole places goes back over some of the one before
            const std::int32_t start = std::min(place, end_whole - kLanesOfPack);
            if (place >= end_whole || start < first_whole) {
                sum_packs<1, false>(r, place, from);
                place += kLanesOfPack;
                continue;
            }
            const std::int32_t whole = end_whole - start;
            if (whole > 2 * kLanesOfPack && kPacks > 2)
                sum_packs<kPacks, true>(r, place = start, from, whole);
            else if (whole > kLanesOfPack)
                sum_packs<2, true>(r, place = start, from, whole);
            else
                sum_packs<1, true>(r, place = start, from, whole);
            place += std::min(kPacks * kLanesOfPack, whole);
        }
        for (std::int32_t d = -reach(); d <= reach(); ++d) {
            for (std::int32_t place = from - reach(); place < begin; ++place) *shifted(d, from, place) = Real(0);
            for (std::int32_t place = end; place < to + reach(); ++place) *shifted(d, from, place) = Real(0);
        }
    }

    template <int kTogether>
    struct Sums {
        P even[kReach + 1][kTogether], odd[kReach + 1][kTogether];
    };

    /// Packs one after the other from `place` on, the last one at most at the end of `whole` places. `kWhole`: every
    /// neighbour of reach > 0 has a particle at every place.
    template <int kTogether, bool kWhole>
    [[gnu::noinline]] void sum_packs(std::size_t r, std::int32_t place, std::int32_t from,
                                     std::int32_t whole = kTogether * kLanesOfPack) {
        Sums<kTogether> sums;
        unrolled<kTogether>([&](auto k) PERIMPM_INLINE_LAMBDA {
            unrolled<kReach + 1>([&](auto d) PERIMPM_INLINE_LAMBDA { sums.even[d][k] = sums.odd[d][k] = P(0); });
        });
        const Real* fields[3];  // H e for the axes e across the row and, last, along it, at the place
        for (std::size_t c = 0; c < 3; ++c) fields[c] = H_[3 * r + axis_[c]] + row_.first + place;
        const std::int32_t last = std::min((kTogether - 1) * kLanesOfPack, whole - kLanesOfPack);
        const auto further = [&](int k) PERIMPM_INLINE_LAMBDA { return k + 1 < kTogether ? k * kLanesOfPack : last; };
        const auto read = [&](const Neighbour& n, std::size_t c, int k) PERIMPM_INLINE_LAMBDA {
            return P(fields[c] + n.offset + further(k), std::experimental::element_aligned);
        };
        const auto read_some = [&](const Neighbour& n, std::size_t c, int k) PERIMPM_INLINE_LAMBDA {
            return load_between(fields[c] + n.offset + further(k), n.begin - place - further(k),
                                n.end - place - further(k));
        };
        const Neighbour* n = first_;
        unrolled<kReach>([&](auto less) PERIMPM_INLINE_LAMBDA {
            constexpr int kOwnReach = kReach - less;
            for (; n != last_ && n->reach == kOwnReach; ++n)
                if constexpr (kWhole)
                    add<kOwnReach>(*n, read, sums);
                else
                    add<kOwnReach>(*n, read_some, sums);
        });
        for (; n != last_; ++n)
            if (place >= n->begin && place + last + kLanesOfPack <= n->end)
                add_single(*n, read, sums);
            else
                add_single(*n, read_some, sums);
        unrolled<kTogether>([&](auto k) PERIMPM_INLINE_LAMBDA {
            const auto put = [&](int d, const P& sum) PERIMPM_INLINE_LAMBDA {
                sum.copy_to(shifted(d, from, place + further(k)), std::experimental::element_aligned);
            };
            put(0, sums.even[0][k]);
            unrolled<kReach>([&](auto before) PERIMPM_INLINE_LAMBDA {
                constexpr int d = before + 1;
                if (d > reach()) return;
                put(d, sums.even[d][k] + sums.odd[d][k]), put(-d, sums.even[d][k] - sums.odd[d][k]);
            });
        });
    }

    template <int kOwnReach, int kTogether, class Read>
    PERIMPM_INLINE static void add(const Neighbour& n, const Read& read, Sums<kTogether>& sums) {
        P across[kTogether], along[kTogether];
        unrolled<kTogether>([&](auto k) PERIMPM_INLINE_LAMBDA {
            // every instance of this code must round alike, in whatever packs a place is summed
            across[k] = rounded(read(n, 0, k) * P(n.across[0]));
            across[k] += read(n, 1, k) * P(n.across[1]);
            along[k] = read(n, 2, k);
        });
        unrolled<kOwnReach + 1>([&](auto d) PERIMPM_INLINE_LAMBDA {
            unrolled<kTogether>([&](auto k) PERIMPM_INLINE_LAMBDA {
                sums.even[d][k] += across[k] * P(n.weight[d]);
                if (d > 0) sums.odd[d][k] += along[k] * P(n.along[d]);
            });
        });
    }
    /// A neighbour of reach 0.
    template <int kTogether, class Read>
    PERIMPM_INLINE static void add_single(const Neighbour& n, const Read& read, Sums<kTogether>& sums) {
        unrolled<3>([&](auto c) PERIMPM_INLINE_LAMBDA {
            unrolled<kTogether>([&](auto k)
                                    PERIMPM_INLINE_LAMBDA { sums.even[0][k] += read(n, c, k) * P(n.across[c]); });
        });
    }

    PERIMPM_INLINE P sum_at(std::int32_t place, std::int32_t from) {
        const auto kept = [&](std::int32_t d) {
            return P(shifted(d, from, place + d), std::experimental::element_aligned);
        };
        P sum = kept(0);
        for (std::int32_t d = 1; d <= reach(); ++d) sum += kept(d) + kept(-d);
        return sum;
    }

    /// Where the sum for q at a place is kept, for bonds d along the row; `from`: where the strip begins.
    Real* shifted(std::int32_t d, std::int32_t from, std::int32_t place) {
        return kept_[kReach + d].numbers + kReach + place - from;
    }

    LatticeRow row_;
    std::size_t axis_[3];  ///< two across the row, and along it
    const Neighbour *first_, *last_;
    Field<Real> H_;
    Shifted kept_[2 * kReach + 1];
};

}  // namespace perimpm::peridynamics
