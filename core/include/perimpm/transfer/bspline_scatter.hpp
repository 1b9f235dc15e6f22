#pragma once

#include "perimpm/transfer/stencils.hpp"

/*! Particles to grid. A particle adds to node I of its stencil
      (1) w_I (q + A d_I) + S grad w_I,    d_I from particle to node in dx, q = (momentum, mass), A and S in columns
    w_I = wx_i wy_j wz_k. With q moved to the stencil's first node, q' = q - A offset, column (i, j) gets
      (2) (wx_i wy_j) (b + i wz A_x + j wz A_y) + (dwx_i wy_j) wz S_x + (wx_i dwy_j) wz S_y,   b = wz (q' + k A_z) + dwz S_z
    Lanes are (z-node k) x (momentum, mass). All columns of a cell stay in registers while its particles pass. */
namespace perimpm::bspline {

/// Weights by particle in quads: those along z, and products of those along x and y, row i in quad i.
template <class Real, int Order, bool Slopes>
struct QuadWeights {
    Quads<Real> z, xy[Order + 1];
    Quads<Real> dz, dx_y[Slopes ? Order + 1 : 1], x_dy[Slopes ? Order + 1 : 1];  ///< d: d weight / d x in 1/dx

    PERIMPM_INLINE void store(std::size_t p, const Splines<Real, Order>& splines) {
        const auto &x = splines.axis[0], &y = splines.axis[1];
        const auto store_row = [&](Quads<Real>& row, const Pack<Real>& a, const Pack<Real> b[4]) PERIMPM_INLINE_LAMBDA {
            const Pack<Real> products[4] = {a * b[0], a * b[1], a * b[2], a * b[3]};
            row.store(p, products);
        };
        z.store(p, splines.axis[2].w);
        if constexpr (Slopes) dz.store(p, splines.axis[2].dw);
        unrolled<Order + 1>([&](auto i) PERIMPM_INLINE_LAMBDA {
            store_row(xy[i], x.w[i], y.w);
            if constexpr (Slopes) store_row(dx_y[i], x.dw[i], y.w), store_row(x_dy[i], x.w[i], y.dw);
        });
    }
};

/// What a batch of particles adds to one tile.
template <class Real, bool Linear, bool Stress>
struct Deposit {
    Quads<Real> q;  ///< q' in (2)
    Quads<Real> A[Linear ? 3 : 1], S[Stress ? 3 : 1];
};

template <bool Linear, bool Stress, class Real, int Order, bool Slopes>
void add_to_tile(Real* tile, const Real* nodes, const QuadWeights<Real, Order, Slopes>& weight,
                 const Deposit<Real, Linear, Stress>& d, std::size_t size) {
    using C = Column<Real>;
    constexpr int n = Order + 1;
    const C k = C::index();
    for_each_cell(nodes, size, [&](std::size_t p, std::size_t end, std::int32_t node) {
        C sum[n][n] = {};
        for (; p < end; ++p) {
            const std::size_t at = Quads<Real>::place(p);
            const C wz = C::spread(weight.z.at(at));
            C b = wz * C::repeat(d.q.at(at)), Ax, Ay, Sx, Sy;
            if constexpr (Linear) {
                b += k * wz * C::repeat(d.A[2].at(at));
                Ax = rounded(wz * C::repeat(d.A[0].at(at))), Ay = rounded(wz * C::repeat(d.A[1].at(at)));
            }
            if constexpr (Stress) {
                b += C::spread(weight.dz.at(at)) * C::repeat(d.S[2].at(at));
                Sx = wz * C::repeat(d.S[0].at(at)), Sy = wz * C::repeat(d.S[1].at(at));
            }
            for (int i = 0; i < n; ++i) {
                C value = b;
                for (int j = 0; j < n; ++j) {
                    sum[i][j] += weight.xy[i].at(at)[j] * value;
                    if constexpr (Stress)
                        sum[i][j] += weight.dx_y[i].at(at)[j] * Sx, sum[i][j] += weight.x_dy[i].at(at)[j] * Sy;
                    if constexpr (Linear) value += Ay;
                }
                if constexpr (Linear) b += Ax;
            }
        }
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                Real* to = tile + node + i * kSlabStride + j * kRowStride;
                (C::load(to) + sum[i][j]).store(to);
            }
    });
}

/// Scheme::affine adds m C d to the momentum, with linear splines m B grad w_I (B is C dx^2 there);
/// Scheme::increment keeps impulses apart so that the grid knows the velocity before forces. With `mls` the stress goes
/// into A (Hu et al. 2018, eq. 16), else into S.
template <class Scheme, class Real, int Order, bool mls, bool Local>
void scatter(TransferBlock<Real>& b) {
    using P = Pack<Real>;
    constexpr bool together = !Scheme::increment, stress = Local && !mls;
    constexpr bool affine = Scheme::affine && Order > 1, affine_slopes = Scheme::affine && Order == 1;
    constexpr bool slopes = stress || affine_slopes;
    constexpr bool total_A = affine || (together && Local && mls), total_S = affine_slopes || (together && stress);
    const Real dt = b.dt, spacing = b.spacing, inverse_spacing = 1 / spacing;
    for_each_batch(b.size, [&](std::size_t first, std::size_t size) PERIMPM_INLINE_LAMBDA {
        alignas(64) Real node[kBatch];
        QuadWeights<Real, Order, slopes> weight;
        Deposit<Real, total_A, total_S> total;
        Deposit<Real, Local && mls, stress> impulse;
        for (std::size_t p = 0; p < size; p += kLanes<Real>) {
            const std::size_t at = first + p, count = std::min(kLanes<Real>, size - p);
            const auto of = [&](const Real* field) PERIMPM_INLINE_LAMBDA { return load(field + at, count); };
            const Splines<Real, Order> splines(b.x, at, count, inverse_spacing);
            splines.node(b.origin).copy_to(node + p, std::experimental::element_aligned);
            weight.store(p, splines);
            const P m = of(b.mass), m_dx = m * spacing;
            P scale(0), q[4] = {m * of(b.v[0]), m * of(b.v[1]), m * of(b.v[2]), m}, f[4] = {};
            if constexpr (Local)
                scale = Real(mls ? -1 / kSecondMoment<Order> : -1) * dt * inverse_spacing * of(b.volume);
            unrolled<3>([&](auto c) PERIMPM_INLINE_LAMBDA {
                if constexpr (!Local) f[c] = dt * of(b.force[c]);
                if constexpr (!Local && together) q[c] += f[c];
            });
            unrolled<3>([&](auto j) PERIMPM_INLINE_LAMBDA {  // columns j
                const P offset = splines.axis[j].offset;
                P A[4] = {}, S[4] = {}, G[4] = {};
                unrolled<3>([&](auto c) PERIMPM_INLINE_LAMBDA {
                    constexpr int component[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
                    if constexpr (Scheme::affine) (affine ? A : S)[c] = m_dx * of(b.C[3 * c + j]);
                    if constexpr (Local) G[c] = scale * of(b.tau[component[j][c]]);
                    if constexpr (Local && together) (mls ? A : S)[c] += G[c];
                    if constexpr (total_A) q[c] -= A[c] * offset;
                    if constexpr (Local && mls && !together) f[c] -= G[c] * offset;
                });
                if constexpr (total_A) total.A[j].store(p, A);
                if constexpr (total_S) total.S[j].store(p, S);
                if constexpr (!together && Local && mls) impulse.A[j].store(p, G);
                if constexpr (!together && stress) impulse.S[j].store(p, G);
            });
            total.q.store(p, q);
            if constexpr (!together) impulse.q.store(p, f);
        }
        add_to_tile<total_A, total_S>(b.tile, node, weight, total, size);
        if constexpr (!together) add_to_tile<Local && mls, stress>(b.increment, node, weight, impulse, size);
    });
}

}  // namespace perimpm::bspline
