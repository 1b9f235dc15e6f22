#pragma once

#include "perimpm/transfer/stencils.hpp"

/*! Grid to particles: the velocity, its gradient and its first moments
      (1) v = sum_I w_I v_I,   G_j = sum_I v_I dw_I/dx_j,   M_j = sum_I w_I v_I d_Ij
    contracted along z, y and x in turn; M is taken about the stencil's first node and moved to the particle afterwards,
    M_j = sum_I w_I v_I (node index)_j - offset_j v. Lanes are particles of one cell: they read the same nodes. */
namespace perimpm::bspline {

template <class Real, int Order, bool Slopes>
struct LaneWeights {
    Lanes<Real> value[3][Order + 1];
    Lanes<Real> slope[Slopes ? 3 : 1][Order + 1];  ///< d weight / d x in 1/dx

    void store(std::size_t p, const BSpline<Pack<Real>, Order> splines[3]) {
        for (int axis = 0; axis < 3; ++axis)
            for (int k = 0; k <= Order; ++k) {
                value[axis][k].store_pack(p, splines[axis].w[k]);
                if constexpr (Slopes) slope[axis][k].store_pack(p, splines[axis].dw[k]);
            }
    }
};

/// What a batch of particles reads from one tile: [axis][component], moments about the stencil's first node.
template <class Real, bool Gradient, bool Moment>
struct Samples {
    Lanes<Real> v[3], gradient[Gradient ? 3 : 1][3], moment[Moment ? 3 : 1][3];
};

/// Weights of a group of particles along one axis: w and dw/dx.
template <class Real, int Order, bool Gradient>
struct AxisWeights {
    Group<Real> value[Order + 1], slope[Gradient ? Order + 1 : 1];

    template <bool Slopes>
    AxisWeights(const LaneWeights<Real, Order, Slopes>& weight, int axis, std::size_t p) {
        for (int k = 0; k <= Order; ++k) {
            value[k] = weight.value[axis][k].group(p);
            if constexpr (Gradient) slope[k] = weight.slope[axis][k].group(p);
        }
    }
};

/// Nodes are taken from the last to the first: the sum over k of k w_k v_k is the sum of the partial sums
/// w_Order v_Order + .. + w_k v_k for k > 0.
template <class Real, int Order, bool Slopes, bool Gradient, bool Moment>
void sample_tile(const Real* tile, const Stencils<Real, Order>& s, const LaneWeights<Real, Order, Slopes>& weight,
                 Samples<Real, Gradient, Moment>& out, std::size_t size) {
    using G = Group<Real>;
    struct Sums {
        G v = 0, gradient[Gradient ? 3 : 1] = {}, moment[Moment ? 3 : 1] = {};
    };
    for_each_cell(s.node, size, [&](std::size_t begin, std::size_t end, std::int32_t node) {
        for (std::size_t p = begin; p < end; p += kGroup<Real>) {
            const AxisWeights<Real, Order, Gradient> wx(weight, 0, p), wy(weight, 1, p), wz(weight, 2, p);
            for (int c = 0; c < 3; ++c) {
                Sums total;
#pragma GCC unroll 4
                for (int i = Order; i >= 0; --i) {
                    Sums slab;
#pragma GCC unroll 4
                    for (int j = Order; j >= 0; --j) {
                        const Real* at = tile + node + i * kSlabStride + j * kRowStride + c;
                        Sums column;
#pragma GCC unroll 4
                        for (int k = Order; k >= 0; --k) {
                            column.v += wz.value[k] * at[4 * k];
                            if constexpr (Gradient) column.gradient[2] += wz.slope[k] * at[4 * k];
                            if (Moment && k > 0) column.moment[2] += column.v;
                        }
                        slab.v += wy.value[j] * column.v;
                        if constexpr (Gradient) {
                            slab.gradient[1] += wy.slope[j] * column.v;
                            slab.gradient[2] += wy.value[j] * column.gradient[2];
                        }
                        if (Moment && j > 0) slab.moment[1] += slab.v;
                        if constexpr (Moment) slab.moment[2] += wy.value[j] * column.moment[2];
                    }
                    total.v += wx.value[i] * slab.v;
                    if constexpr (Gradient) total.gradient[0] += wx.slope[i] * slab.v;
                    if (Moment && i > 0) total.moment[0] += total.v;
                    for (int axis = 1; axis < 3; ++axis) {
                        if constexpr (Gradient) total.gradient[axis] += wx.value[i] * slab.gradient[axis];
                        if constexpr (Moment) total.moment[axis] += wx.value[i] * slab.moment[axis];
                    }
                }
                out.v[c].store(p, total.v);
                for (int axis = 0; Gradient && axis < 3; ++axis) out.gradient[axis][c].store(p, total.gradient[axis]);
                for (int axis = 0; Moment && axis < 3; ++axis) out.moment[axis][c].store(p, total.moment[axis]);
            }
        }
    });
}

/// Particles to be asked for in advance: a dozen streams, which the processor does not follow by itself.
inline constexpr std::size_t kAhead = 128;

/// F <- (I + dt grad v) F.
template <class Real>
PERIMPM_INLINE void update_deformation(const Field<Real>& F, std::size_t at, std::size_t count,
                                       const Pack<Real> dt_gradient[3][3]) {
    using P = Pack<Real>;
    for (int j = 0; j < 3; ++j) {
        const P f[3] = {load(F[j] + at, count), load(F[3 + j] + at, count), load(F[6 + j] + at, count)};
        for (int i = 0; i < 3; ++i)
            store(F[3 * i + j] + at,
                  P(f[i] + dt_gradient[i][0] * f[0] + dt_gradient[i][1] * f[1] + dt_gradient[i][2] * f[2]), count);
    }
}

/// Scheme::velocity(v, now, before) gives a component of the particles' new velocity.
template <class Scheme, class Real, int Order, bool mls, bool Local>
void gather(TransferBlock<Real>& b, const Scheme& scheme) {
    using P = Pack<Real>;
    constexpr bool gradient = Local && !mls;
    constexpr bool moment = Scheme::affine || (Local && mls);
    const Real inverse_spacing = 1 / b.spacing;
    const Real moment_scale = inverse_spacing * Real(1 / kCarriedMoment<Order>);
    P fastest(0), total(0);
    for_each_batch(b.size, [&](std::size_t first, std::size_t size) {
        Stencils<Real, Order> s;
        LaneWeights<Real, Order, gradient> weight;
        Samples<Real, gradient, moment> now;
        Samples<Real, false, false> before;
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            P x[3];
            for (int c = 0; c < 3; ++c)
                x[c] = load(b.x[c] + first + p, std::min(kLanes<Real>, size - p)) * inverse_spacing;
            if constexpr (Local) {
                const std::size_t ahead = first + p + kAhead;
                for (int c = 0; c < 3; ++c) __builtin_prefetch(b.x[c] + ahead, 0, 2);
                for (int c = 0; c < 9; ++c) __builtin_prefetch(b.F[c] + ahead, 0, 2);
            }
            s.set(p, x, b.origin, [&](const auto* splines) { weight.store(p, splines); });
        }
        sample_tile(b.tile, s, weight, now, size);
        if constexpr (Scheme::increment) sample_tile(b.increment, s, weight, before, size);
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            const std::size_t at = first + p, count = std::min(kLanes<Real>, size - p);
            P v[3], speed2(0);
            for (int c = 0; c < 3; ++c) {
                v[c] = now.v[c].pack(p);
                const P old = Scheme::increment ? before.v[c].pack(p) : P(0);
                store(b.x[c] + at, P(load(b.x[c] + at, count) + b.dt * v[c]), count);
                store(b.v[c] + at, scheme.velocity(load(b.v[c] + at, count), v[c], old), count);
                speed2 += v[c] * v[c];
            }
            where(!first_lanes<Real>(count), speed2) = P(0);
            fastest = larger(fastest, speed2);
            total += speed2;
            P G[3][3], M[3][3];  // [component][direction]
            for (int j = 0; j < 3; ++j)
                for (int c = 0; c < 3; ++c) {
                    if constexpr (gradient) G[c][j] = inverse_spacing * now.gradient[j][c].pack(p);
                    if constexpr (moment)
                        M[c][j] = moment_scale * (now.moment[j][c].pack(p) - s.offset[j].pack(p) * v[c]);
                    if constexpr (Scheme::affine) store(b.C[3 * c + j] + at, M[c][j], count);
                }
            if constexpr (Local) {
                for (int c = 0; c < 9; ++c) G[c / 3][c % 3] = b.dt * (mls ? M[c / 3][c % 3] : G[c / 3][c % 3]);
                update_deformation(b.F, at, count, G);
            }
        }
    });
    b.fastest2 = hmax(fastest);
    b.sum2 = reduce(total);
}

}  // namespace perimpm::bspline
