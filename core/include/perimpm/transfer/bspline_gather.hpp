#pragma once

#include "perimpm/transfer/stencils.hpp"

/*! Grid to particles: the velocity, its gradient and its first moments
      (1) v = sum_I w_I v_I,   G_j = sum_I v_I dw_I/dx_j,   M_j = sum_I w_I v_I d_Ij
    contracted along y, x and z in turn; M is taken about the stencil's first node and moved to the particle afterwards,
    M_j = sum_I w_I v_I (node index)_j - offset_j v. Lanes are (z-node) x (velocity); the columns of a cell are loaded once
    for all its particles. */
namespace perimpm::bspline {

/// What a batch of particles reads from one tile, the moments about the stencil's first node.
template <class Real, bool Gradient, bool Moment>
struct Samples {
    Quads<Real> v;
    Quads<Real> gradient[Gradient ? 3 : 1], moment[Moment ? 3 : 1];
};

template <bool Gradient, bool Moment, class Real, int Order, bool Slopes>
void sample_tile(const Real* tile, const Stencils<Real, Order, Slopes>& s, Samples<Real, Gradient, Moment>& out,
                 std::size_t size) {
    using C = Column<Real>;
    constexpr int n = Order + 1;
    const C k = C::index();
    for_each_cell(s.node, size, [&](std::size_t p, std::size_t end, std::int32_t node) {
        C column[n][n];
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) column[i][j] = C::load(tile + node + i * kSlabStride + j * kRowStride);
        for (; p < end; ++p) {
            const std::size_t at = Quads<Real>::place(p);
            const Real *wx = s.weight[0].at(at), *wy = s.weight[1].at(at);
            const Real *dx = Gradient ? s.slope[0].at(at) : wx, *dy = Gradient ? s.slope[1].at(at) : wy;
            C value = {}, gx = {}, gy = {}, mx = {}, my = {};
            for (int i = 0; i < n; ++i) {
                C c = {}, cg = {}, cm = {};
                for (int j = 0; j < n; ++j) {
                    c += wy[j] * column[i][j];
                    if constexpr (Gradient) cg += dy[j] * column[i][j];
                    if constexpr (Moment)
                        if (j > 0) cm += (static_cast<Real>(j) * wy[j]) * column[i][j];
                }
                value += wx[i] * c;
                if constexpr (Gradient) gx += dx[i] * c, gy += wx[i] * cg;
                if constexpr (Moment) {
                    if (i > 0) mx += (static_cast<Real>(i) * wx[i]) * c;
                    my += wx[i] * cm;
                }
            }
            const C wz = C::spread(s.weight[2].at(at)), v = wz * value;
            if constexpr (Moment) {
                const C sums[4] = {v, wz * mx, wz * my, k * v};
                store_node_sums<Real>(sums,
                                      {out.v.at(at), out.moment[0].at(at), out.moment[1].at(at), out.moment[2].at(at)});
            }
            if constexpr (Gradient) {
                const C sums[4] = {v, wz * gx, wz * gy, C::spread(s.slope[2].at(at)) * value};
                store_node_sums<Real>(
                    sums, {out.v.at(at), out.gradient[0].at(at), out.gradient[1].at(at), out.gradient[2].at(at)});
            }
            if constexpr (!Gradient && !Moment) store_node_sum<Real>(v, out.v.at(at));
        }
    });
}

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
    constexpr bool moment = Order > 1 && (Scheme::affine || (Local && mls));
    constexpr bool gradient = (Local && !mls) || (Scheme::affine && Order == 1);
    const Real inverse_spacing = 1 / b.spacing;
    const Real moment_scale = inverse_spacing * Real(1 / kSecondMoment<Order>);
    P fastest(0), total(0);
    for_each_batch(b.size, [&](std::size_t first, std::size_t size) {
        Stencils<Real, Order, gradient> s;
        Samples<Real, gradient, moment> now;
        Samples<Real, false, false> before;
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            P x[3];
            for (int c = 0; c < 3; ++c)
                x[c] = load(b.x[c] + first + p, std::min(kLanes<Real>, size - p)) * inverse_spacing;
            s.set(p, x, b.origin);
        }
        sample_tile<gradient, moment>(b.tile, s, now, size);
        if constexpr (Scheme::increment) sample_tile<false, false>(b.increment, s, before, size);
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            const std::size_t at = first + p, count = std::min(kLanes<Real>, size - p);
            P v[4], old[4] = {}, speed2(0);
            now.v.load(p, v);
            if constexpr (Scheme::increment) before.v.load(p, old);
            for (int c = 0; c < 3; ++c) {
                store(b.x[c] + at, P(load(b.x[c] + at, count) + b.dt * v[c]), count);
                store(b.v[c] + at, scheme.velocity(load(b.v[c] + at, count), v[c], old[c]), count);
                speed2 += v[c] * v[c];
            }
            where(!first_lanes<Real>(count), speed2) = P(0);
            fastest = larger(fastest, speed2);
            total += speed2;
            P G[3][3], M[3][3];  // [component][direction]
            for (int j = 0; j < 3; ++j) {
                P quad[4], offset;
                if constexpr (gradient) {
                    now.gradient[j].load(p, quad);
                    for (int c = 0; c < 3; ++c) G[c][j] = inverse_spacing * quad[c];
                }
                if constexpr (moment) {
                    now.moment[j].load(p, quad);
                    offset.copy_from(s.offset[j] + p, std::experimental::element_aligned);
                    for (int c = 0; c < 3; ++c) M[c][j] = moment_scale * (quad[c] - offset * v[c]);
                }
                for (int c = 0; Scheme::affine && c < 3; ++c)
                    store(b.C[3 * c + j] + at, Order > 1 ? M[c][j] : G[c][j], count);
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
