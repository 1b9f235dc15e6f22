#pragma once

#include "perimpm/transfer/stencils.hpp"

/*! Grid to particles: the velocity, its gradient and its first moments
      (1) v = sum_I w_I v_I,   G_j = sum_I v_I dw_I/dx_j,   M_j = sum_I w_I v_I d_Ij
    contracted along z, y and x in turn; M is taken about the stencil's first node and moved to the particle afterwards,
    M_j = sum_I w_I v_I (node index)_j - offset_j v. Particles of one cell read the same nodes: lanes are a group of them,
    for one component after the other, or where a cell has but a few, (particle) x (three components). */
namespace perimpm::bspline {

/// What a batch of particles reads from one tile: [axis][component], moments about the stencil's first node.
template <class Real, bool Gradient, bool Moment>
struct Samples {
    Lanes<Real> v[3], gradient[Gradient ? 3 : 1][3], moment[Moment ? 3 : 1][3];
};

template <class V, bool Gradient, bool Moment>
struct Sums {
    V v, gradient[Gradient ? 3 : 1], moment[Moment ? 3 : 1];
};

/// Adds to a sum that starts with its first term, a product that compilers would else merge into the second one, with a
/// multiply-add in place of the sum.
template <bool first, class V>
PERIMPM_INLINE void add(V& sum, const V& term) {
    sum = first ? rounded(term) : V(sum + term);
}

/// The sums over one stencil; at(i, j, k) is what its nodes hold. Nodes are taken from the last to the first: the sum over
/// k of k w_k v_k is the sum of the partial sums w_Order v_Order + .. + w_k v_k for k > 0.
template <bool Gradient, bool Moment, int Order, class V, class Node>
PERIMPM_INLINE Sums<V, Gradient, Moment> contract(const BSplineWeights<V, Order> weights[3], Node at) {
    using S = Sums<V, Gradient, Moment>;
    const auto &x = weights[0], &y = weights[1], &z = weights[2];
    S total;
    unrolled<Order + 1>([&](auto from_last_i) PERIMPM_INLINE_LAMBDA {
        constexpr int i = Order - from_last_i;
        constexpr bool last_i = i == Order;
        S slab;
        unrolled<Order + 1>([&](auto from_last_j) PERIMPM_INLINE_LAMBDA {
            constexpr int j = Order - from_last_j;
            constexpr bool last_j = j == Order;
            S column;
            unrolled<Order + 1>([&](auto from_last_k) PERIMPM_INLINE_LAMBDA {
                constexpr int k = Order - from_last_k;
                const V node = at(i, j, k);
                add<k == Order>(column.v, V(z.w[k] * node));
                if constexpr (Gradient) add<k == Order>(column.gradient[2], V(z.dw[k] * node));
                if constexpr (Moment && k > 0) add<k == Order>(column.moment[2], column.v);
            });
            add<last_j>(slab.v, V(y.w[j] * column.v));
            if constexpr (Gradient) {
                add<last_j>(slab.gradient[1], V(y.dw[j] * column.v));
                add<last_j>(slab.gradient[2], V(y.w[j] * column.gradient[2]));
            }
            if constexpr (Moment && j > 0) add<last_j>(slab.moment[1], slab.v);
            if constexpr (Moment) add<last_j>(slab.moment[2], V(y.w[j] * column.moment[2]));
        });
        add<last_i>(total.v, V(x.w[i] * slab.v));
        if constexpr (Gradient) add<last_i>(total.gradient[0], V(x.dw[i] * slab.v));
        if constexpr (Moment && i > 0) add<last_i>(total.moment[0], total.v);
        for (int axis = 1; axis < 3; ++axis) {
            if constexpr (Gradient) add<last_i>(total.gradient[axis], V(x.w[i] * slab.gradient[axis]));
            if constexpr (Moment) add<last_i>(total.moment[axis], V(x.w[i] * slab.moment[axis]));
        }
    });
    return total;
}

/// A group of particles from number p, whose stencils begin at `tile`: a component at a time.
template <int Order, bool Gradient, bool Moment, class Real>
PERIMPM_INLINE void sample_group(const Real* tile, const Lanes<Real> offset[3], std::size_t p,
                                 Samples<Real, Gradient, Moment>& out) {
    using Weights = BSplineWeights<Group<Real>, Order>;
    const Weights weights[3] = {Weights(offset[0].group(p)), Weights(offset[1].group(p)), Weights(offset[2].group(p))};
    for (int c = 0; c < 3; ++c) {
        const auto sums = contract<Gradient, Moment>(weights, [&](int i, int j, int k) PERIMPM_INLINE_LAMBDA {
            return tile[i * kSlabStride + j * kRowStride + 4 * k + c];
        });
        out.v[c].store(p, sums.v);
        for (int axis = 0; Gradient && axis < 3; ++axis) out.gradient[axis][c].store(p, sums.gradient[axis]);
        for (int axis = 0; Moment && axis < 3; ++axis) out.moment[axis][c].store(p, sums.moment[axis]);
    }
}

/// The same of kCount particles, all components at once: a third of the time where there are no more. A function of its
/// own leaves the registers to the usual case.
template <int Order, std::size_t kCount, bool Gradient, bool Moment, class Real>
[[gnu::noinline]] void sample_few(const Real* tile, const Lanes<Real> offset[3], std::size_t p,
                                  Samples<Real, Gradient, Moment>& out) {
    using F = Few<Real, kCount>;
    using Weights = BSplineWeights<typename F::Pack, Order>;
    const auto along = [&](int axis) PERIMPM_INLINE_LAMBDA { return Weights(F::spread(offset[axis].values + p)); };
    const Weights weights[3] = {along(0), along(1), along(2)};
    const auto sums = contract<Gradient, Moment>(weights, [&](int i, int j, int k) PERIMPM_INLINE_LAMBDA {
        return F::repeat(tile + i * kSlabStride + j * kRowStride + 4 * k);
    });
    const auto store = [&](Lanes<Real> to[3], const typename F::Pack& sum) PERIMPM_INLINE_LAMBDA {
        F::store(sum, to[0].values + p, to[1].values + p, to[2].values + p);
    };
    store(out.v, sums.v);
    for (int axis = 0; Gradient && axis < 3; ++axis) store(out.gradient[axis], sums.gradient[axis]);
    for (int axis = 0; Moment && axis < 3; ++axis) store(out.moment[axis], sums.moment[axis]);
}

template <int Order, bool Gradient, bool Moment, class Real>
void sample_tile(const Real* tile, const Real* nodes, const Lanes<Real> offset[3], Samples<Real, Gradient, Moment>& out,
                 std::size_t size) {
    constexpr std::size_t kAtMost = 2;  // in a cell: more take less time as a group
    constexpr std::size_t kTogether = std::min(kLanes<Real>, 32 / sizeof(Real)) / 4;  // 64 bytes are no faster here
    constexpr std::size_t kFew = kTogether > 0 ? kAtMost : 0;
    for_each_cell(nodes, size, [&](std::size_t p, std::size_t end, std::int32_t node) PERIMPM_INLINE_LAMBDA {
        for (; p + kFew < end; p += kGroup<Real>) sample_group<Order>(tile + node, offset, p, out);
        if constexpr (kFew > 0)
            for (; p < end; p += kTogether) sample_few<Order, kTogether>(tile + node, offset, p, out);
    });
}

/// Particles to be asked for in advance: a dozen streams, which the processor does not follow by itself.
inline constexpr std::size_t kAhead = 128;

/// F <- (I + dt grad v) F.
template <class Real>
PERIMPM_INLINE void update_deformation(const Field<Real>& F, std::size_t at, std::size_t count,
                                       const Pack<Real> dt_gradient[3][3]) {
    using P = Pack<Real>;
    unrolled<3>([&](auto j) PERIMPM_INLINE_LAMBDA {
        const P f[3] = {load(F[j] + at, count), load(F[3 + j] + at, count), load(F[6 + j] + at, count)};
        unrolled<3>([&](auto i) PERIMPM_INLINE_LAMBDA {
            store(F[3 * i + j] + at,
                  P(f[i] + dt_gradient[i][0] * f[0] + dt_gradient[i][1] * f[1] + dt_gradient[i][2] * f[2]), count);
        });
    });
}

/// Scheme::velocity(v, now, before) gives a component of the particles' new velocity.
template <class Scheme, class Real, int Order, bool mls, bool Local>
void gather(TransferBlock<Real>& b, const Scheme& scheme) {
    using P = Pack<Real>;
    constexpr bool gradient = Local && !mls;
    constexpr bool moment = Scheme::affine || (Local && mls);
    const Real dt = b.dt, inverse_spacing = 1 / b.spacing;
    const Real moment_scale = inverse_spacing * Real(1 / kCarriedMoment<Order>);
    P fastest(0), total(0);
    for_each_batch(b.size, [&](std::size_t first, std::size_t size) PERIMPM_INLINE_LAMBDA {
        alignas(64) Real node[kBatch];
        Lanes<Real> offset[3];  // from a stencil's first node to the particle, in dx
        Samples<Real, gradient, moment> now;
        Samples<Real, false, false> before;
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            if constexpr (Local) {
                const std::size_t ahead = first + p + kAhead;
                for (int c = 0; c < 3; ++c) __builtin_prefetch(b.x[c] + ahead, 0, 2);
                for (int c = 0; c < 9; ++c) __builtin_prefetch(b.F[c] + ahead, 0, 2);
            }
            const Splines<Real, Order> splines(b.x, first + p, std::min(kLanes<Real>, size - p), inverse_spacing);
            splines.node(b.origin).copy_to(node + p, std::experimental::element_aligned);
            for (int c = 0; c < 3; ++c) offset[c].store_pack(p, splines.axis[c].offset);
        }
        sample_tile<Order>(b.tile, node, offset, now, size);
        if constexpr (Scheme::increment) sample_tile<Order>(b.increment, node, offset, before, size);
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            const std::size_t at = first + p, count = std::min(kLanes<Real>, size - p);
            P v[3], speed2(0);
            unrolled<3>([&](auto c) PERIMPM_INLINE_LAMBDA {
                v[c] = now.v[c].pack(p);
                const P old = Scheme::increment ? before.v[c].pack(p) : P(0);
                store(b.x[c] + at, P(load(b.x[c] + at, count) + dt * v[c]), count);
                store(b.v[c] + at, scheme.velocity(load(b.v[c] + at, count), v[c], old), count);
                speed2 += v[c] * v[c];
            });
            where(!first_lanes<Real>(count), speed2) = P(0);
            fastest = larger(fastest, speed2);
            total += speed2;
            P dt_gradient[3][3];  // [component][direction]
            unrolled<3>([&](auto j) PERIMPM_INLINE_LAMBDA {
                const P from_first = offset[j].pack(p);
                unrolled<3>([&](auto c) PERIMPM_INLINE_LAMBDA {
                    if constexpr (gradient) dt_gradient[c][j] = dt * (inverse_spacing * now.gradient[j][c].pack(p));
                    if constexpr (moment) {
                        const P M = moment_scale * (now.moment[j][c].pack(p) - from_first * v[c]);
                        if constexpr (Scheme::affine) store(b.C[3 * c + j] + at, M, count);
                        if constexpr (mls) dt_gradient[c][j] = dt * M;
                    }
                });
            });
            if constexpr (Local) update_deformation(b.F, at, count, dt_gradient);
        }
    });
    b.fastest2 = hmax(fastest);
    b.sum2 = reduce(total);
}

}  // namespace perimpm::bspline
